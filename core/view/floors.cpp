#include "view/floors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "layers/law_pair.hpp"
#include "view/content.hpp"

namespace springnet::view {

namespace {

// A few roundings, for differences and sums of a few numbers.
constexpr double relative_floor = 8.0 * std::numeric_limits<double>::epsilon();

double largest_coordinate(const Network& network) {
  double largest = 0.0;
  for (const Node& node : network.nodes()) largest = std::max(largest, node.position.cwiseAbs().maxCoeff());
  return largest;
}

// dT/dl of each spring at its rest length, N/m; 0 if its law has no derivatives.
std::vector<double> stiffnesses(const Network& network, const PluginHost& plugins) {
  const layers::CompiledLaws laws = layers::compile_laws(network, plugins);
  std::vector<double> found(network.springs().size(), 0.0);
  for (std::size_t k = 0; k < found.size(); ++k) {
    const layers::Group& group = laws.groups[laws.group[k]];
    if (!group.spring.can(SPRINGNET_HAS_DERIVATIVES)) continue;
    const double rest = network.springs()[k].rest_length, rate = 0.0;
    double force = 0.0, by_length = 0.0;
    layers::PairOutputs out{};  // of the spring function alone
    out[0].force = &force;
    out[0].by_q = &by_length;
    springnet_message message{};
    if (layers::evaluate_laws({group, 1, {nullptr, laws.row[k]}, &rest, &rate, &rest}, InstructionSet::generic, 0.0,
                              out, message) == SPRINGNET_OK &&
        std::isfinite(by_length)) {
      found[k] = std::abs(by_length);
    }
  }
  return found;
}

template <class Number>
void drop_below(std::span<Number> row, const auto& floor_at) {
  Number largest = 0;
  for (const Number value : row) largest = std::max(largest, std::abs(value));
  const double frame_floor = relative_floor * static_cast<double>(largest);
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (static_cast<double>(std::abs(row[k])) <= std::max(frame_floor, floor_at(k))) row[k] = 0;
  }
}

}  // namespace

Floors floors_of(const Scene& scene, const Selection& selection, const PluginHost* plugins) {
  const Network& network = scene.network;
  const double largest = largest_coordinate(network);
  Floors floors;
  floors.position = relative_floor * largest;
  floors.speed = floors.position / std::max(scene.output.interval, scene.options.time_step);
  for (const Node& node : network.nodes()) {
    if (!node.fixed) floors.kinetic += 0.5 * node.mass * floors.speed * floors.speed;
    floors.potential += relative_floor * node.mass * network.gravity().norm() * node.position.norm();
  }
  floors.tension.assign(selection.springs.size(), 0.0F);
  if (plugins == nullptr) return floors;
  const std::vector<double> stiffness = stiffnesses(network, *plugins);
  for (std::size_t k = 0; k < stiffness.size(); ++k) {
    const double rounding = relative_floor * std::max(largest, network.springs()[k].rest_length);
    floors.potential += 0.5 * stiffness[k] * rounding * rounding;
    if (selection.spring_place[k] != not_shown) {
      floors.tension[selection.spring_place[k]] = static_cast<float>(stiffness[k] * rounding);
    }
  }
  return floors;
}

void drop_rounding(const Floors& floors, Frames& frames) {
  for (std::size_t frame = 0; frame < frames.count(); ++frame) {
    drop_below(frames.positions.row(frame), [&](std::size_t) { return floors.position; });
    drop_below(frames.speeds.row(frame), [&](std::size_t) { return floors.speed; });
    drop_below(frames.tensions.row(frame), [&](std::size_t k) { return static_cast<double>(floors.tension[k]); });
    const std::span<double> scalars = frames.scalars.row(frame);
    drop_below(scalars.subspan(kinetic, 1), [&](std::size_t) { return floors.kinetic; });
    drop_below(scalars.subspan(potential, 1), [&](std::size_t) { return floors.potential; });
  }
}

}  // namespace springnet::view
