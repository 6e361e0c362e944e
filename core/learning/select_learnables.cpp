// "spring.stiffness@cube:together": what of a network is learned, as text.
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/error.hpp>
#include <springnet/learn.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "learning/surface_frictions.hpp"

namespace springnet {

namespace {

using Kind = LearnedValues::Kind;

struct Selection {
  std::string_view text, what, body;
  bool together = false;
  int field_degree = -1;
};

[[noreturn]] void refuse(std::string_view text, const std::string& why) {
  throw Error(ErrorKind::input, fmt::format("what is learned, '{}': {}", printable(std::string(text)), why));
}

Selection parse(std::string_view text) {
  Selection result{text, text, {}};
  if (const std::size_t at = result.what.find(':'); at != std::string_view::npos) {
    constexpr std::string_view field = ":field=";
    std::string_view how = result.what.substr(at);
    result.together = how == ":together";
    if (how.starts_with(field)) {
      how.remove_prefix(field.size());
      const auto [end, error] = std::from_chars(how.data(), how.data() + how.size(), result.field_degree);
      if (error != std::errc{} || end != how.data() + how.size() || result.field_degree < 0)
        refuse(text, "the degree of a field is a whole number, 0 or more, as in ':field=2'");
    } else if (!result.together) {
      refuse(text, "only ':together' or ':field=DEGREE' may follow a ':', at the end, behind '@BODY'");
    }
    result.what = result.what.substr(0, at);
  }
  if (const std::size_t at = result.what.find('@'); at != std::string_view::npos) {
    result.body = result.what.substr(at + 1);
    result.what = result.what.substr(0, at);
    if (result.body.empty()) refuse(text, "the name of a body follows '@'");
  }
  return result;
}

// Components that have the parameter, and declare it learnable.
class Declared {
 public:
  Declared(const PluginHost& plugins, ComponentKind kind, std::string_view name)
      : plugins_(plugins), kind_(kind), name_(name) {}
  [[nodiscard]] bool has(const std::optional<LawUse>& use) {
    if (!use) return false;
    const std::shared_ptr<const Component> component =
        use->component ? use->component : plugins_.require(kind_, use->id);
    for (std::uint32_t k = 0; k < component->description->parameter_count; ++k) {
      const springnet_parameter& each = *component->description->parameters[k];
      const bool learnable = (each.flags & SPRINGNET_LEARNABLE) != 0;
      if (learnable) known_.insert(each.name);
      if (name_ == each.name && !learnable) refuse(name_, fmt::format("'{}' does not declare it learnable", use->id));
      if (name_ == each.name) return true;
    }
    return false;
  }
  [[noreturn]] void none(std::string_view text, std::string_view whose) const {
    const std::vector<std::string> known(known_.begin(), known_.end());
    const std::string nearest = suggestion(name_, known);
    refuse(text, fmt::format("no law of {} has a parameter '{}'{}{}; learnable are: {}", whose, name_,
                             nearest.empty() ? "" : "; ", nearest,
                             known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))));
  }

 private:
  const PluginHost& plugins_;
  ComponentKind kind_;
  std::string name_;
  std::set<std::string> known_;
};

// Which springs, elements and nodes.
struct Range {
  std::size_t first = 0, last = 0;
};

struct Of {
  Range springs, elements, nodes;
  std::vector<bool> group{};  // [node] whether it is of the group; empty: of none
  [[nodiscard]] bool has_node(std::uint32_t node) const { return group.empty() || group[node]; }
};

Of of_body(const Body& body) {
  const auto range = [](std::size_t first, std::size_t count) { return Range{first, first + count}; };
  return {range(body.first_spring, body.spring_count), range(body.first_element, body.element_count),
          range(body.first_node, body.node_count)};
}

// "BODY", or "BODY/GROUP"; names may have a '/', too.
Of members_of(const Network& network, const Selection& selection) {
  if (selection.body.empty())
    return {{0, network.springs().size()}, {0, network.elements().size()}, {0, network.nodes().size()}};
  std::vector<std::string> names;
  for (const Body& body : network.bodies()) {
    if (body.name == selection.body) return of_body(body);
    for (const NodeGroup& group : body.groups) {
      names.push_back(body.name + "/" + group.name);
      if (names.back() != selection.body) continue;
      Of result = of_body(body);
      result.group.resize(network.nodes().size());
      for (const NodeIndex node : group.nodes) result.group[node] = true;
      return result;
    }
    names.push_back(body.name);
  }
  const bool is_group = selection.body.find('/') != std::string_view::npos;
  constexpr std::size_t most_listed = 20;
  if (names.empty()) refuse(selection.text, "the network has no bodies with a name; leave out '@BODY'");
  std::string known = suggestion(selection.body, names);
  if (names.size() > most_listed) names.resize(most_listed);
  if (known.empty()) known = "there are: " + printable(fmt::format("{}", fmt::join(names, ", ")));
  refuse(selection.text, fmt::format("there is no {} '{}'; {}", is_group ? "group" : "body",
                                     printable(std::string(selection.body)), known));
}

