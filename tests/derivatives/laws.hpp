// Every shipped law on a small net, each spring with parameters of its own.
#pragma once

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host_at.hpp"

namespace springnet::testing {

struct LawCase {
  const char* id;
  bool viscosity;
  std::vector<std::pair<const char*, double>> parameters;  // about these
  TableValues tables{};
};

inline std::vector<LawCase> spring_laws() {
  return {
      {"linear", false, {{"stiffness", 3.0}}},
      {"nonlinear", false, {{"stiffness", 3.0}, {"cubic", 2.0}, {"quintic", 0.7}}},
      {"exponential", false, {{"stiffness", 3.0}, {"exponent", 1.5}}},
      {"rupturing", false, {{"stiffness", 3.0}, {"strength", 50.0}}},
      {"muscle",
       false,
       {{"strength", 5.0},
        {"maximum_speed", 4.0},
        {"curvature", 0.25},
        {"lengthening_force", 1.4},
        {"width", 0.45},
        {"passive_stiffness", 4.0},
        {"passive_strain", 0.6},
        {"damping", 0.1}}},
      {"maxwell", false, {{"stiffness", 3.0}, {"relaxation_time", 0.2}}},
      {"standard_linear_solid", false, {{"stiffness", 2.0}, {"fast_stiffness", 3.0}, {"relaxation_time", 0.2}}},
      {"plastic", false, {{"stiffness", 3.0}, {"yield_tension", 0.05}, {"hardening", 0.5}, {"relaxation_time", 0.2}}},
      {"damaging",
       false,
       {{"stiffness", 3.0}, {"threshold_strain", 0.05}, {"softening_strain", 0.5}, {"relaxation_time", 0.2}}},
      {"linear", true, {{"damping", 0.8}}},
      {"relative", true, {{"damping", 0.8}}},
      {"power", true, {{"damping", 0.8}, {"exponent", 1.7}}}};
}

// Random internal states about those given, within the bounds of shares.
inline Values stirred(Values internal) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(0.02, 0.2);
  for (double& z : internal) z += unit(random);
  return internal;
}

// Nodes about a helix, each joined to the next and the one after that, a little longer or shorter than at rest; the
// sets are the rest lengths (springs only) and the law's parameters.
inline Parametrised springs_with(const LawCase& law) {
  const std::size_t n = 9;
  std::vector<std::pair<NodeIndex, NodeIndex>> ends;
  for (NodeIndex k = 0; k + 1 < n; ++k) ends.emplace_back(k, k + 1);
  for (NodeIndex k = 0; k + 2 < n; ++k) ends.emplace_back(k, k + 2);
  const auto at = [](NodeIndex k) { return Vector3(std::cos(0.8 * k), std::sin(0.8 * k), 0.3 * k); };
  const Eigen::VectorXd speeds = random_vector(3 * n, 31);
  Parametrised given;
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(0.8, 1.2);
  if (!law.viscosity) {
    Parametrised::Set rest;
    rest.set.kind = SPRINGNET_BY_REFERENCE;
    // Stretched by 10 % to 30 %: beyond the kinks of laws that have one at rest or at a strain of 5 %.
    for (const auto& [a, b] : ends) rest.values.push_back((at(a) - at(b)).norm() / (1.0 + unit(random) - 0.8 + 0.1));
    given.sets.push_back(rest);
  }
  for (const auto& [name, value] : law.parameters) {
    Parametrised::Set set;
    set.set.kind = law.viscosity ? SPRINGNET_BY_VISCOSITY_PARAMETER : SPRINGNET_BY_SPRING_PARAMETER;
    set.set.parameter = name;
    set.set.component = law.id;
    for (std::size_t s = 0; s < ends.size(); ++s) set.values.push_back(value * unit(random));
    given.sets.push_back(set);
  }
  given.make = [=](const std::vector<Parametrised::Set>& sets) {
    Network net;
    for (NodeIndex k = 0; k < n; ++k) net.add_node(point(at(k), 1.0 + 0.1 * k, speeds.segment<3>(3 * k)));
    for (std::size_t s = 0; s < ends.size(); ++s) {
      LawUse use{law.id, {}};
      const std::size_t first = law.viscosity ? 0 : 1;
      for (std::size_t p = 0; p < law.parameters.size(); ++p)
        use.parameters[law.parameters[p].first] = sets[first + p].values[s];
      Material material;
      (law.viscosity ? material.viscosity : material.spring) = use;
      net.add_spring(ends[s].first, ends[s].second, net.add_material(material),
                     law.viscosity ? 1.0 : sets[0].values[s]);
    }
    return net;
  };
  return given;
}

}  // namespace springnet::testing
