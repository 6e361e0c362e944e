// The earliest time at which two primitives whose nodes move along straight lines come within their thickness.
//
// Sound: no meeting is missed. A plane between two primitives that do not meet bounds their distance from below, and
// such a plane can be followed over a span of the step, in two forms:
//   - with a fixed normal n, n.(a_i - b_j) is linear in time for nodes a_i of the first primitive and b_j of the
//     second, so the time at which the least of these falls to the thickness is exact (conservative advancement; B.
//     Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996, with directions instead of speeds);
//   - with a normal that goes linearly from n_0 to n_1 over the span, and is therefore nowhere longer than 1, the
//     products are quadratic, with Bernstein coefficients n_0.D_0, (n_0.D_1 + n_1.D_0)/2, n_1.D_1 for D = a_i - b_j.
// The first always advances, the second follows primitives that turn past each other closely. There are no cubics to
// solve (X. Provot 1997; R. Bridson, R. Fedkiw, J. Anderson 2002), whose roots are lost where motions are coplanar, and
// no cases to distinguish (B. Wang et al., A Large Scale Benchmark ... for Continuous Collision Detection, 2021).
#pragma once

#include <array>
#include <optional>

#include <springnet/network_lists.hpp>

#include "proximity/distance.hpp"
#include "proximity/primitives.hpp"

namespace springnet::proximity {

// Distance that a pair which starts within its thickness keeps, as a share of the one at the start.
inline constexpr double kept_share = 0.5;

struct Meeting {
  double time = 0.0;  // share of the step, 0 to 1; never later than the exact time
  Separation at{};    // then
  // The pair touches at the start already, so that the positions do not tell on which side each is. Ask the direction
  // of an earlier step (on_side).
  bool from_start = false;
};

// start, end: the pair's nodes in the order of PairKind, m; unused places are not read. thickness: m, >= 0.
//
// The distance is watched against the thickness. A pair that starts nearer than that (or as near, to within the
// tolerance) is in contact, which forces or constraints act on; it is watched against `kept_share` of the distance that
// it starts with, so that it may separate, slide and approach, but not go through.
//
// Until the time that is returned, the distance is greater than what it is watched against; at this time, it is greater
// by the tolerance at most, the larger of 1e-4 of the thickness and 1e-12 of the pair's extent with its motion. Where
// rounding hides the plane between primitives that are degenerate, the search ends earlier, at a time that is sound.
// Empty if there is no such time, or if a coordinate is not finite.
[[nodiscard]] std::optional<Meeting> first_meeting(PairKind kind, const std::array<Vector3, 4>& start,
                                                   const std::array<Vector3, 4>& end, double thickness);

}  // namespace springnet::proximity
