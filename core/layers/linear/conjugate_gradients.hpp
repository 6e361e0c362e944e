// Preconditioned conjugate gradients (Hestenes and Stiefel 1952), truncated at negative curvature (Steihaug 1983).
#pragma once

#include <cmath>
#include <cstdint>

#include "layers/linear/team.hpp"

namespace springnet::layers {

enum class SolveOutcome {
  solved,
  // A direction of negative curvature; the solution is the iterate before, zero if it was the first.
  truncated,
  // Not as accurate as asked for within the iterations, or not at all.
  stalled
};
struct SolveAnswer {
  SolveOutcome outcome = SolveOutcome::stalled;
  std::uint32_t iterations = 0;
  double residual = 1.0;  // relative to the right-hand side's
};

// Solves S x = b, run by all threads of a team. The space knows the matrix, and what to do with its vectors:
//   product_and_dot(team, p, q)   q = S p, complete for the calling thread's nodes, p must be so for all; answers p.q
//   precondition(team, r, z)  z = B r, likewise; r need be complete for the thread's own nodes only
//   dot(team, a, b), scale_add(team, s, x, y), copy(team, x, y), zero(team, x)
//   is_late(team, iterations) whether to end here, stalled; the same in all threads
//   square(team, r, along)    by which accuracy is measured; along: r.z
//   update(team, s, p, q, x, r, z)   x += s p, r -= s q, z = B r; answers r.z and square(r)
template <class Space, class Number>
[[nodiscard]] SolveAnswer conjugate_gradients(Space& space, Team& team, double accuracy, std::uint32_t max_iterations,
                                              const Number* b, Number* x, Number* r, Number* z, Number* p, Number* q) {
  space.copy(team, b, r);
  space.zero(team, x);
  space.precondition(team, r, z);
  space.copy(team, z, p);
  double along = space.dot(team, r, z);
  const double first = space.square(team, r, along);
  SolveAnswer answer;
  if (first == 0.0) {
    answer.outcome = SolveOutcome::solved;
    answer.residual = 0.0;
    return answer;
  }
  if (!std::isfinite(first) || !(along > 0.0)) return answer;
  while (answer.iterations < max_iterations) {
    const double curvature = space.product_and_dot(team, p, q);
    if (!std::isfinite(curvature)) return answer;
    if (!(curvature > 0.0)) {
      answer.outcome = SolveOutcome::truncated;
      return answer;
    }
    const double step = along / curvature;
    const auto [next, left] = space.update(team, step, p, q, x, r, z);
    ++answer.iterations;
    answer.residual = std::sqrt(left > 0.0 ? left / first : 0.0);
    if (!std::isfinite(answer.residual)) return answer;
    if (answer.residual <= accuracy || !(next > 0.0)) {
      if (answer.residual <= accuracy) answer.outcome = SolveOutcome::solved;
      return answer;
    }
    if (space.is_late(team, answer.iterations)) return answer;
    space.scale_add(team, next / along, z, p);
    along = next;
    team.barrier();
  }
  return answer;
}

}  // namespace springnet::layers
