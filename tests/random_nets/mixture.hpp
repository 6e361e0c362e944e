// Adds to a random network what reads more than a length and its rate: solids, fibre solids, membranes and shells with
// viscosities, springs and elements with memory.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "generator.hpp"

namespace springnet::testing {

class Mixture {
 public:
  // smallest_share: of the greatest modulus and viscosity.
  Mixture(Network& network, std::uint64_t seed, double smallest_share = 1e-6)
      : network_(network), range_(smallest_share), dice_(seed + 5000000) {
    const auto count = static_cast<std::uint32_t>(network.nodes().size());
    if (count >= 4)
      for (std::uint32_t i = 0; i < 2 + count / 3; ++i) add_continuum(dice_.below(count));
    std::vector<MaterialIndex> memories;
    for (int i = 0; i < 6; ++i) memories.push_back(network.add_material(memory(1.0)));
    for (SpringIndex s = 0; s < network.springs().size(); ++s)
      if (dice_.chance(0.4)) network.set_spring_material(s, memories[dice_.below(6)]);
    if (count >= 4)
      for (std::uint32_t i = 0; i < 1 + count / 8; ++i) add_element_with_memory(dice_.below(count));
  }

 private:
  static constexpr double max_modulus = 1e3, max_viscosity = 10.0;  // Pa, Pa s; nodes are about 1 m apart

  // scale: of the stiffness, for invariants other than lengths.
  Material memory(double scale) {
    const double stiffness = scale * dice_.decades(range_ * 1e4, 1e4),
                 tau = dice_.decades(1e-2 * std::sqrt(range_), 1.0);
    const bool relaxed = dice_.chance(0.3);
    Material material;
    switch (dice_.below(4)) {
      case 0:
        material.spring = LawUse{
            "maxwell", {{"stiffness", stiffness}, {"relaxation_time", tau}, {"starts_relaxed", relaxed ? 1.0 : 0.0}}};
        break;
      case 1:
        material.spring = LawUse{"standard_linear_solid",
                                 {{"stiffness", stiffness},
                                  {"fast_stiffness", stiffness * dice_.decades(0.1, 10.0)},
                                  {"relaxation_time", tau},
                                  {"starts_relaxed", relaxed ? 1.0 : 0.0}}};
        break;
      case 2:  // yields at strains of this size
        material.spring = LawUse{"plastic",
                                 {{"stiffness", stiffness},
                                  {"yield_tension", stiffness * dice_.decades(1e-4, 0.3)},
                                  {"hardening", stiffness * dice_.between(0.0, 0.5)},
                                  {"relaxation_time", tau}}};
        break;
      default:
        material.spring = LawUse{"damaging",
                                 {{"stiffness", stiffness},
                                  {"threshold_strain", dice_.decades(1e-3, 0.3)},
                                  {"softening_strain", dice_.decades(0.1, 10.0)},
                                  {"relaxation_time", tau}}};
    }
    if (dice_.chance(0.4)) material.viscosity = LawUse{"linear", {{"damping", scale * dice_.decades(1e-3, 10.0)}}};
    return material;
  }

  void add_element_with_memory(NodeIndex node) {
    static constexpr Invariant kinds[] = {Invariant::angle, Invariant::area};
    const std::vector<NodeIndex> near = nearest_nodes(network_, node);
    network_.add_element(kinds[dice_.below(2)], {near[0], node, near[1]}, network_.add_material(memory(1e-2)));
  }

  void add_continuum(NodeIndex node) {
    const std::vector<NodeIndex> near = nearest_nodes(network_, node);
    switch (dice_.below(5)) {
      case 0:
      case 1:
        return add_tetrahedron({node, near[0], near[1], near[2]});
      case 2:
      case 3:
        return add_triangle({node, near[0], near[1]});
      default:
        return add_hinge({node, near[0], near[1], near[2]});
    }
  }
  [[nodiscard]] double modulus() { return dice_.decades(range_ * max_modulus, max_modulus); }
  [[nodiscard]] double viscosity() { return dice_.decades(range_ * max_viscosity, max_viscosity); }
  [[nodiscard]] double poisson_ratio() { return dice_.between(-0.8, 0.48); }

