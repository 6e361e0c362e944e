#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/observations.hpp>

#include "learning/check_held_out.hpp"
#include "learning/observed_values.hpp"
#include "text/counted.hpp"

namespace springnet {
namespace {

using learning::for_each_list;
using learning::observed_values;
using VectorRow = Observations::VectorRow;
using DistanceRow = Observations::DistanceRow;
using SurfacePoint = Observations::SurfacePoint;

// When and of what the values of a row are.
struct Key {
  double time;
  NodeIndex node, other;  // of a distance the smaller one first
  std::size_t row;

  [[nodiscard]] bool is_of_same(const Key& b) const { return time == b.time && node == b.node && other == b.other; }
  friend bool operator<(const Key& a, const Key& b) {
    if (a.time != b.time) return a.time < b.time;
    if (a.node != b.node) return a.node < b.node;
    return a.other != b.other ? a.other < b.other : a.row < b.row;
  }
};
Key key_of(const VectorRow& row, std::size_t number) { return {row.time, row.node, 0, number}; }
Key key_of(const DistanceRow& row, std::size_t number) {
  return {row.time, std::min(row.node, row.other), std::max(row.node, row.other), number};
}

std::string what_of(const VectorRow& row) { return fmt::format("node {}", row.node); }
std::string what_of(const DistanceRow& row) { return fmt::format("nodes {} and {}", row.node, row.other); }

// Whether rows are ordered by time and node, as in most tables: then nothing repeats.
template <class Row>
bool is_ordered(const std::vector<Row>& rows) {
  const auto precedes = [](const Row& a, const Row& b) {
    const Key key_a = key_of(a, 0), key_b = key_of(b, 0);
    return key_a < key_b;
  };
  const auto does_not_precede = [&](const Row& a, const Row& b) { return !precedes(a, b); };
  return std::adjacent_find(rows.begin(), rows.end(), does_not_precede) == rows.end();
}

class Check {
 public:
  // learned_from: null, or of `observations` the first rows of each list; the others are held out.
  Check(const Observations& observations, std::size_t node_count, double first_time, double last_time,
        const Observations* learned_from = nullptr)
      : observations_(observations),
        learned_from_(learned_from != nullptr ? *learned_from : observations),
        node_count_(node_count),
        first_time_(first_time),
        last_time_(last_time),
        rounding_(1e-9 * std::max(std::abs(first_time), std::abs(last_time))) {}

  void all() const {
    if (observations_.value_count() == 0)
      fail_in_all(
          "nothing is observed: there is no row, or all values are missing or have the weight 0; name a table "
          "with values");
    if (!(observations_.outlier_distance > 0.0))
      fail_in_all(fmt::format("the distance of outliers is {} m; give one above 0", observations_.outlier_distance));
    check_overlap();
    for_each_list(observations_, [&](const auto& rows, const char* list) {
      for (std::size_t k = 0; k < rows.size(); ++k) {
        const auto& row = rows[k];
        const auto fail = [&](const std::string& what) { fail_at(row.place, list, k, what); };
        check_nodes(row, fail);
        check_values(row, fail);
        if (observed_values(row) != 0) check_time(row.time, fail);
      }
    });
    check_repeated(observations_.positions, learned_from_.positions.size(), "positions");
    check_repeated(observations_.velocities, learned_from_.velocities.size(), "velocities");
    check_repeated(observations_.reactions, learned_from_.reactions.size(), "reactions");
    check_repeated(observations_.distances, learned_from_.distances.size(), "distances");
  }

 private:
  [[nodiscard]] std::string place(const Observations::Place& place, const char* list, std::size_t row) const {
    const std::string text = observations_.text_of(place);
    return text.empty() ? fmt::format("{}[{}]", list, row) : text;
  }
  [[noreturn]] void fail_at(const Observations::Place& of_row, const char* list, std::size_t row,
                            const std::string& what) const {
    throw Error(ErrorKind::input, fmt::format("{}: {}", place(of_row, list, row), what));
  }
  // About all files.
  [[noreturn]] void fail_in_all(const std::string& what) const {
    constexpr std::size_t most_named = 3;
    const auto& files = observations_.files;
    std::string names = files.empty() ? "observations" : files[0].name;
    for (std::size_t k = 1; k < std::min(files.size(), most_named); ++k) names += ", " + files[k].name;
    if (files.size() > most_named) names += " and " + counted(files.size() - most_named, "other file");
    throw Error(ErrorKind::input, fmt::format("{}: {}", names, what));
  }

  [[nodiscard]] bool is_within(double time) const {
    return time >= first_time_ - rounding_ && time <= last_time_ + rounding_;
  }

