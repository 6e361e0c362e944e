// The same bits for every number of threads, under every update rule and integrator: with contact, with rigid bodies
// that cross the boundaries of units, and with elements and an enclosure. What programs do in each thread.

#include <doctest/doctest.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <springnet/calling_threads.hpp>
#include <springnet/host_laws.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Nodes along an edge of a block. Threads work on units of at most 8192 nodes, and meet at their boundaries; there are
// two, or four.
constexpr std::uint32_t two_units = 21, four_units = 26;

Network falling_block(std::uint32_t side, const Friction& friction) {
  Lattice lattice;
  lattice.nodes = {side, side, side};
  Network net;
  net.add_lattice("block", lattice, point(Vector3::Zero(), 1.0, {0.4, 0.1, -0.2}), net.add_material(damped(50.0, 1.0)));
  net.set_gravity({0.3, 0, -1.0});
  Plane floor;
  floor.name = "floor";
  floor.friction = friction;
  net.add_plane(floor);
  return net;
}

// A pair in each row along x, every other of them joined to one beside it: as many clusters as threads are started for,
// some with nodes in both units.
Network block_with_rods(std::uint32_t side) {
  Network net = falling_block(side, {Friction::Kind::coulomb, 0.4});
  const auto node_of = [side](std::uint32_t i, std::uint32_t j, std::uint32_t k) { return i + side * (j + side * k); };
  for (std::uint32_t k = 0; k < side; ++k) {
    for (std::uint32_t j = 0; j < side; ++j) {
      const std::uint32_t i = 2 * ((j + k) % 10);
      net.add_rigid(node_of(i, j, k), node_of(i + 1, j, k));
      if ((j + k) % 10 == 5) net.add_rigid(node_of(i + 1, j, k), node_of(i + 2, j, k));
    }
  }
  return net;
}

Network block_with_elements(std::uint32_t side) {
  Network net = falling_block(side, {Friction::Kind::none});
  const auto node_of = [side](std::uint32_t i, std::uint32_t j, std::uint32_t k) { return i + side * (j + side * k); };
  std::vector<NodeIndex> surface;
  for (const Face& face : net.faces()) surface.insert(surface.end(), face.begin(), face.end());
  const ElementIndex filling =
      net.add_element(Invariant::enclosed_volume, surface, net.add_material(damped(1e-4, 1e-5)));
  net.set_reference(filling, 1.01 * net.elements()[filling].reference);
  const MaterialIndex bending = net.add_material(damped(0.2, 0.01)), bulk = net.add_material(damped(1.0, 0.0));
  for (std::uint32_t k = 0; k < side; k += 2) {
    for (std::uint32_t j = 0; j + 1 < side; ++j)
      for (std::uint32_t i = 0; i + 1 < side; ++i)
        net.add_element(Invariant::angle, {node_of(i + 1, j, k), node_of(i, j, k), node_of(i, j + 1, k)}, bending, 1.5);
    for (std::uint32_t j = 0; j + 1 < side && k + 1 < side; ++j)
      for (std::uint32_t i = 0; i + 1 < side; ++i)
        net.add_element(Invariant::volume,
                        {node_of(i, j, k), node_of(i + 1, j, k), node_of(i, j + 1, k), node_of(i, j, k + 1)}, bulk,
                        0.2);
  }
  return net;
}

struct Case {
  std::string name;
  LawUse integrator;
  double time_step;  // s
};
const std::vector<Case>& cases() {
  constexpr double tolerance = 1e-4;  // N
  static const std::vector<Case> all{{"one sweep", single_sweep(), 0.02},
                                     {"synchronous", recurrent(synchronous, tolerance), 0.02},
                                     {"wavefront", recurrent(wavefront, tolerance), 0.02},
                                     {"block", recurrent(testing::block, tolerance), 0.02},
                                     {"coloured", recurrent(coloured, tolerance), 0.02},
                                     {"newton", recurrent(newton, tolerance), 0.05},
                                     {"newton, theta 1/2", recurrent(newton, tolerance, {{"theta", 0.5}}), 0.05},
                                     {"verlet", {"verlet", {}}, 0.02},
                                     {"generalized_alpha", testing::generalized_alpha(), 0.02},
                                     {"cvode", cvode(1e-4), 0.01}};
  return all;
}

struct Course {
  Eigen::MatrixXd state;  // positions, velocities
  std::size_t events = 0;
  std::uint64_t sweeps = 0;
  friend bool operator==(const Course&, const Course&) = default;
};
Course run(const Network& net, const Case& each, unsigned threads, int steps) {
  SimulationOptions options;
  options.time_step = each.time_step;
  options.integrator = each.integrator;
  options.threads = threads;
  Simulation simulation(net, plugins(), options);
  CHECK(simulation.threads() == threads);
  for (int i = 0; i < steps; ++i) simulation.step();
  Course course{Eigen::MatrixXd(6, simulation.positions().cols()), simulation.events().size(), simulation.sweeps()};
  course.state << simulation.positions(), simulation.velocities();
  return course;
}

void check_cases(const Network& net, unsigned threads) {
  for (const Case& each : cases()) {
    CAPTURE(each.name);
    const Course one = run(net, each, 1, 2);
    CHECK(one.events >= two_units * two_units);  // it lies on the floor
    CHECK(run(net, each, threads, 2) == one);
  }
}

}  // namespace

TEST_CASE("the same bits for every number of threads: contact with friction, every integrator") {
  check_cases(falling_block(two_units, {Friction::Kind::coulomb, 0.2}), 2);
}

TEST_CASE("the same bits for every number of threads: rigid bodies across units, every integrator") {
  check_cases(block_with_rods(four_units), 3);
}

TEST_CASE("the same bits for every number of threads: elements and an enclosure, every integrator") {
  check_cases(block_with_elements(two_units), 2);
}

TEST_CASE("a program prepares each thread once, before the first call of a component in it") {
  static std::atomic<int> prepared, wrong;
  static thread_local int times;
  prepared = wrong = 0;
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  host->add(
      spring_function(describe("looking", "counts calls in threads not prepared once"), [](const auto& e, const auto&) {
        if (times != 1) ++wrong;
        return e.elongation();
      }));
  const auto simulate_in_new_thread = [&host] {
    std::thread([&host] {
      Network net;
      Lattice lattice;
      lattice.nodes = {two_units, two_units, two_units};
      net.add_lattice("block", lattice, point(Vector3::Zero(), 1.0), net.add_material({LawUse{"looking", {}}, {}}));
      SimulationOptions options;
      options.integrator = single_sweep();
      options.threads = 2;
      Simulation simulation(net, host, options);
      for (int step = 0; step < 20; ++step) simulation.step();
    }).join();
  };
  prepare_calling_threads([]() noexcept {
    ++prepared;
    ++times;
  });
  simulate_in_new_thread();
  const int first = prepared;  // of two threads, unless one did all
  CHECK(first >= 1);
  CHECK(first <= 2);
  simulate_in_new_thread();  // in others
  CHECK(prepared > first);
  CHECK(wrong == 0);
  prepare_calling_threads(nullptr);
  simulate_in_new_thread();
  CHECK(prepared <= 4);
  CHECK(wrong > 0);
}
