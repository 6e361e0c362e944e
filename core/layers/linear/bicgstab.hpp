// BiCGSTAB (H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13, 1992), preconditioned from the left: every vector is a
// change that constraints allow.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "layers/linear/conjugate_gradients.hpp"

namespace springnet::layers {

// Iterations, besides as many as before, that make a residual small after the preconditioned one.
inline constexpr std::uint32_t more_bicgstab_iterations = 10;

// Solves S x = b, run by all threads of a team. The space is as for conjugate_gradients(), and knows besides
//   product(team, p, q)   q = S p
//   add(team, s, x, y)    y += s x
//   mass_square(team, r)  by which the preconditioned residual is measured
// residual(): what the accuracy is of, relative, once the preconditioned residual is as small; none: of that itself.
template <class Space, class Number, class Residual>
[[nodiscard]] SolveAnswer bicgstab(Space& space, Team& team, double accuracy, std::uint32_t max_iterations,
                                   const Number* b, Number* x, const std::array<Number*, 6>& work,
                                   const Residual& residual) {
  const auto [r, shadow, p, v, t, q] = work;
  const auto apply = [&space, &team, product = q](const Number* from, Number* to) {
    space.product(team, from, product);
    space.precondition(team, product, to);
  };
  double target = accuracy;             // of the preconditioned residual
  std::uint32_t most = max_iterations;  // once that is as small as asked for
  space.zero(team, x);
  space.precondition(team, b, r);
  space.copy(team, r, shadow);
  space.copy(team, r, p);
  SolveAnswer answer;
  const double first = space.mass_square(team, r);
  if (first == 0.0) {
    answer.outcome = SolveOutcome::solved;
    answer.residual = 0.0;
    return answer;
  }
  if (!std::isfinite(first)) return answer;
  double rho = space.dot(team, shadow, r);
  while (answer.iterations < max_iterations) {
    apply(p, v);
    const double alpha = rho / space.dot(team, shadow, v);
    if (!std::isfinite(alpha)) return answer;
    space.add(team, alpha, p, x);
    space.add(team, -alpha, v, r);  // s
    team.barrier();
    apply(r, t);
    const double tt = space.dot(team, t, t), ts = space.dot(team, t, r);
    const double omega = tt > 0.0 ? ts / tt : 0.0;
    space.add(team, omega, r, x);
    space.add(team, -omega, t, r);
    ++answer.iterations;
    answer.residual = std::sqrt(space.mass_square(team, r) / first);
    if (!std::isfinite(answer.residual)) return answer;
    if (answer.residual <= target) {
      const double preconditioned = answer.residual;
      if (const std::optional<double> own = residual()) answer.residual = *own;
      if (!std::isfinite(answer.residual)) return answer;
      // A stiff filling hides all else from this norm: an error of its volume by rounding is a large force.
      if (answer.residual <= accuracy) {
        answer.outcome = SolveOutcome::solved;
        return answer;
      }
      if (most == max_iterations) most = std::min(max_iterations, 2 * answer.iterations + more_bicgstab_iterations);
      target = std::min(0.5 * preconditioned * accuracy / answer.residual, accuracy);
      answer.residual = preconditioned;
    }
    if (answer.iterations >= most) return answer;
    if (space.is_late(team, answer.iterations)) return answer;
    const double next = space.dot(team, shadow, r);
    const double beta = next / rho * (alpha / omega);
    if (!std::isfinite(beta) || omega == 0.0) return answer;
    rho = next;
    space.add(team, -omega, v, p);
    space.scale_add(team, beta, r, p);
    team.barrier();
  }
  return answer;
}

}  // namespace springnet::layers
