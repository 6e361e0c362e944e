#include "learning/straight_angles.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "layers/elements/blocks.hpp"
#include "layers/elements/queries.hpp"

namespace springnet::learning {
namespace {

// Of forces; and of angles (rad), which count as straight so far away.
constexpr double rounding_of_force = 1e-9, nearly_straight = 2e-7;

}  // namespace

void check_straight_angles(Engine& engine, double time, const layers::NodeArrays& nodes,
                           const std::vector<std::uint32_t>& with_start_velocities) {
  const layers::Layout& layout = engine.model().layout;
  const layers::ElementLayout& elements = layout.elements();
  std::vector<std::uint8_t> has(layout.node_count(), 0);
  for (const std::uint32_t node : with_start_velocities) has[node] = 1;
  for (std::uint32_t e = 0; e < elements.count(); ++e) {
    if (!elements.alive(e) || elements.invariant(e) != Invariant::angle) continue;
    const std::span<const std::uint32_t> own = elements.nodes(e);
    if (std::none_of(own.begin(), own.end(), [&](std::uint32_t node) { return has[node] != 0; })) continue;
    layers::Corners corners;
    layers::BentDirections bent;
    layers::gather(own.data(), own.size(), nodes, corners);
    if (!layers::is_straight(Invariant::angle, corners, bent)) continue;
    const layers::ElementState state = layers::element_state(layout, nodes, e);
    layers::PairAnswers<1> answers;
    springnet_message message{};
    if (layers::evaluate_element(layout, engine.model().evaluator.instruction_set(), time, nodes, e, state,
                                 answers.outputs(true, false), message) != SPRINGNET_OK)
      continue;  // the motion tells
    const layers::ElementForce law = layers::element_force(layout.laws().groups[elements.group(e)], answers, 0, true);
    const double viscous = law.by_rate * state.rate;
    const double negligible =
        rounding_of_force * (std::abs(law.force) + std::abs(viscous)) + nearly_straight * std::abs(law.by_q);
    if (std::abs(law.force - viscous) <= negligible) continue;
    throw Error(ErrorKind::input,
                fmt::format("learning: element {}, an angle, is exactly straight at the start, where its laws answer "
                            "{:.3g} N m: in which direction they bend it follows the velocities of its nodes, which "
                            "are learned, without the derivative that is needed. Bend it a little, set theta = 1, or "
                            "leave the velocities of its nodes as they are known",
                            e, law.force));
  }
}

}  // namespace springnet::learning
