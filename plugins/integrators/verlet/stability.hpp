// The largest step for which velocity Verlet is stable on a network.
//
// For one oscillator a = -k x - c v (per mass) the scheme is stable while
//
//   h^2 k / 4 + h c < 1
//
// if a step starts with the acceleration from the end of the last one, evaluated at the velocity as known there. The
// characteristic polynomial of (x, h v, h^2 a) is l^3 + (3/2 g + q - 2) l^2 + (1 - 2 g) l + g / 2 with q = h^2 k,
// g = h c, and its first root to leave the unit circle does so at l = -1. If the acceleration is evaluated anew at each
// start, the state has two variables, and a step is stable while q < 4 - 2 g + g^2 and g < 2.
//
// For a network, k and c are -da/dp and -da/dv, and the limit is where h^2 k / 4 + h c has the eigenvalue 1.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/limits.hpp>

class Stability {
 public:
  explicit Stability(springnet::sdk::Host host) : host_(host) {}

  // The limit, s, for the state last given to Host::linearise, to less than one per cent: infinity if nothing limits
  // the step, nan if derivatives are not finite. `restarts`: the acceleration is evaluated anew at the start of each
  // step.
  [[nodiscard]] double limit(bool restarts);
  // After limit(): the node that moves most in the motion that becomes unstable first; sdk::no_limit_node without a
  // limit.
  [[nodiscard]] std::uint32_t node() const;

 private:
  // h^2 Q + h L has the eigenvalue 1 at the limit.
  enum class Form { lagging, restarting, restarting_damping };
  // other: a limit already known; `mode_` becomes that of the smaller of the two.
  [[nodiscard]] double limit_of(springnet::sdk::LinearisedNetwork& network, Form form, double guess, double other);

  springnet::sdk::Host host_;
  std::vector<double> mode_;  // of the limit that limit() found; empty: none
};
