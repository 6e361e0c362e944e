// A program that embeds springnet: a block of soft material hangs from its upper side, is pulled where a ray meets it,
// is cut through, and its lower half falls, while another thread draws. Prints one quantity per line, with its unit in
// the name.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/scene_writer.hpp>
#include <springnet/simulation.hpp>

namespace {

using springnet::Vector3;

constexpr double mass = 1e-3;     // kg, of a node
constexpr double gravity = 9.81;  // m/s^2
constexpr springnet::NodeIndex layer = 5 * 5, layers = 4, nodes = layer * layers, first_fixed = nodes - layer;

// 5 x 5 x 4 nodes, 1 cm apart, with all diagonals; the upper layer is fixed.
springnet::Network hanging_block() {
  springnet::Network network;
  const auto material = network.add_material({.spring = springnet::LawUse{"linear", {{"stiffness", 100.0}}},   // N/m
                                              .viscosity = springnet::LawUse{"linear", {{"damping", 0.1}}}});  // N s/m
  network.add_lattice("block",
                      {.nodes = {5, 5, layers},
                       .spacing = Vector3::Constant(0.01),
                       .origin = Vector3::Zero(),
                       .diagonals = springnet::Diagonals::all},
                      {.mass = mass}, material);
  for (springnet::NodeIndex node = first_fixed; node < nodes; ++node) network.fix(node);
  network.set_gravity({0.0, 0.0, -gravity});
  return network;
}

// Upward force that holds the fixed nodes against all springs and their own weight, N.
double holding_force(const springnet::Simulation& simulation) {
  double sum = 0.0;
  for (springnet::NodeIndex node = first_fixed; node < nodes; ++node) sum += simulation.reaction(node).z();
  return sum;
}

// Mean height of the two lower layers, m. The map refers to the engine's own memory; columns() has the column of each
// of the user's nodes.
double height_of_lower_half(const springnet::Simulation& simulation) {
  const springnet::ConstNodeMap positions = simulation.positions();
  double sum = 0.0;
  for (springnet::NodeIndex node = 0; node < 2 * layer; ++node) sum += positions(2, simulation.columns()[node]);
  return sum / (2 * layer);
}

// The node under the cursor: the corner next to where a ray from below meets the block.
springnet::NodeIndex pick(const springnet::Simulation& simulation, double x, double y) {
  const std::optional<springnet::RayHit> hit = simulation.cast_ray({x, y, -1.0}, {0.0, 0.0, 1.0});
  if (!hit || hit->face < 0) throw std::runtime_error("the ray misses the block");
  return hit->node;
}

// Draws from snapshots until it is told to end: here it follows the lowest point. No step waits for it.
class Drawing {
 public:
  explicit Drawing(const springnet::Simulation& simulation) : thread_([this, &simulation] { draw(simulation); }) {}
  ~Drawing() {
    ends_ = true;
    thread_.join();
  }
  Drawing(const Drawing&) = delete;
  Drawing& operator=(const Drawing&) = delete;
  [[nodiscard]] double lowest() const { return lowest_; }  // m

