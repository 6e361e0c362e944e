#include "learning/observed_columns.hpp"

#include <initializer_list>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

namespace springnet::learning {
namespace {

constexpr std::size_t none = ObservedColumns::none;
using Names = std::array<const char*, 3>;
constexpr Names positions{"x", "y", "z"}, velocities{"vx", "vy", "vz"}, forces{"fx", "fy", "fz"},
    reactions{"rx", "ry", "rz"}, position_deviations{"sx", "sy", "sz"};
constexpr std::array deviations_by_quantity{"sx", "sy", "sz", "sv", "sr"};
// Of reactions.csv beside the forces; not read.
constexpr std::array beside_reactions{"tx", "ty", "tz", "jx", "jy", "jz", "surface"};
constexpr const char* tables =
    "a table has the columns time,node and any of x,y,z, vx,vy,vz and rx,ry,rz; or time,node,other,distance; or "
    "time,x,y,z (points of the surface)";

const std::vector<std::string>& known_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all{"time", "node", "other", "distance", "weight", "s", "sv", "sr"};
    for (const Names& triple : {positions, velocities, forces, reactions, position_deviations})
      all.insert(all.end(), triple.begin(), triple.end());
    all.insert(all.end(), beside_reactions.begin(), beside_reactions.end());
    return all;
  }();
  return names;
}

class Header {
 public:
  Header(const std::vector<std::string>& names, std::string_view place) : names_(names), place_(place) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorKind::input, fmt::format("{}: {}", place_, what));
  }
  [[nodiscard]] std::size_t column(std::string_view name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    return found == names_.end() ? none : static_cast<std::size_t>(found - names_.begin());
  }
  [[nodiscard]] bool has(std::string_view name) const { return column(name) != none; }
  template <class List>
  [[nodiscard]] bool has_any(const List& names) const {
    return std::any_of(names.begin(), names.end(), [&](const char* name) { return has(name); });
  }
  [[nodiscard]] std::array<std::size_t, 3> columns(const Names& names) const {
    return {column(names[0]), column(names[1]), column(names[2])};
  }

  void check_names() const {
    for (const std::string& name : names_) {
      if (std::any_of(name.begin(), name.end(), [](unsigned char byte) { return byte < ' ' && byte != '\t'; }))
        fail("this line is not text; save the table as CSV in UTF-8, with lines that end in LF or CR LF");
    }
    if (names_.size() == 1 && names_[0].find_first_of("; \t") != std::string::npos)
      fail(fmt::format("the columns are not separated by commas; save the table with commas ({})", tables));
    if (has("surface") && !has("node"))
      fail(fmt::format("this is a table of surfaces, which are not observed; {}", tables));
    for (std::size_t k = 0; k < names_.size(); ++k) {
      const std::string& name = names_[k];
      if (name.empty()) fail(fmt::format("column {} has no name; name it, or remove the column", k + 1));
      if (std::find(known_names().begin(), known_names().end(), name) == known_names().end()) {
        const std::string nearest = suggestion(name, known_names());
        const std::string remedy = nearest.empty() ? fmt::format("remove it: {}", tables)
                                                   : nearest + " Correct the name, or remove the column";
        fail(fmt::format("'{}' is no column of observations; {}", printable(name), remedy));
      }
      if (column(name) != k) fail(fmt::format("two columns are named '{}'; remove one", name));
    }
    if (!has("time")) fail(fmt::format("no column is named 'time'; {}", tables));
  }

 private:
  const std::vector<std::string>& names_;
  std::string_view place_;
};

// Whether fx,fy,fz are reactions; else they are the net forces of a trajectory, which are not read.
bool forces_are_reactions(const Header& header) {
  if (!header.has_any(forces)) return false;
  const bool as_reactions = header.has_any(beside_reactions);
  const bool as_net_forces = header.has_any(positions) || header.has_any(velocities) || header.has_any(reactions);
  if (as_reactions && as_net_forces)
    header.fail(
        "fx,fy,fz are reactions beside columns of reactions.csv and net forces beside x,y,z, vx,vy,vz or rx,ry,rz; "
        "name the reactions rx,ry,rz, and remove fx,fy,fz and the other columns of reactions.csv");
  if (!as_reactions && !as_net_forces)
    header.fail(
        "fx,fy,fz may be reactions or net forces; "
        "name reactions rx,ry,rz, and remove net forces, which are not observed");
  return as_reactions;
}

// A quantity with standard deviations in columns of its own, or in one for all its components.
struct Named {
  ObservedColumns::Quantity& quantity;
  const char* what;
  const char* deviations;
};

// Column 's' of a table whose values have no other.
std::size_t the_only_deviation(const Header& header, std::string_view values) {
  for (const char* other : deviations_by_quantity) {
    if (header.has(other))
      header.fail(fmt::format("'{}' is not of {}; name their standard deviation 's'", other, values));
  }
  return header.column("s");
}