  [[nodiscard]] std::vector<Vector3> places(const std::vector<NodeIndex>& nodes) const {
    std::vector<Vector3> result;
    for (const NodeIndex node : nodes) result.push_back(network_.nodes()[node].position);
    return result;
  }
  // Another size, turned and shifted: elements are strained at the start, and the axes of the material are not those of
  // space.
  [[nodiscard]] std::vector<Vector3> at_rest(std::vector<Vector3> places) {
    const double scale = dice_.chance(0.3) ? 1.0 : dice_.between(0.8, 1.2);
    const Vector3 axis = dice_.in_box(1.0).normalized(), shift = dice_.in_box(10.0);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(dice_.between(0.0, 3.0), axis).toRotationMatrix();
    for (Vector3& place : places) place = scale * (turn * place) + shift;
    return places;
  }
  static bool is_slender(const std::vector<Vector3>& places, double size, double dimension) {
    double longest = 0.0;
    for (const Vector3& a : places)
      for (const Vector3& b : places) longest = std::max(longest, (a - b).norm());
    return size < 0.02 * std::pow(longest, dimension);
  }

  void add_tetrahedron(std::vector<NodeIndex> nodes) {
    const auto volume = [&] {
      const std::vector<Vector3> p = places(nodes);
      return (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) / 6.0;
    };
    if (volume() < 0.0) std::swap(nodes[2], nodes[3]);
    if (is_slender(places(nodes), volume(), 3.0)) return;
    Material material;
    Vector3 direction = Vector3::Zero();
    if (dice_.chance(0.5)) {
      material.spring = LawUse{"solid", {{"youngs_modulus", modulus()}, {"poisson_ratio", poisson_ratio()}}};
    } else {
      direction = dice_.in_box(1.0);
      material.spring = LawUse{"fibre_solid",
                               {{"youngs_modulus", modulus()},
                                {"poisson_ratio", poisson_ratio()},
                                {"fibre_modulus", modulus()},
                                {"fibre_stiffening", dice_.chance(0.5) ? 0.0 : dice_.between(0.0, 0.5)},
                                {"fibres_push", dice_.chance(0.5) ? 1.0 : 0.0}}};
    }
    if (dice_.chance(0.5))
      material.viscosity = LawUse{"viscous_solid", {{"shear_viscosity", viscosity()}, {"bulk_viscosity", viscosity()}}};
    if (material.viscosity && dice_.chance(0.2)) {
      material.spring.reset();
      direction.setZero();
    }
    network_.add_element(Invariant::tetrahedron, nodes, network_.add_material(material), at_rest(places(nodes)),
                         direction);
  }
  void add_triangle(const std::vector<NodeIndex>& nodes) {
    const std::vector<Vector3> p = places(nodes);
    if (is_slender(p, 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm(), 2.0)) return;
    Material material{LawUse{"membrane",
                             {{"youngs_modulus", modulus()},
                              {"poisson_ratio", poisson_ratio()},
                              {"thickness", dice_.decades(0.01, 1.0)},
                              {"model", dice_.chance(0.5) ? 0.0 : 1.0}}},
                      std::nullopt};
    if (dice_.chance(0.5))
      material.viscosity =
          LawUse{"viscous_membrane", {{"shear_viscosity", viscosity()}, {"area_viscosity", viscosity()}}};
    if (material.viscosity && dice_.chance(0.2)) material.spring.reset();
    network_.add_element(Invariant::triangle, nodes, network_.add_material(material), at_rest(p));
  }
  void add_hinge(const std::vector<NodeIndex>& nodes) {
    const std::vector<Vector3> p = places(nodes);
    const Vector3 edge = p[1] - p[0];
    for (const std::size_t tip : {std::size_t{2}, std::size_t{3}})
      if (is_slender({p[0], p[1], p[tip]}, 0.5 * edge.cross(p[tip] - p[0]).norm(), 2.0)) return;
    const LawUse law{
        "shell",
        {{"youngs_modulus", modulus()}, {"poisson_ratio", poisson_ratio()}, {"thickness", dice_.decades(0.03, 1.0)}}};
    // A little off flat or as it is: its own angle at rest.
    std::vector<Vector3> rest = at_rest(p);
    rest[3] += dice_.in_box(0.1);
    network_.add_element(Invariant::hinge, nodes, network_.add_material({law, std::nullopt}), std::move(rest));
  }

  Network& network_;
  double range_;
  Dice dice_;
};

}  // namespace springnet::testing
