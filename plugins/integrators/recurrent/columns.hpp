// Vector quantities of all nodes: three arrays of one length, and ways to read them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <Eigen/Core>

namespace springnet::recurrent {

// Three arrays of one length.
struct Columns {
  std::vector<double> x, y, z;
  void resize(std::size_t size) {
    for (auto* component : {&x, &y, &z}) component->resize(size);
  }
  [[nodiscard]] springnet_vectors view() noexcept { return {x.data(), y.data(), z.data()}; }
  [[nodiscard]] springnet_const_vectors view() const noexcept { return {x.data(), y.data(), z.data()}; }
};

// The components as arrays: axes(v)[axis][node].
using Three = std::array<double*, 3>;
using ThreeConst = std::array<const double*, 3>;
inline Three axes(const springnet_vectors& v) noexcept { return {v.x, v.y, v.z}; }
inline ThreeConst axes(const springnet_const_vectors& v) noexcept { return {v.x, v.y, v.z}; }
inline ThreeConst axes(const Columns& v) noexcept { return {v.x.data(), v.y.data(), v.z.data()}; }

inline Eigen::Vector3d at(const springnet_vectors& v, std::size_t k) { return {v.x[k], v.y[k], v.z[k]}; }
inline Eigen::Vector3d at(const springnet_const_vectors& v, std::size_t k) { return {v.x[k], v.y[k], v.z[k]}; }

}  // namespace springnet::recurrent