void find_deviations(const Header& header, ObservedColumns& columns) {
  Named quantities[] = {{columns.position, "positions", "sx,sy,sz"},
                        {columns.velocity, "velocities", "sv"},
                        {columns.reaction, "reactions", "sr"}};
  columns.position.deviations = header.columns(position_deviations);
  columns.velocity.deviations.fill(header.column("sv"));
  columns.reaction.deviations.fill(header.column("sr"));
  for (std::size_t c = 0; c < 3; ++c) {
    if (columns.position.deviations[c] != none && columns.position.values[c] == none)
      header.fail(fmt::format("column '{}' is the standard deviation of '{}', which is not there; remove it",
                              position_deviations[c], positions[c]));
  }
  for (const Named& each : {quantities[1], quantities[2]}) {
    if (header.has(each.deviations) && !each.quantity.is_observed())
      header.fail(fmt::format("column '{}' is the standard deviation of {}, which are not there; remove it",
                              each.deviations, each.what));
  }
  const auto is_observed = [](const Named& each) { return each.quantity.is_observed(); };
  if (header.has("s")) {
    if (std::count_if(std::begin(quantities), std::end(quantities), is_observed) > 1)
      header.fail(
          "column 's' is the standard deviation of one quantity, and there are several; name them sx,sy,sz (of "
          "positions), sv (of velocities) and sr (of reactions)");
    for (const char* other : deviations_by_quantity)
      if (header.has(other)) header.fail(fmt::format("columns 's' and '{}' are of the same values; remove one", other));
    for (const Named& each : quantities) each.quantity.deviations.fill(header.column("s"));
  }
  // Weights of 1 have no unit: beside 1/s^2 they would mean standard deviations of 1 m or 1 m/s.
  const Named* with = nullptr;
  const Named* without = nullptr;
  for (const Named& each : quantities) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (each.quantity.values[c] == none) continue;
      (each.quantity.deviations[c] == none ? without : with) = &each;
    }
  }
  if (with != nullptr && without != nullptr)
    header.fail(fmt::format(
        "some values have a standard deviation, some of the {} have none; add {}, or put these columns into a file of "
        "their own",
        without->what, without->deviations));
}

}  // namespace

ObservedColumns observed_columns(const std::vector<std::string>& names, std::string_view place) {
  const Header header(names, place);
  header.check_names();
  ObservedColumns columns;
  columns.time = header.column("time");
  columns.node = header.column("node");
  columns.other = header.column("other");
  columns.distance = header.column("distance");
  columns.weight = header.column("weight");
  columns.position.values = header.columns(positions);
  columns.velocity.values = header.columns(velocities);
  columns.reaction.values = header.columns(forces_are_reactions(header) ? forces : reactions);

  if (!columns.reaction.is_observed()) {
    for (const char* name : beside_reactions)
      if (header.has(name)) header.fail(fmt::format("'{}' belongs to reactions, which are not there; remove it", name));
  }
  const bool of_nodes = columns.velocity.is_observed() || columns.reaction.is_observed();
  if (columns.other != none || columns.distance != none) {
    if (columns.other == none || columns.distance == none || columns.node == none)
      header.fail("distances need the columns time,node,other,distance; add those that are missing");
    if (columns.position.is_observed() || of_nodes)
      header.fail("distances are in a table with other quantities; put them into a file of their own");
    columns.deviation = the_only_deviation(header, "distances");
  } else if (columns.node == none) {
    if (of_nodes) header.fail("velocities and reactions are those of nodes; add a column 'node' with their numbers");
    const auto& point = columns.position.values;
    if (std::count(point.begin(), point.end(), none) > 0)
      header.fail(
          columns.position.is_observed()
              ? "points of the surface need all of x,y,z; add the missing ones, or a column 'node' if these are nodes"
              : fmt::format("no column says what is observed; {}", tables));
    columns.deviation = the_only_deviation(header, "points of the surface");
  } else {
    if (!columns.position.is_observed() && !of_nodes)
      header.fail(fmt::format("no column says what is observed; {}", tables));
    find_deviations(header, columns);
  }

  std::vector<std::size_t>& numbers = columns.numbers;
  numbers = {columns.time, columns.node, columns.other, columns.distance, columns.weight, columns.deviation};
  for (const ObservedColumns::Quantity* each : {&columns.position, &columns.velocity, &columns.reaction}) {
    numbers.insert(numbers.end(), each->values.begin(), each->values.end());
    numbers.insert(numbers.end(), each->deviations.begin(), each->deviations.end());
  }
  std::erase(numbers, none);
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return columns;
}

}  // namespace springnet::learning
