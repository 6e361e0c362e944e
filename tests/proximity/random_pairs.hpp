// Pairs of primitives by chance, degenerate ones among them.
#pragma once

#include <array>
#include <cstddef>
#include <random>

#include "proximity/primitives.hpp"

namespace springnet::proximity {

using Corners = std::array<Vector3, 4>;

inline int count_of(PairKind kind) { return first_nodes(kind) + second_nodes(kind); }

class PairDice {
 public:
  explicit PairDice(unsigned seed) : random_(seed) {}

  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  Vector3 vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  Vector3 grid_vector(int size) { return Vector3(whole(-size, size), whole(-size, size), whole(-size, size)); }

  // shape 0: anywhere; 1: on a coarse grid, where parts coincide, lie on one line or in one plane; 2: all in one plane;
  // 3: a primitive without area or length; 4: slivers; 5: far from the origin; 6: on one line, or on two side by side
  static constexpr int shapes = 7;
  Corners corners(int shape) {
    Corners x;
    for (Vector3& corner : x) corner = shape == 1 ? grid_vector(2) : vector(1.0);
    if (shape == 2)
      for (Vector3& corner : x) corner.z() = 0.25;
    if (shape == 3) {
      const double share = whole(-1, 1);
      x[3] = x[2] + share * (x[2] - x[1]);
      if (whole(0, 1) == 0) x[1] = x[0];
    }
    if (shape == 4) {
      x[3] = x[2] + number(-1.0, 1.0) * (x[2] - x[1]) + vector(1e-7);
      if (whole(0, 1) == 0) x[1] = x[0] + (x[3] - x[2]) + vector(1e-7);
    }
    if (shape == 6) {
      const Vector3 along = x[1] - x[0], aside = whole(0, 1) * 0.3 * vector(1.0);
      x[2] = x[0] + number(-0.5, 1.5) * along + aside;
      x[3] = x[0] + number(-0.5, 1.5) * along + aside;
    }
    if (shape == 5)
      for (Vector3& corner : x) corner += Vector3(1e3, -2e3, 3e3);
    return x;
  }
  // Weights of two closest points, also at ends and on edges.
  std::array<double, 4> weights(PairKind kind) {
    const auto share = [this] { return whole(0, 3) == 0 ? whole(0, 1) : number(0.0, 1.0); };
    if (kind == PairKind::node_node) return {1.0, -1.0, 0.0, 0.0};
    const double s = share(), t = share();
    if (kind == PairKind::edge_edge) return {1.0 - s, s, t - 1.0, -t};
    return {1.0, -(1.0 - s) * (1.0 - t), -s * (1.0 - t), -t};
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace springnet::proximity
