// Dense output of a time step: cubic Hermite interpolation of positions and velocities at its ends.
#pragma once

#include <cstdint>

#include <springnet/sdk/plugin.h>

#include "step.hpp"

namespace springnet::recurrent {

class StepCourse {
 public:
  // The step must have outputs.
  explicit StepCourse(const Step& step) noexcept : step_(step) {}
  // Positions (m) and velocities (m/s) at a time of the step, s.
  void write(double time, const springnet_vectors& position, const springnet_vectors& velocity) const noexcept {
    const springnet_state &a = step_.start, &b = *step_.outputs;
    const auto axis = [&](const double* p0, const double* v0, const double* p1, const double* v1, double* p,
                          double* v) {
      const double h = step_.until - step_.from, s = (time - step_.from) / h, rest = 1.0 - s;
      for (std::uint32_t k = 0; k < step_.network.node_count; ++k) {
        const double way = p1[k] - p0[k], d0 = h * v0[k] - way, d1 = h * v1[k] - way;
        p[k] = p0[k] + s * way + s * rest * (rest * d0 - s * d1);
        v[k] = (way + rest * (rest - 2.0 * s) * d0 - s * (2.0 * rest - s) * d1) / h;
      }
    };
    axis(a.position.x, a.velocity.x, b.position.x, b.velocity.x, position.x, velocity.x);
    axis(a.position.y, a.velocity.y, b.position.y, b.velocity.y, position.y, velocity.y);
    axis(a.position.z, a.velocity.z, b.position.z, b.velocity.z, position.z, velocity.z);
  }

 private:
  const Step& step_;
};

}  // namespace springnet::recurrent
