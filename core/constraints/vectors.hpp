// Access to one node's vector in a structure of arrays.
#pragma once

#include <cstdint>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

namespace springnet {

[[nodiscard]] inline springnet_const_vectors read_only(const springnet_vectors& v) { return {v.x, v.y, v.z}; }
[[nodiscard]] inline Vector3 vector_at(const springnet_const_vectors& v, std::uint32_t k) {
  return {v.x[k], v.y[k], v.z[k]};
}
[[nodiscard]] inline Vector3 vector_at(const springnet_vectors& v, std::uint32_t k) { return {v.x[k], v.y[k], v.z[k]}; }
inline void put_vector(const springnet_vectors& v, std::uint32_t k, const Vector3& value) {
  v.x[k] = value[0];
  v.y[k] = value[1];
  v.z[k] = value[2];
}

}  // namespace springnet
