// What conjugate_gradients() and bicgstab() do with the vectors of a system without a matrix.
#include <algorithm>

#include "layers/linear/matrix_free.hpp"

namespace springnet::layers {

// Without own_ where they are isotropic, which product_and_dot() adds; with responses they are not.
void MatrixFree::product(Team& team, const float* p, float* q) {
  const NodeRange units = own_units(team);
  for (std::size_t u = units.begin; u < units.end; ++u) {
    const Unit& unit = layout_.units()[u];
    const NodeRange nodes{unit.first_node, std::size_t{unit.first_node} + unit.node_count};
    if (isotropic_)
      std::fill(q + 4 * nodes.begin, q + 4 * nodes.end, 0.0F);
    else
      kernels_.diagonal(own_single_.data(), nodes, p, q);
    kernels_.product(rows_within(u), nodes, p, true, q);
    kernels_.product(rows_leaving(u), nodes, p, false, q);
  }
  responses_.see(own_nodes(team), q);
}

double MatrixFree::product_and_dot(Team& team, const float* p, float* q) {
  product(team, p, q);
  return sum_(team, own_parts(team), [&](std::size_t i) {
    return isotropic_ ? kernels_.add_and_dot(own_scale_.data(), p, parts_[i], q) : kernels_.dot(p, q, parts_[i]);
  });
}

void MatrixFree::add(Team& team, double s, const float* x, float* y) {
  kernels_.add(static_cast<float>(s), x, own_nodes(team), y);
}

double MatrixFree::mass_square(Team& team, const float* r) {
  return sum_(team, own_parts(team),
              [&](std::size_t i) { return kernels_.square(mass_in_unit_.data(), r, parts_[i]); });
}

void MatrixFree::precondition(Team& team, const float* r, float* z) {
  kernels_.diagonal(inverse_.data(), own_nodes(team), r, z);
  if (coarse_.any()) correct(team, r, z);
}

double MatrixFree::dot(Team& team, const float* a, const float* b) {
  return sum_(team, own_parts(team), [&](std::size_t i) { return kernels_.dot(a, b, parts_[i]); });
}

double MatrixFree::square(Team& team, const float* r, double) {
  return sum_(team, own_parts(team),
              [&](std::size_t i) { return kernels_.square(inverse_mass_.data(), r, parts_[i]); });
}

Sums2 MatrixFree::update(Team& team, double step, const float* p, const float* q, float* x, float* r, float* z) {
  Sums2 sums = sum_.two(team, own_parts(team), [&](std::size_t i) {
    return kernels_.advance(static_cast<float>(step), p, q, inverse_.data(), inverse_mass_.data(), parts_[i], x, r, z);
  });
  if (coarse_.any()) sums.first += correct(team, r, z);
  return sums;
}

void MatrixFree::scale_add(Team& team, double s, const float* x, float* y) {
  kernels_.scale_add(static_cast<float>(s), x, own_nodes(team), y);
}

void MatrixFree::copy(Team& team, const float* x, float* y) {
  const auto [begin, end] = own_nodes(team);
  std::copy(x + 4 * begin, x + 4 * end, y + 4 * begin);
}

void MatrixFree::zero(Team& team, float* x) {
  const auto [begin, end] = own_nodes(team);
  std::fill(x + 4 * begin, x + 4 * end, 0.0F);
}

}  // namespace springnet::layers