template <class Takes>
std::vector<std::uint32_t> list(const Range& range, const Takes& takes) {
  std::vector<std::uint32_t> result;
  for (std::size_t k = range.first; k < range.last; ++k)
    if (takes(static_cast<std::uint32_t>(k))) result.push_back(static_cast<std::uint32_t>(k));
  return result;
}

// Of the grammar.
namespace word {
constexpr std::string_view spring = "spring.", viscosity = "viscosity.", element = "element.", neuron = "neuron.";
constexpr std::string_view mass = "mass", velocity = "velocity", rest_length = "rest_length", reference = "reference",
                           load = "load", gravity = "gravity", friction = "friction";
}  // namespace word

std::string grammar() {
  return fmt::format(
      "write {0}NAME, {1}NAME, {2}{0}NAME, {2}{1}NAME, {3}NAME, {4}, {5}, {6}, {7}, {8}, {9} or {10}, then @BODY for "
      "one "
      "body or @BODY/GROUP for one group of it alone, and :together for one value of all, or :field=DEGREE for a "
      "smooth field",
      word::spring, word::viscosity, word::element, word::neuron, word::rest_length, word::reference, word::mass,
      word::velocity, word::load, word::gravity, word::friction);
}

// "load", or "load@2" for one, by its number.
std::vector<std::uint32_t> loads_of(const Network& network, const Selection& selection) {
  const auto count = static_cast<std::uint32_t>(network.loads().size());
  if (count == 0) refuse(selection.text, "there are no loads");
  std::vector<std::uint32_t> result;
  if (selection.body.empty()) {
    for (std::uint32_t k = 0; k < count; ++k) result.push_back(k);
    return result;
  }
  std::uint32_t number = 0;
  const char* const last = selection.body.data() + selection.body.size();
  const auto [end, error] = std::from_chars(selection.body.data(), last, number);
  if (error != std::errc{} || end != last || number >= count)
    refuse(selection.text, fmt::format("behind 'load@' stands the number of a load, 0 to {}", count - 1));
  return {number};
}

// "gravity", or "gravity@z" for one component. Together they keep their direction: components that are 0 stay so.
std::vector<std::uint32_t> axes_of_gravity(const Network& network, const Selection& selection) {
  const Vector3& gravity = network.gravity();
  if (gravity.isZero())
    refuse(selection.text, "there is no gravity; give the scene a first guess of it: [gravity] acceleration");
  constexpr std::string_view names = "xyz";
  if (!selection.body.empty() && (selection.body.size() > 1 || names.find(selection.body) == std::string_view::npos))
    refuse(selection.text, "behind 'gravity@' stands x, y or z");
  std::vector<std::uint32_t> result;
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    if ((selection.body.empty() || selection.body[0] == names[axis]) && !(selection.together && gravity[axis] == 0.0))
      result.push_back(axis);
  return result;
}

// "friction", or "friction@NAME" of one surface.
std::vector<std::uint32_t> rough_surfaces(const Network& network, const Selection& selection) {
  std::vector<std::uint32_t> result;
  std::vector<std::string> names;
  std::uint32_t number = 0;
  bool is_known = false;
  learning::for_each_surface(network, [&](const std::string& name, const Friction& friction) {
    const bool is_own = selection.body.empty() || name == selection.body;
    is_known = is_known || is_own;
    if (friction.kind == Friction::Kind::coulomb) {
      if (is_own) result.push_back(number);
      if (!name.empty()) names.push_back(name);
    }
    ++number;
  });
  if (!result.empty()) return result;
  if (names.empty() && selection.body.empty())
    refuse(selection.text,
           "no plane or instrument has a coefficient of friction; give one a first guess: friction = 0.3");
  const std::string others = names.empty() ? "" : fmt::format("; those with one are: {}", fmt::join(names, ", "));
  refuse(selection.text,
         is_known ? fmt::format("there is no coefficient of friction of '{}': give it a first guess, friction = 0.3{}",
                                printable(selection.body), others)
                  : fmt::format("there is no plane or instrument '{}'{}", printable(selection.body), others));
}

}  // namespace

