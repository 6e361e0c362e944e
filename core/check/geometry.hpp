// Elements of laws over several scalars: their corners, the scalars, and the scalars' gradients.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <springnet/sdk/plugin.h>

namespace springnet::check {

using Corners = std::vector<std::array<double, 3>>;  // m

// A well-shaped element of the law's shape, edges of about 1 m.
[[nodiscard]] Corners corners_of(std::uint32_t shape);
// The law's scalars at these corners.
[[nodiscard]] std::vector<double> scalars_of(const springnet_law& law, const Corners& corners);
// Their derivatives by the coordinates, [scalar][3 corner + axis], by differences.
[[nodiscard]] std::vector<std::vector<double>> gradients_of(const springnet_law& law, const Corners& corners);
// Components of a direction in the edges from the first corner, length 1, as batches have them.
[[nodiscard]] std::array<double, 3> direction_of(const Corners& rest, const std::array<double, 3>& direction);

}  // namespace springnet::check
