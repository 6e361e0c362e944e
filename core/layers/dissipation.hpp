// What laws dissipate: D = (Q - dE/dq) q' - dE/dz z' of a law with an energy, Q q' of a viscosity function without.
// Outside the hot path.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// At a state. Members are the springs and then the elements; removed ones keep what they had.
struct Losses {
  double time = 0.0;  // s
  // Of the spring function and the viscosity function, [law][member]: Q - dE/dq, what of the force derives from no
  // energy (nan: the law failed), and the rate at which it does work, q' or |v|.
  std::array<std::vector<double>, 2> force, rate;
  std::vector<double> q;  // [member]
  // Of elements whose laws read several scalars, in place of these: Q_i - dE/dq_i, q_i and q_i'.
  struct Several {
    std::array<double, max_scalars> force[2], rate, q;
  };
  std::vector<Several> several;  // [element]; empty: there are none
  // In the places of InternalLayout.
  std::vector<double> states, rates, energy_by_states;
};
void evaluate_losses(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, Losses& out);

// W; nan where a spring function has no energy, or a law failed. out: [spring_count]; removed springs add nothing.
void add_spring_dissipations(const Layout& layout, const Losses& losses, double* out);
// Of one live element.
[[nodiscard]] double element_dissipation(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                         std::uint32_t element);
// Of all laws of live members whose dissipation is known, W.
[[nodiscard]] double known_dissipation(const Layout& layout, const Losses& losses);
// What these dissipate in a step from one state to another, J. By the trapezoidal rule, over q and z rather than time:
// exact where E is quadratic in z and R linear in q, however fast they change within the step.
[[nodiscard]] double known_dissipation(const Layout& layout, const Losses& start, const Losses& end);

}  // namespace springnet::layers
