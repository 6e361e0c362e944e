// An integrator that runs a test's own task in each step, and leaves the network as it is.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <vector>

#include <springnet/sdk/integrator.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"

namespace springnet::testing {

inline std::function<void(const sdk::Host&)>& task() {
  static std::function<void(const sdk::Host&)> present;
  return present;
}

class Probe : public sdk::Integrator {
 public:
  static constexpr const char* id = "probe";
  static constexpr const char* summary = "runs a task";
  static constexpr bool integrates_states = true;

  Probe(sdk::Host host, sdk::Options) : host_(host), next_(host.make_state()) {}
  springnet_status advance(double until, springnet_step_report& report) {
    const auto [from, now] = host_.committed();
    host_.begin_step(from, until);
    task()(host_);
    const springnet_network& network = host_.network();
    for (auto [to, of] : {std::pair{next_->position, now.position}, std::pair{next_->velocity, now.velocity}}) {
      std::copy_n(of.x, network.node_count, to.x);
      std::copy_n(of.y, network.node_count, to.y);
      std::copy_n(of.z, network.node_count, to.z);
    }
    std::copy_n(now.internal, network.internal_count, next_->internal);
    host_.commit(until, *next_);
    report.outcome = SPRINGNET_SETTLED;
    return SPRINGNET_OK;
  }

 private:
  sdk::Host host_;
  sdk::State next_;
};

template <class... Integrators>
std::shared_ptr<const PluginHost> plugins_with() {
  static const springnet_plugin entry =
      sdk::PluginEntry<Integrators...>::make("test.probe", "1.0.0", "springnet", "MIT");
  static const auto host = [] {
    PluginHost all = PluginHost::with_default_search();
    all.add(entry);
    return std::make_shared<const PluginHost>(std::move(all));
  }();
  return host;
}

inline Simulation probe(const Network& net, unsigned threads = 1) {
  SimulationOptions options;
  options.time_step = 0.01;
  options.integrator = {"probe", {}};
  options.threads = threads;
  return {net, plugins_with<Probe>(), options};
}
// Runs a task within the first step.
inline void within_step(const Network& net, std::function<void(const sdk::Host&)> what, unsigned threads = 1) {
  task() = std::move(what);
  Simulation simulation = probe(net, threads);
  simulation.step();
}

// Three numbers a node, x of all nodes first, in memory of its own.
struct Vectors {
  explicit Vectors(std::size_t nodes) : n(nodes), values(3 * nodes) {}
  springnet_vectors out() { return {values.data(), values.data() + n, values.data() + 2 * n}; }
  [[nodiscard]] springnet_const_vectors in() const { return {values.data(), values.data() + n, values.data() + 2 * n}; }
  [[nodiscard]] Vector3 at(std::size_t k) const { return {values[k], values[n + k], values[2 * n + k]}; }
  void add(std::size_t k, const Vector3& v) {
    for (std::size_t c = 0; c < 3; ++c) values[c * n + k] += v[static_cast<Eigen::Index>(c)];
  }
  std::size_t n;
  std::vector<double> values;
};
inline Vectors copy_of(const springnet_vectors& v, std::size_t n) {
  Vectors all(n);
  std::copy_n(v.x, n, all.values.begin());
  std::copy_n(v.y, n, all.values.begin() + static_cast<std::ptrdiff_t>(n));
  std::copy_n(v.z, n, all.values.begin() + static_cast<std::ptrdiff_t>(2 * n));
  return all;
}
// A state to evaluate at.
struct At {
  explicit At(const sdk::Host& host)
      : time(host.committed().time),
        n(host.network().node_count),
        position(copy_of(host.committed().state.position, n)),
        velocity(copy_of(host.committed().state.velocity, n)) {}
  [[nodiscard]] springnet_evaluation evaluation() const {
    auto at = sdk::sized<springnet_evaluation>();
    at.time = time;
    at.position = position.in();
    at.velocity = velocity.in();
    return at;
  }
  double time;
  std::size_t n;
  Vectors position, velocity;
};

// A block with springs, two viscosities, every kind of element, gravity, a load, a pressure that follows its faces, in
// motion and out of shape.
inline Network of_everything() {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 3};
  lattice.diagonals = Diagonals::all;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(50.0, 1.0)));
  for (NodeIndex k = 0; k < 27; ++k) {
    Node node = net.nodes()[k];
    const double i = k;
    node.position += 0.1 * Vector3(std::sin(i), std::cos(2.0 * i), std::sin(3.0 * i));
    node.velocity = {std::cos(i), std::sin(2.0 * i), std::cos(5.0 * i)};
    node.mass = 1.0 + 0.1 * i;
    net.set_node(k, node);
  }
  Material relative = damped(20.0, 0.0);
  relative.viscosity = LawUse{"relative", {{"damping", 0.7}}};
  net.set_spring_material(3, net.add_material(relative));
  const MaterialIndex law = net.add_material(damped(5.0, 0.3));
  net.add_element(Invariant::angle, {1, 0, 3}, law);
  net.add_element(Invariant::dihedral, {0, 1, 3, 4}, law);
  net.add_element(Invariant::area, {9, 10, 12}, law);
  net.add_element(Invariant::volume, {13, 14, 16, 22}, law);
  std::vector<NodeIndex> surface;
  for (const Face& face : net.faces()) surface.insert(surface.end(), face.begin(), face.end());
  net.add_element(Invariant::enclosed_volume, surface, law);
  for (ElementIndex e = 0; e < net.elements().size(); ++e) net.set_reference(e, 0.8 * net.elements()[e].reference);
  net.set_gravity({0.3, -0.2, -9.81});
  net.add_load({{5, 7}, {2.0, 1.0, -3.0}});
  Load load;
  load.faces = {net.faces()[0], net.faces()[3]};
  load.pressure = 4.0;
  load.follow = true;
  net.add_load(load);
  return net;
}

}  // namespace springnet::testing