  void check_overlap() const {
    double first = std::numeric_limits<double>::infinity(), last = -first;
    bool overlaps = false;
    for_each_list(observations_, [&](const auto& rows, const char*) {
      for (const auto& row : rows) {
        if (observed_values(row) == 0) continue;
        first = std::min(first, row.time);
        last = std::max(last, row.time);
        overlaps = overlaps || is_within(row.time) || !std::isfinite(row.time);
      }
    });
    if (!overlaps)
      fail_in_all(
          fmt::format("nothing is observed during the motion: the observations are from {} s to {} s, the motion "
                      "from {} s to {} s; convert their times to s, shift them, or simulate for longer",
                      first, last, first_time_, last_time_));
  }

  template <class Fail>
  void check_time(double time, const Fail& fail) const {
    if (!std::isfinite(time)) fail(fmt::format("the time is {}; give a finite one, in s", time));
    if (is_within(time)) return;
    if (time < first_time_)
      fail(fmt::format("time {} s is before the start at {} s; shift the times, or remove the row", time, first_time_));
    fail(fmt::format("time {} s is after the end at {} s; simulate for longer, or remove the row", time, last_time_));
  }

  template <class Fail>
  void check_node(NodeIndex node, const Fail& fail) const {
    if (node < node_count_) return;
    fail(fmt::format("node {} does not exist: the scene has {}, numbered from 0; correct the number, or remove the row",
                     node, counted(node_count_, "node")));
  }
  template <class Fail>
  void check_nodes(const VectorRow& row, const Fail& fail) const {
    check_node(row.node, fail);
  }
  template <class Fail>
  void check_nodes(const DistanceRow& row, const Fail& fail) const {
    check_node(row.node, fail);
    check_node(row.other, fail);
    if (row.node == row.other)
      fail(fmt::format("this is the distance of node {} to itself; correct 'node' or 'other', or remove the row",
                       row.node));
  }
  template <class Fail>
  void check_nodes(const SurfacePoint&, const Fail&) const {}

  template <class Fail>
  static void check_value(double value, double weight, const Fail& fail) {
    if (!std::isfinite(value))
      fail(fmt::format("a value is {}; give a finite one, or 0 with weight 0 for a missing one", value));
    if (!(weight >= 0.0) || std::isinf(weight))
      fail(fmt::format("a weight is {}; weights are finite and not negative", weight));
  }
  template <class Fail>
  static void check_values(const VectorRow& row, const Fail& fail) {
    for (int c = 0; c < 3; ++c) check_value(row.value[c], row.weight[c], fail);
  }
  template <class Fail>
  static void check_values(const DistanceRow& row, const Fail& fail) {
    check_value(row.distance, row.weight, fail);
    if (row.distance < 0.0) fail(fmt::format("the distance is {} m; distances are not negative", row.distance));
  }
  template <class Fail>
  static void check_values(const SurfacePoint& row, const Fail& fail) {
    for (int c = 0; c < 3; ++c) check_value(row.point[c], row.weight, fail);
  }

  // Throws for two rows that observe the same value. Those from `held_out` on are held out.
  template <class Row>
  void check_repeated(const std::vector<Row>& rows, std::size_t held_out, const char* list) const {
    if (is_ordered(rows)) return;
    std::vector<Key> keys;
    keys.reserve(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k)
      if (observed_values(rows[k]) != 0) keys.push_back(key_of(rows[k], k));
    std::sort(keys.begin(), keys.end());
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const Row& row = rows[keys[k].row];
      // Components may be in different rows, so that at most two precede this one.
      for (std::size_t before = k; before > 0 && keys[before - 1].is_of_same(keys[k]); --before) {
        const Row& earlier = rows[keys[before - 1].row];
        if ((observed_values(row) & observed_values(earlier)) == 0) continue;
        const std::string first = place(earlier.place, list, keys[before - 1].row);
        if (keys[before - 1].row < held_out && keys[k].row >= held_out)
          fail_at(row.place, list, keys[k].row,
                  fmt::format("{} of {} at {} s are held out and learned from as well, in {}; what judges must not be "
                              "learned from: hold out other rows than those of the observations",
                              list, what_of(row), row.time, first));
        fail_at(row.place, list, keys[k].row,
                fmt::format("{} of {} at {} s are observed a second time, after {}; remove one of the rows", list,
                            what_of(row), row.time, first));
      }
    }
  }

  const Observations &observations_, &learned_from_;
  std::size_t node_count_;
  double first_time_, last_time_, rounding_;  // s
};

}  // namespace

void check_observations(const Observations& observations, std::size_t node_count, double first_time, double last_time) {
  Check(observations, node_count, first_time, last_time).all();
}

namespace learning {

void check_held_out(const Observations& learned_from, const Observations& held_out, std::size_t node_count) {
  Observations both = learned_from;
  both.append(held_out);
  Check(both, node_count, 0.0, both.times().back(), &learned_from).all();
}

}  // namespace learning

}  // namespace springnet
