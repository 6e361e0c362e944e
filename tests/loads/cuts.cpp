// Faces are removed with their springs, and so are the loads on them.
#include <doctest/doctest.h>

#include "loaded.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Two triangles with a common side, springs on all five sides.
Network two_triangles() {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(0, 1, 0)})
    net.add_node(point(p));
  const MaterialIndex material = net.add_material(damped(1.0, 0.0));
  for (const auto& [a, b] : {std::pair{0u, 1u}, {1u, 2u}, {2u, 0u}, {2u, 3u}, {3u, 0u}}) net.add_spring(a, b, material);
  return net;
}
const std::vector<Face> both{{0, 1, 2}, {0, 2, 3}};

Vector3 total(const Simulation& simulation) {
  Vector3 sum = Vector3::Zero();
  for (NodeIndex k = 0; k < simulation.node_count(); ++k) sum += simulation.force(k);
  return sum;
}

}  // namespace

TEST_CASE("loads on a face end when a spring along its side is removed") {
  for (const bool follow : {false, true}) {
    Network net = two_triangles();
    net.add_load(pressed(both, 6.0, follow));  // 3 N down on each face of 1/2 m^2
    net.add_load({{0, 1}, {1, 0, 0}});
    for (const LawUse& way : {recurrent(newton, 1e-9), recurrent(coloured, 1e-9), cvode(1e-8)}) {
      Simulation simulation = simulate(net, way, 0.01);
      CHECK((total(simulation) - Vector3(2, 0, -6)).norm() <= 1e-13);
      simulation.cut({3});  // an outer side of the second triangle
      CHECK((total(simulation) - Vector3(2, 0, -3)).norm() <= 1e-13);
      CHECK(simulation.force(3).norm() <= 1e-13);
      CHECK(simulation.notes().size() == 1);
      CHECK(simulation.notes()[0].find("Force 0 ended on faces that were torn") != std::string::npos);
      CHECK(simulation.step().outcome == Outcome::settled);
      simulation.cut({2});  // the common side
      CHECK(total(simulation).z() == doctest::Approx(0.0));
      CHECK(simulation.step().outcome == Outcome::settled);
      CHECK(simulation.notes().size() == 1);
    }
  }
}

TEST_CASE("a polygon removes faces whose sides it crosses, with or without springs") {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0)}) net.add_node(point(p));
  net.add_load(pressed({{0, 1, 2}}, 6.0, true));
  Cut cut;
  cut.time = 0.1;
  cut.polygon = {{0.5, -1, -1}, {0.5, 2, -1}, {0.5, 2, 1}, {0.5, -1, 1}};
  net.add_cut(cut);
  for (const LawUse& way : {recurrent(newton, 1e-9), cvode(1e-10)}) {
    Simulation simulation = simulate(net, way, 0.05);
    simulation.advance_to(0.3);
    CHECK(simulation.velocity(0).z() == doctest::Approx(-0.1).epsilon(1e-8));  // 1 N for 0.1 s
    CHECK(simulation.notes().size() == 1);
  }
}
