// The greatest step for which velocity Verlet is stable on a network.
//
// Of one oscillator a = -k x - c v (per mass) the scheme is stable while
//
//   h^2 k / 4 + h c < 1
//
// where the acceleration at a step's start is that of the end of the last one, at the velocity as it was known there:
// the characteristic polynomial of (x, h v, h^2 a) is l^3 + (3/2 g + q - 2) l^2 + (1 - 2 g) l + g / 2 with q = h^2 k,
// g = h c, and l = -1 is where it leaves the unit circle first. Where the acceleration is evaluated anew at each start,
// the step is one of two variables, and stable while q < 4 - 2 g + g^2 and g < 2.
//
// Of a network k and c are -da/dp and -da/dv, and the limit is where h^2 k / 4 + h c has the eigenvalue 1.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/limits.hpp>

class Stability {
 public:
  explicit Stability(springnet::sdk::Host host) : host_(host) {}

  // The limit, s, with the derivatives last given to Host::linearise: infinity where nothing limits the step, nan where
  // derivatives are not finite. `restarts`: the acceleration is evaluated anew at the start of each step. It is off by
  // less than a per cent.
  [[nodiscard]] double limit(bool restarts);
  // Then the node that moves most in the motion that becomes unstable first; sdk::no_limit_node without a limit.
  [[nodiscard]] std::uint32_t node() const;

 private:
  // h^2 Q + h L has the eigenvalue 1 at the limit.
  enum class Form { lagging, restarting, restarting_damping };
  // other: a limit that is known already; `mode_` is that of the smaller one.
  [[nodiscard]] double least(springnet::sdk::LinearisedNetwork& network, Form form, double guess, double other);

  springnet::sdk::Host host_;
  std::vector<double> mode_;  // of the limit that limit() found; empty: none
};