 private:
  void draw(const springnet::Simulation& simulation) {
    for (bool last = false; !last;) {
      last = ends_;  // once more after the last step
      if (const std::shared_ptr<const springnet::Snapshot> snapshot = simulation.snapshot())
        lowest_ = std::min(lowest_.load(), snapshot->positions.row(2).minCoeff());
      std::this_thread::yield();
    }
  }
  std::atomic<bool> ends_ = false;
  std::atomic<double> lowest_ = std::numeric_limits<double>::infinity();
  std::thread thread_;
};

// A simulation of a scene that was written to a file starts where this one is.
double greatest_difference_of_written_state(const springnet::Simulation& simulation,
                                            const std::shared_ptr<const springnet::PluginHost>& plugins) {
  springnet::Scene scene;
  scene.network = simulation.present_network();
  scene.options.time_step = simulation.time_step();
  springnet::write_scene(scene, *plugins, "block.toml");
  const springnet::Scene read = springnet::load_scene("block.toml", *plugins);
  const springnet::Simulation again(read.network, plugins, read.options);
  return (again.in_user_order(again.positions()) - simulation.in_user_order(simulation.positions()))
      .cwiseAbs()
      .maxCoeff();
}

void run() {
  auto plugins = std::make_shared<const springnet::PluginHost>(springnet::PluginHost::with_default_search());
  springnet::Simulation simulation(hanging_block(), plugins, {.time_step = 5e-4});
  std::printf("nodes %zu\nsprings %zu\n", simulation.node_count(), simulation.spring_count());
  double limit = std::numeric_limits<double>::infinity();  // s; of the rules that have one
  for (const springnet::TimeStepLimit& each : simulation.time_step_limits()) limit = std::fmin(limit, each.time_step);
  std::printf("smallest_limit_of_time_step_s %.9g\n", limit);

  simulation.advance_to(1.5);
  std::printf("weight_N %.9g\nholding_force_at_rest_N %.9g\n", nodes * mass * gravity, holding_force(simulation));
  std::printf("lowest_point_at_rest_m %.9g\n", simulation.positions().row(2).minCoeff());
  const double greatest_tension = simulation.tensions().maxCoeff();
  const springnet::Energies energies = simulation.energies();
  std::printf("greatest_tension_N %.9g\nenergy_of_springs_J %.9g\n", greatest_tension, energies.springs);

  // An instrument pulls where a ray from below meets the lower side, near its middle.
  const springnet::NodeIndex middle = pick(simulation, 0.021, 0.019);
  std::printf("picked_node %u\nsprings_of_picked_node %zu\n", middle, simulation.springs_of(middle).size());
  simulation.set_force(middle, {0.0, 0.0, -0.2});
  std::size_t asked = 0;
  simulation.advance_to(3.0, [&] {
    ++asked;  // a host draws its progress here; false cancels
    return true;
  });
  std::printf("steps_with_progress %zu\n", asked);
  std::printf("holding_force_pulled_N %.9g\n", holding_force(simulation));
  std::printf("lowest_point_pulled_m %.9g\n", simulation.positions().row(2).minCoeff());
  std::printf("greatest_difference_of_written_state_m %.9g\n",
              greatest_difference_of_written_state(simulation, plugins));

  // It lets go, and a cut between the second and the third layer releases the lower half.
  const std::string before_cut = simulation.save();
  simulation.set_force(middle, Vector3::Zero());
  const double before = height_of_lower_half(simulation);
  std::size_t told = 0;
  double tension_of_cut = 0.0;  // N, of all springs together
  simulation.on_event([&](const springnet::Event& event) {
    ++told;
    if (!event.element) tension_of_cut += event.force;
  });
  const std::size_t removed =
      simulation.cut_polygon({{-1, -1, 0.0145}, {1, -1, 0.0145}, {1, 1, 0.0145}, {-1, 1, 0.0145}});
  std::printf("springs_cut %zu\nsprings_left %zu\nevents_told %zu\n", removed, simulation.live_spring_count(), told);
  std::printf("tension_of_cut_springs_N %.9g\n", tension_of_cut);
  simulation.keep_snapshots();
  double drawn = 0.0;
  {
    const Drawing drawing(simulation);
    for (int step = 0; step < 100; ++step) simulation.step();
    while (drawing.lowest() > simulation.positions().row(2).minCoeff()) std::this_thread::yield();
    drawn = drawing.lowest();
  }
  std::printf("fall_in_100_steps_m %.9g\n", before - height_of_lower_half(simulation));
  std::printf("drawn_lowest_point_m %.9g\nlowest_point_m %.9g\n", drawn, simulation.positions().row(2).minCoeff());

  // Undone: the state before the cut, with all springs.
  simulation.restore(before_cut);
  std::printf("springs_after_undoing %zu\n", simulation.live_spring_count());

  // A copy goes ahead in another thread; the simulation itself goes on later from a file, to the same bits.
  simulation.save_to("block.state");
  springnet::Simulation copy = simulation.clone();
  std::thread ahead([&copy] { copy.advance_to(copy.time() + 0.1); });
  ahead.join();
  simulation.restore_from("block.state");
  simulation.advance_to(simulation.time() + 0.1);
  std::printf("greatest_difference_of_copy_m %.9g\n",
              (copy.positions() - simulation.positions()).cwiseAbs().maxCoeff());

  // Changes while it runs: before the cut again, the material becomes twice as stiff, a node heavier, and a weight is
  // hung on a thread below the picked node.
  simulation.restore(before_cut);
  simulation.set_force(middle, Vector3::Zero());
  std::vector<springnet::SpringIndex> springs(simulation.spring_count());
  std::iota(springs.begin(), springs.end(), springnet::SpringIndex{0});
  simulation.set_parameter(springs, springnet::ComponentKind::spring_function, "stiffness", {200.0});  // N/m
  simulation.set_masses({0}, {5.0 * mass});
  simulation.extend([&](springnet::Network& now) {
    const auto thread = now.add_material({.spring = springnet::LawUse{"linear", {{"stiffness", 500.0}}},
                                          .viscosity = springnet::LawUse{"linear", {{"damping", 0.5}}}});
    springnet::Node weight = now.nodes()[middle];
    weight.position.z() -= 0.02;
    weight.mass = 2.0 * mass;
    now.add_spring(middle, now.add_node(weight), thread);
  });
  simulation.set_integrator({"generalized_alpha", {}});
  simulation.advance_to(simulation.time() + 1.5);
  std::printf("weight_changed_N %.9g\nholding_force_changed_N %.9g\n", (nodes + 4 + 2) * mass * gravity,
              holding_force(simulation));
  std::printf("tension_of_thread_N %.9g\n",
              simulation.tension(static_cast<springnet::SpringIndex>(simulation.spring_count() - 1)));
}

}  // namespace

int main() {
  try {
    run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "host: %s\n", error.what());
    return 1;
  }
}
