// The trajectory of a net with memory against one of SciPy: trajectory.py has its equations, trajectory.csv its result.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

std::vector<std::vector<double>> table(const std::string& file) {
  std::ifstream in(file);
  REQUIRE(in);
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(in, line);  // names
  while (std::getline(in, line)) {
    std::istringstream values(line);
    rows.emplace_back();
    for (std::string value; std::getline(values, value, ',');) rows.back().push_back(std::stod(value));
  }
  return rows;
}

// As in trajectory.py.
Network hung_up() {
  Network net;
  const Vector3 start[] = {{0, 0, 0}, {1, 0, -0.2}, {0.1, 0.9, -0.3}, {0.3, 0.2, -1.0}};
  const double mass[] = {1.0, 0.8, 0.5, 1.2};
  for (std::uint32_t k = 0; k < 4; ++k) net.add_node(point(start[k], mass[k]));
  net.fix(0);
  net.set_gravity({0, 0, -9.81});
  const auto add = [&](NodeIndex a, NodeIndex b, const LawUse& law) {
    net.add_spring(a, b, net.add_material({law, LawUse{"linear", {{"damping", 0.4}}}}));
  };
  const auto solid = [](double k, double k1, double tau) {
    return LawUse{"standard_linear_solid", {{"stiffness", k}, {"fast_stiffness", k1}, {"relaxation_time", tau}}};
  };
  const auto plastic = [](double k, double Y, double H, double tau) {
    return LawUse{"plastic", {{"stiffness", k}, {"yield_tension", Y}, {"hardening", H}, {"relaxation_time", tau}}};
  };
  add(0, 1, {"maxwell", {{"stiffness", 60.0}, {"relaxation_time", 0.8}}});
  add(0, 2, solid(80.0, 120.0, 0.15));
  add(0, 3, plastic(150.0, 9.0, 20.0, 0.05));
  add(1, 2,
      {"damaging",
       {{"stiffness", 90.0}, {"threshold_strain", 0.02}, {"softening_strain", 0.8}, {"relaxation_time", 0.1}}});
  add(1, 3, solid(70.0, 40.0, 0.02));
  add(2, 3, plastic(110.0, 4.0, 0.0, 0.2));
  return net;
}

// Greatest distance of a run from the table, in m and m/s, at all its times.
double distance(const LawUse& integrator, double h) {
  Simulation simulation = simulate(hung_up(), integrator, h);
  double greatest = 0.0;
  for (const std::vector<double>& row : table(SPRINGNET_STATES_DATA)) {
    simulation.advance_to(row[0]);
    for (std::uint32_t k = 0; k < 4; ++k)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto axis = static_cast<Eigen::Index>(c);
        greatest = std::max(greatest, std::abs(simulation.position(k)[axis] - row[1 + 3 * k + c]));
        greatest = std::max(greatest, std::abs(simulation.velocity(k)[axis] - row[13 + 3 * k + c]));
      }
    for (std::uint32_t s = 0; s < 6; ++s)
      greatest = std::max(greatest, std::abs(simulation.internal_states(s).at(0) - row[25 + s]));
  }
  return greatest;
}

}  // namespace

TEST_CASE("a net of all laws with memory moves as SciPy's does") {
  CHECK(table(SPRINGNET_STATES_DATA).size() == 9);
  for (const double method : {0.0, 1.0}) {
    CAPTURE(method);
    CHECK(distance(cvode(1e-11, {{"method", method}}), 0.25) < 2e-7);
  }
  for (const LawUse& integrator : {LawUse{"verlet", {}}, recurrent(newton, 1e-10, {{"theta", 0.5}})}) {
    CAPTURE(integrator.id);
    const double coarse = distance(integrator, 0.004), fine = distance(integrator, 0.001);
    CAPTURE(coarse);
    CAPTURE(fine);
    // Second order: 16 times as accurate, but for the kinks of yield and damage.
    CHECK(fine < 0.15 * coarse);
    CHECK(fine < 2e-3);
  }
}