Learnable select_learnable(const Network& network, const PluginHost& plugins, std::string_view text) {
  const Selection selection = parse(text);
  Learnable result;
  result.together = selection.together;
  result.field_degree = selection.field_degree;
  result.body = selection.body;
  LearnedValues& values = result.values;
  if (selection.what == word::load) {
    values.kind = Kind::load;
    values.members = loads_of(network, selection);
    return result;
  }
  if (selection.what == word::gravity) {
    values.kind = Kind::gravity;
    values.members = axes_of_gravity(network, selection);
    if (values.members.empty()) refuse(text, "this component is 0, and stays so with ':together'; leave that out");
    return result;
  }
  if (selection.what == word::friction) {
    values.kind = Kind::friction;
    values.members = rough_surfaces(network, selection);
    return result;
  }
  const Of of = members_of(network, selection);
  const auto moves = [&](std::uint32_t node) { return !network.nodes()[node].fixed; };
  // Springs and elements of a group have all of their nodes in it.
  const auto has = [&](std::uint32_t member) {
    if (of.group.empty()) return true;
    if (!values.of_elements)
      return of.has_node(network.springs()[member].first) && of.has_node(network.springs()[member].second);
    const std::vector<NodeIndex>& nodes = network.elements()[member].nodes;
    return std::all_of(nodes.begin(), nodes.end(), [&](NodeIndex node) { return of.has_node(node); });
  };
  std::string_view rest = selection.what;
  const auto starts = [&](std::string_view with) {
    if (!rest.starts_with(with)) return false;
    rest.remove_prefix(with.size());
    return true;
  };
  if (rest == word::mass || rest == word::velocity) {
    values.kind = rest == word::mass ? Kind::mass : Kind::initial_velocity;
    // Of a fixed node only reactions tell the mass, by its weight; where it has that of others, it follows them.
    const bool of_all = values.kind == Kind::mass && (result.together || result.field_degree >= 0);
    values.members = list(of.nodes, [&](std::uint32_t node) { return of.has_node(node) && (of_all || moves(node)); });
  } else if (rest == word::rest_length || rest == word::reference) {
    values.kind = Kind::rest_length;
    values.of_elements = rest == word::reference;
    values.members = list(values.of_elements ? of.elements : of.springs, has);
  } else if (starts(word::neuron)) {
    values.kind = Kind::neuron_parameter;
    values.parameter = rest;
    Declared declared(plugins, ComponentKind::neuron, rest);
    values.members = list(of.nodes, [&](std::uint32_t node) {
      return of.has_node(node) && moves(node) && declared.has(network.neurons()[network.nodes()[node].neuron]);
    });
    if (values.members.empty()) declared.none(text, "these neurons");
  } else {
    values.of_elements = starts(word::element);
    const bool is_spring = starts(word::spring);
    if (!is_spring && !starts(word::viscosity)) refuse(text, grammar());
    values.kind = is_spring ? Kind::spring_parameter : Kind::viscosity_parameter;
    values.parameter = rest;
    Declared declared(plugins, is_spring ? ComponentKind::spring_function : ComponentKind::viscosity_function, rest);
    values.members = list(values.of_elements ? of.elements : of.springs, [&](std::uint32_t member) {
      const MaterialIndex material =
          values.of_elements ? network.elements()[member].material : network.springs()[member].material;
      const Material& both = network.materials()[material];
      return declared.has(is_spring ? both.spring : both.viscosity) && has(member);
    });
    if (values.members.empty()) declared.none(text, values.of_elements ? "these elements" : "these springs");
  }
  if (values.members.empty()) refuse(text, "there is nothing of this kind");
  return result;
}

std::vector<Learnable> select_learnables(const Network& network, const PluginHost& plugins,
                                         const std::vector<std::string>& texts) {
  std::vector<Learnable> result;
  using Key = std::tuple<Kind, bool, std::string, std::uint32_t>;
  std::map<Key, std::size_t> known;  // the text that has selected it
  for (std::size_t k = 0; k < texts.size(); ++k) {
    result.push_back(select_learnable(network, plugins, texts[k]));
    const LearnedValues& values = result.back().values;
    for (const std::uint32_t member : values.members) {
      const auto [at, is_new] = known.emplace(Key{values.kind, values.of_elements, values.parameter, member}, k);
      if (is_new) continue;
      refuse(texts[k], fmt::format("{} {} is among '{}', too; learn each value once, leave out one of the two, or name "
                                   "bodies or groups that do not overlap",
                                   member_name(values.kind, values.of_elements), member, printable(texts[at->second])));
    }
  }
  return result;
}

}  // namespace springnet
