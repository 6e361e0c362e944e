#include "view/learned.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <springnet/error.hpp>

#include "view/blocks.hpp"

namespace springnet::view {

namespace {

constexpr double value_bytes = 4.0 + 6.0 * 4.0;        // place; start, value, ends, two shares
constexpr double point_bytes = 4.0 + 3.0 * 4.0 + 1.0;  // node; x, y, z; what

// What the page's program reads: 0 position, 1 velocity, 2 force, and 4 more if it was held out.
std::uint8_t kind_of(const ViewPoint& point) {
  return static_cast<std::uint8_t>(static_cast<unsigned>(point.what) + (point.held_out ? 4 : 0));
}

// What is not known has no interval: nan. Other numbers beyond the range of float become its largest.
float float_of(double number) {
  return std::isfinite(number) ? to_float(number) : std::numeric_limits<float>::quiet_NaN();
}

// Elements that have a value and whose nodes are shown, ascending.
std::vector<ElementIndex> drawn_elements(const Content& content) {
  std::set<ElementIndex> found;
  for (const ViewValues& each : content.learned->values) {
    if (each.of != ViewValues::Of::elements) continue;
    for (const ViewValues::Value& value : each.values) {
      const std::vector<NodeIndex>& nodes = content.scene.network.elements()[value.member].nodes;
      if (std::all_of(nodes.begin(), nodes.end(),
                      [&](NodeIndex node) { return content.selection.node_place[node] != not_shown; }))
        found.insert(value.member);
    }
  }
  return {found.begin(), found.end()};
}

void write_elements(std::ostream& out, const Content& content, const std::vector<ElementIndex>& elements) {
  std::vector<std::uint32_t> first, nodes;
  for (const ElementIndex k : elements) {
    first.push_back(static_cast<std::uint32_t>(nodes.size()));
    for (const NodeIndex node : content.scene.network.elements()[k].nodes)
      nodes.push_back(content.selection.node_place[node]);
  }
  first.push_back(static_cast<std::uint32_t>(nodes.size()));
  write_block(out, "learned_elements", elements);
  write_block(out, "learned_element_first", first);
  write_block(out, "learned_element_nodes", nodes);
}

std::uint32_t place_of(const ViewValues& values, std::uint32_t member, const Selection& selection,
                       const std::vector<ElementIndex>& elements) {
  switch (values.of) {
    case ViewValues::Of::springs:
      return selection.spring_place[member];
    case ViewValues::Of::nodes:
      return selection.node_place[member];
    case ViewValues::Of::elements:
      break;
  }
  const auto at = std::lower_bound(elements.begin(), elements.end(), member);
  return at != elements.end() && *at == member ? static_cast<std::uint32_t>(at - elements.begin()) : not_shown;
}

std::vector<double> times_of(const Frames& frames) {
  const std::vector<double>& all = frames.scalars.numbers();
  const std::size_t width = all.size() / std::max<std::size_t>(frames.count(), 1);
  std::vector<double> times;
  for (std::size_t k = 0; k < frames.count(); ++k) times.push_back(all[k * width + time]);
  return times;
}

std::size_t nearest(const std::vector<double>& times, double wanted) {
  const auto after = std::lower_bound(times.begin(), times.end(), wanted);
  if (after == times.begin()) return 0;
  const auto k = static_cast<std::size_t>(after - times.begin());
  return after == times.end() || wanted - times[k - 1] <= times[k] - wanted ? k - 1 : k;
}

}  // namespace

void check(const LearnedView& learned, const Network& network) {
  const auto refuse = [](const char* what, std::uint32_t member, std::size_t count) {
    throw Error(ErrorKind::input, fmt::format("the page of what was learned: there is no {} {}; the network has {}",
                                              what, member, count));
  };
  for (const ViewValues& values : learned.values) {
    const bool of_nodes = values.of == ViewValues::Of::nodes, of_elements = values.of == ViewValues::Of::elements;
    const std::size_t count = of_nodes      ? network.nodes().size()
                              : of_elements ? network.elements().size()
                                            : network.springs().size();
    for (const ViewValues::Value& each : values.values)
      if (each.member >= count) refuse(of_nodes ? "node" : of_elements ? "element" : "spring", each.member, count);
  }
  for (const ViewPoint& each : learned.observed)
    if ((each.node != ViewPoint::no_node || each.what != ViewPoint::What::position) &&
        each.node >= network.nodes().size())
      refuse("node", each.node, network.nodes().size());
}

double values_bytes(const Content& content) {
  double bytes = 0.0;
  for (const ViewValues& each : content.learned->values) bytes += value_bytes * static_cast<double>(each.values.size());
  for (const ElementIndex k : drawn_elements(content))
    bytes += 8.0 + 4.0 * static_cast<double>(content.scene.network.elements()[k].nodes.size());
  return bytes;
}

double observed_bytes(const LearnedView* learned) {
  if (learned == nullptr) return 0.0;
  std::set<std::pair<NodeIndex, std::uint8_t>> nodes;
  std::map<std::pair<std::uint8_t, double>, std::size_t> others;
  for (const ViewPoint& each : learned->observed) {
    if (each.node == ViewPoint::no_node) {
      ++others[{kind_of(each), each.time}];
    } else {
      nodes.insert({each.node, kind_of(each)});
    }
  }
  std::map<std::uint8_t, std::size_t> most;
  for (const auto& [of, count] : others) most[of.first] = std::max(most[of.first], count);
  std::size_t points = nodes.size();
  for (const auto& [kind, count] : most) points += count;
  return 4.0 + point_bytes * static_cast<double>(points);
}

double learned_cost(const LearnedView& learned, const Network& network, double frames) {
  double bytes = frames * (6.0 * static_cast<double>(network.nodes().size()) + observed_bytes(&learned));
  for (const ViewValues& each : learned.values) bytes += value_bytes * static_cast<double>(each.values.size());
  return bytes / std::max(frames * static_cast<double>(network.springs().size()), 1.0);
}

ObservedFrames observed_frames(const LearnedView& learned, const std::vector<double>& times,
                               const Selection& selection) {
  // Of each frame, and of each kind: the nearest of each node; and those without a node, of the nearest time that has
  // any.
  struct Frame {
    std::map<std::pair<NodeIndex, std::uint8_t>, const ViewPoint*> nodes;
    std::map<std::uint8_t, std::vector<const ViewPoint*>> others;
  };
  std::vector<Frame> frames(times.size());
  for (const ViewPoint& each : learned.observed) {
    const std::size_t k = nearest(times, each.time);
    const double gap = std::abs(each.time - times[k]);
    if (each.node != ViewPoint::no_node) {
      const ViewPoint*& known = frames[k].nodes[{each.node, kind_of(each)}];
      if (known == nullptr || gap < std::abs(known->time - times[k])) known = &each;
      continue;
    }
    std::vector<const ViewPoint*>& others = frames[k].others[kind_of(each)];
    if (!others.empty() && others.front()->time != each.time) {
      if (gap >= std::abs(others.front()->time - times[k])) continue;
      others.clear();
    }
    others.push_back(&each);
  }
  ObservedFrames result;
  const auto add = [&](const ViewPoint& point, std::uint32_t node) {
    result.nodes.push_back(node);
    result.kinds.push_back(kind_of(point));
    for (const double x : point.point) result.points.push_back(to_float(x));
  };
  for (const Frame& frame : frames) {
    result.first.push_back(static_cast<std::uint32_t>(result.nodes.size()));
    for (const auto& [of, point] : frame.nodes) add(*point, selection.node_place[of.first]);
    for (const auto& [kind, points] : frame.others)
      for (const ViewPoint* const point : points) add(*point, not_shown);
  }
  result.first.push_back(static_cast<std::uint32_t>(result.nodes.size()));
  return result;
}

void write_learned(std::ostream& out, const Content& content) {
  const LearnedView& learned = *content.learned;
  const std::vector<ElementIndex> elements = drawn_elements(content);
  write_elements(out, content, elements);
  for (std::size_t k = 0; k < learned.values.size(); ++k) {
    std::vector<std::uint32_t> places;
    std::vector<float> numbers;
    for (const ViewValues::Value& each : learned.values[k].values) {
      const std::uint32_t place = place_of(learned.values[k], each.member, content.selection, elements);
      if (place == not_shown) continue;
      places.push_back(place);
      const bool has = each.has_interval;
      for (const double number : {each.start, each.value, has ? each.lower : std::nan(""),
                                  has ? each.upper : std::nan(""), each.determined, each.from_guess})
        numbers.push_back(float_of(number));
    }
    write_block(out, fmt::format("learned{}_places", k), places);
    write_block(out, fmt::format("learned{}_numbers", k), numbers);
  }
  const ObservedFrames observed = observed_frames(learned, times_of(content.frames), content.selection);
  write_block(out, "observed_first", observed.first);
  write_block(out, "observed_nodes", observed.nodes);
  write_block(out, "observed_points", observed.points);
  write_block(out, "observed_kinds", observed.kinds);
}

}  // namespace springnet::view
