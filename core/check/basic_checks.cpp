// call, arrays, rest: whether a law can be called at all, and whether it is at rest where it says so.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

#include <fmt/format.h>

#include "check/child.hpp"
#include "check/instruction_sets.hpp"
#include "check/law_checks.hpp"
#include "check/sharing.hpp"

namespace springnet::check {
namespace {

// On the coordinates of an element's nodes, up to the sign.
std::vector<double> nodal_forces(const LawCall& call, const std::vector<double>& rows, const Corners& corners) {
  const std::vector<std::vector<double>> gradients = gradients_of(call.law(), corners);
  std::vector<double> forces(3 * corners.size(), 0.0);
  for (std::size_t i = 0; i < call.layout().invariants; ++i)
    for (std::size_t k = 0; call.reads_value(i) && k < forces.size(); ++k) forces[k] += rows[i] * gradients[i][k];
  return forces;
}

}  // namespace

Outcome check_call(const LawSubject& subject) {
  now_doing("preparing its tables");
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  now_doing("starting the states of one element");
  const Point rest = ready.points().at_rest();
  now_doing("evaluating one element at rest");
  Answer answer = call({rest});
  if (answer.status == SPRINGNET_OK) {
    now_doing("evaluating the derivatives of one element at rest");
    answer = call({rest}, {.derivatives = true});
  }
  if (answer.status == SPRINGNET_OK && call.layout().states > 0) {
    now_doing("making a step of the states of one element at rest");
    answer = call({rest}, {.derivatives = true, .time_step = 1e-3});
  }
  if (answer.status != SPRINGNET_OK) return {Result::failed, "it refuses an element at rest: " + answer.message};
  return {};
}

Outcome check_arrays(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  // The greatest is more than a host has at a time.
  constexpr std::array<std::size_t, 7> counts{1, 3, 8, 19, 33, 67, 449};
  const std::vector<Point> points = ready.points().several(counts.back());
  const bool has_states = call.layout().states > 0;
  std::vector<std::uint64_t> sharings{share_nothing, share_all};
  for (const std::uint64_t mixed : mixed_sharings(call))
    if (sharings.size() < 4) sharings.push_back(mixed);
  std::size_t turn = 0;
  for (const Memory::Layout layout : {Memory::Layout::at_end, Memory::Layout::at_start}) {
    for (const InstructionSetName& set : instruction_sets()) {
      for (const std::size_t count : counts) {
        // All of a few, and of larger counts each in its turn: they are slow.
        const std::size_t tried = count <= 8 ? sharings.size() : 1;
        for (std::size_t k = 0; k < tried; ++k) {
          const std::uint64_t shared = sharings[turn++ % sharings.size()];
          const std::vector<Point> some =
              with_shared(call, {points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count)}, shared);
          for (const double step : {0.0, 1e-3}) {
            if (step > 0.0 && !has_states) continue;
            now_doing(fmt::format("{} {} elements with the instruction set {}", step > 0.0 ? "updating" : "evaluating",
                                  count, set.name)
                          .c_str());
            How how{.instruction_set = set.number,
                    .derivatives = true,
                    .shared = shared,
                    .time_step = step,
                    .layout = layout};
            const Answer answer = call(some, how);
            // A step without a solution is the matter of another check, and elements of a scene may be mixed here.
            if (answer.status == SPRINGNET_FAILED && (subject.scene == nullptr || shared == share_nothing))
              return {Result::failed, answer.message};
            how.derivatives = false;
            static_cast<void>(call(some, how));
          }
        }
      }
    }
    now_doing("starting the states");
    static_cast<void>(call.start_states(points[0], layout));
  }
  return {};
}

Outcome check_rest(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  if (call.has(SPRINGNET_NOT_ZERO_AT_REST)) return {Result::passed, "declares a force at rest"};
  const std::string declare = declaring(call.component(), "SPRINGNET_NOT_ZERO_AT_REST", "not zero at rest");
  // Rounding of the formula, in units of the force at a tenth of strain.
  constexpr double tolerance = 1e-9;
  for (std::size_t size = 0; size < Points::sizes; ++size) {
    Placed placed;
    const Point rest = ready.points().at_rest(size, &placed);
    if (!call.several() && rest[l.value()] != rest[l.reference()] && call.law().invariant != SPRINGNET_RELATIVE_SPEED)
      return {Result::passed, "a stretch of 1 is outside of its domain"};
    const std::vector<double> rows = call.rows_at(rest);
    if (!call.several()) {
      Point moved = rest;
      moved[l.value()] += 0.1 * rest[l.reference()];
      moved[l.rate()] = 0.1 * rest[l.reference()];
      const double scale = std::max(std::abs(call.rows_at(moved)[0]), 1e-300);
      if (!(std::abs(rows[0]) <= tolerance * scale))
        return {Result::failed,
                fmt::format("the force is {:.6g} {}: correct it, or {}", rows[0], place(call, rest), declare)};
      continue;
    }
    // Forces on several scalars may balance one another at the nodes. The scale is that of a tenth of strain.
    Corners strained = placed.rest;
    for (auto& corner : strained) corner[0] *= 1.1, corner[1] *= 0.95;
    Point moved = rest;
    const std::vector<double> values = scalars_of(call.law(), strained);
    for (std::size_t i = 0; i < l.invariants; ++i) {
      moved[l.value(i)] = values[i];
      moved[l.rate(i)] = values[i] - rest[l.value(i)];
    }
    // An angle at rest changes little.
    if (call.law().shape == SPRINGNET_HINGE || call.law().shape == SPRINGNET_CHAIN) moved[l.value()] += 0.1;
    const std::vector<double> at_rest = nodal_forces(call, rows, placed.rest);
    double scale = 1e-300;
    for (const double force : nodal_forces(call, call.rows_at(moved), strained))
      scale = std::max(scale, std::abs(force));
    for (std::size_t k = 0; k < at_rest.size(); ++k)
      if (!(std::abs(at_rest[k]) <= tolerance * scale))
        return {Result::failed,
                fmt::format("node {} gets the force {:.6g} {} (at a tenth of strain {:.3g}): correct it, or {}", k / 3,
                            at_rest[k], place(call, rest), scale, declare)};
  }
  return {};
}

}  // namespace springnet::check
