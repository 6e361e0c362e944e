// What viscous solids and membranes dissipate, against the power of their stresses by the deformation gradient: at a
// state, summed up over time, and as the damping that a scene's damping_time promises.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/scene.hpp>
#include <springnet/sdk/law.hpp>
#include <springnet/simulation.hpp>

#include "../random_nets/plain_continuum.hpp"
#include "laws.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

const NeoHookean matrix{20.0, 0.4};
const Fibres fibres{30.0, 0.2, true, Vector3(1.0, 2.0, 2.0) / 3.0};
const Material solid{solid_law(matrix.modulus, matrix.nu), viscous_solid_law(0.7, 0.3)};
const Material fibrous{fibre_solid_law(matrix, fibres), viscous_solid_law(0.4, 0.9)};
const Material sheet{membrane_law(20.0, 0.4, 0.5), viscous_membrane_law(0.3, 0.2)};
const Material plain_sheet{membrane_law(20.0, 0.4, 0.5, false), viscous_membrane_law(0.3, 0.0)};

// Free in space, strained and in motion.
template <std::size_t N>
Network moving_net(const SimplexMesh<N>& mesh, const Material& material, unsigned seed) {
  Network net = element_net(mesh, material, fibres.along);
  std::mt19937 random(seed);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    node.position += 0.05 * random_vector(random);
    node.velocity = 0.5 * random_vector(random);
    net.set_node(k, node);
  }
  return net;
}

// Spring and damper in one law: what of its force derives from no energy is lost.
struct DampedEdges : sdk::SpringFunction {
  using has = sdk::Has<sdk::Energy>;
  enum { stiffness, viscosity };
  static constexpr const char *id = "damped_edges", *summary = "edges of a triangle as springs with dampers";
  static constexpr bool reads_rate = true;
  static constexpr sdk::Shape shape = sdk::Shape::triangle;
  static constexpr sdk::Scalar invariants[] = {sdk::length_of(0, 1), sdk::length_of(0, 2), sdk::length_of(1, 2)};
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", "of an edge"),
                                                  sdk::number("viscosity", "N s/m", "of an edge")};
  template <class E>
  static auto energy(const E& e, const auto& p) {
    auto sum = 0.0 * e.q[0];
    for (std::size_t i = 0; i < 3; ++i)
      sum += 0.5 * p[stiffness] * (e.q[i] - e.reference[i]) * (e.q[i] - e.reference[i]);
    return sum;
  }
  static auto force(const auto& e, const auto& p) {
    const auto of = [&](std::size_t i) { return p[stiffness] * (e.q[i] - e.reference[i]) + p[viscosity] * e.rate[i]; };
    return std::array{of(0), of(1), of(2)};
  }
};
constexpr springnet_plugin damped_edges =
    sdk::PluginEntry<DampedEdges>::make("test.damped_edges", "1.0.0", "springnet", "MIT");

struct Powers {
  double dissipated = 0.0;  // W
  double energy = 0.0;      // J, elastic
};
Powers own_powers(const Network& net, const Simulation& at, std::vector<double>* each = nullptr) {
  Powers sum;
  for (const Element& element : net.elements()) {
    std::vector<Vector3> position, velocity;
    for (const NodeIndex node : element.nodes) {
      position.push_back(at.position(node));
      velocity.push_back(at.velocity(node));
    }
    const Material& material = net.materials()[element.material];
    const std::vector<Vector3> viscous =
        plain_simplex_forces({std::nullopt, material.viscosity}, element, position, velocity);
    double power = 0.0;
    for (std::size_t i = 0; i < viscous.size(); ++i) power -= viscous[i].dot(velocity[i]);
    sum.dissipated += power;
    if (each != nullptr) each->push_back(power);
    const PlainRest rest(element.rest);
    const Matrix3 f = rest.gradient(position);
    const LawUse& law = *material.spring;
    double density = 0.0;
    if (law.id == "membrane")
      density = PlaneStress{20.0, 0.4, 0.5, parameter_of(law, "model") == 0.0}.energy(f);
    else
      density = matrix.energy(f) + (law.id == "fibre_solid" ? fibres.energy(f) : 0.0);
    sum.energy += rest.size * density;
  }
  return sum;
}

SimulationOptions with_energy(const LawUse& integrator, double time_step) {
  SimulationOptions options;
  options.time_step = time_step;
  options.integrator = integrator;
  options.threads = 1;
  options.dissipated_energy = true;
  return options;
}

std::vector<std::pair<std::string, Network>> moving_nets(unsigned seed) {
  const SimplexMesh<4> box = solid_mesh(2, {1.0, 1.2, 0.8}, seed);
  const SimplexMesh<3> flat = sheet_mesh(3, 1.0, 1.3, seed);
  return {{"solid", moving_net(box, solid, seed)},
          {"fibre_solid", moving_net(box, fibrous, seed)},
          {"membrane", moving_net(flat, sheet, seed)},
          {"St. Venant membrane", moving_net(flat, plain_sheet, seed)}};
}

}  // namespace

TEST_CASE("the dissipation of elements over several scalars is that of their viscous stress, and none is elastic") {
  for (auto& [name, net] : moving_nets(3)) {
    CAPTURE(name);
    Simulation simulation(net, plugins(), with_energy(recurrent(newton, 1e-9), 1e-3));
    simulation.step();
    std::vector<double> each;
    const Powers own = own_powers(net, simulation, &each);
    CHECK(own.dissipated > 0.01);
    CHECK(simulation.dissipated_power() == doctest::Approx(own.dissipated).epsilon(1e-12));
    for (ElementIndex e = 0; e < net.elements().size(); ++e)
      CHECK(std::abs(simulation.element_dissipation(e) - each[e]) <= 1e-12 * own.dissipated);
    CHECK(simulation.potential_energy() == doctest::Approx(own.energy).epsilon(1e-11));
  }
}

TEST_CASE("a spring function over several scalars dissipates what of its force derives from no energy") {
  constexpr double viscosity = 0.8;
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  host->add(damped_edges);
  const Material material{LawUse{"damped_edges", {{"stiffness", 30.0}, {"viscosity", viscosity}}}, std::nullopt};
  const Network net = moving_net(sheet_mesh(3, 1.0, 1.3, 5), material, 5);
  // c l'^2 of each edge.
  const auto power = [&](const Simulation& at, const Element& element) {
    double sum = 0.0;
    for (const auto& [a, b] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
      const NodeIndex i = element.nodes[static_cast<std::size_t>(a)], j = element.nodes[static_cast<std::size_t>(b)];
      const double rate = (at.position(i) - at.position(j)).normalized().dot(at.velocity(i) - at.velocity(j));
      sum += viscosity * rate * rate;
    }
    return sum;
  };
  const auto lost = [&](double time_step) {  // of what leaves the kinetic and elastic energy in 0.2 s
    Simulation simulation(net, host, with_energy(recurrent(newton, 1e-10, {{"theta", 0.5}}), time_step));
    const double before = simulation.kinetic_energy() + simulation.potential_energy();
    simulation.step();
    double sum = 0.0;
    for (ElementIndex e = 0; e < net.elements().size(); ++e) {
      const double own = power(simulation, net.elements()[e]);
      CHECK(simulation.element_dissipation(e) == doctest::Approx(own).epsilon(1e-10));
      sum += own;
    }
    CHECK(sum > 0.1);
    CHECK(simulation.dissipated_power() == doctest::Approx(sum).epsilon(1e-10));
    while (simulation.time() < 0.2 - 0.5 * time_step) simulation.step();
    const double gone = before - simulation.kinetic_energy() - simulation.potential_energy();
    return std::pair(gone, simulation.dissipated_energy());
  };
  const auto [coarse_gone, coarse] = lost(2e-3);
  const auto [gone, fine] = lost(5e-4);
  CHECK(gone > 0.02);
  CHECK(fine == doctest::Approx(gone).epsilon(1e-3));
  CHECK(std::abs(fine - gone) <= std::abs(coarse - coarse_gone) / 12.0 + 1e-8);  // of second order
}

TEST_CASE("dissipated energy of elements over several scalars is the integral of their power") {
  for (auto& [name, net] : moving_nets(4)) {
    CAPTURE(name);
    constexpr double until = 0.2;
    const auto at = [&](int steps) {
      Simulation simulation(net, plugins(), with_energy(cvode(1e-11), until / steps));
      double integral = 0.0, before = own_powers(net, simulation).dissipated;
      // Simpson's rule over pairs of steps.
      for (int step = 0; step < steps; step += 2) {
        simulation.step();
        const double middle = own_powers(net, simulation).dissipated;
        simulation.step();
        const double end = own_powers(net, simulation).dissipated;
        integral += until / steps / 3.0 * (before + 4.0 * middle + end);
        before = end;
      }
      return std::pair(integral, simulation.dissipated_energy());
    };
    const auto [coarse_integral, coarse] = at(40);
    const auto [integral, fine] = at(160);
    CHECK(integral > 0.01);
    CHECK(coarse_integral == doctest::Approx(integral).epsilon(1e-5));
    // The sum over steps is of second order.
    CHECK(std::abs(fine - integral) <= 1e-3 * integral);
    CHECK(std::abs(fine - integral) <= std::abs(coarse - integral) / 12.0 + 1e-7 * integral);
  }
}

TEST_CASE("kinetic, elastic and dissipated energy of elements over several scalars change by the work of loads alone") {
  for (auto& [name, net] : moving_nets(5)) {
    CAPTURE(name);
    Load load;
    load.nodes = {0, 5};
    load.force = {0.5, -1.0, 2.0};
    net.add_load(load);
    const auto error = [&](double theta, double time_step) {
      Simulation simulation(net, plugins(), with_energy(recurrent(newton, 1e-11, {{"theta", theta}}), time_step));
      const auto balance = [&] {
        double sum = simulation.kinetic_energy() + own_powers(net, simulation).energy + simulation.dissipated_energy();
        for (const NodeIndex node : load.nodes) sum -= load.force.dot(simulation.position(node));
        return sum;
      };
      const double start = balance();
      double greatest = 0.0;
      while (simulation.time() < 0.3 - 1e-9) {
        simulation.step();
        greatest = std::max(greatest, std::abs(balance() - start));
      }
      CHECK(simulation.dissipated_energy() > 0.02);
      return greatest / simulation.dissipated_energy();
    };
    const double first = error(1.0, 1e-3), fine_first = error(1.0, 2.5e-4);
    CAPTURE(first);
    CHECK(first < 0.2);
    CHECK(fine_first < first / 3.0);
    const double second = error(0.5, 4e-3), fine_second = error(0.5, 1e-3);
    CAPTURE(second);
    CHECK(second < 0.05);
    CHECK(fine_second < second / 12.0);
  }
}

namespace {

// A body of a scene of whose nodes only one is free: the matrices of this node, by Hooke's law for a displacement u
// that falls to 0 over each element, the gradient u g^T: forces -V sigma g.
struct OneNode {
  double lambda, mu, size;  // of stress per strain; volume per m^3, or per m^2 of a sheet

  [[nodiscard]] Matrix3 stiffness(const Network& net, NodeIndex node) const {
    Matrix3 sum = Matrix3::Zero();
    for (const Element& element : net.elements()) {
      const auto place = std::find(element.nodes.begin(), element.nodes.end(), node) - element.nodes.begin();
      if (place == static_cast<std::ptrdiff_t>(element.nodes.size())) continue;
      std::vector<Vector3> unit(element.nodes.size(), Vector3::Zero());
      unit[static_cast<std::size_t>(place)] = Vector3::UnitX();
      const PlainRest rest(element.rest);
      const Vector3 g = rest.axes * rest.gradient(unit).row(0).transpose();
      // Out of its plane a sheet has no stiffness.
      const Matrix3 within = element.invariant == Invariant::triangle
                                 ? Matrix3(Matrix3::Identity() - rest.axes.col(2) * rest.axes.col(2).transpose())
                                 : Matrix3(Matrix3::Identity());
      sum += size * rest.size * (mu * g.squaredNorm() * within + (lambda + mu) * g * g.transpose());
    }
    return sum;
  }
};

void check_decay(const std::string& body, NodeIndex free, const OneNode& material, double damping_time) {
  const PluginHost& host = *plugins();
  Network net = parse_scene(
                    "[simulation]\nduration = 1.0\ntime_step = 0.01\n[[body]]\nname = \"b\"\n"
                    "neuron = { type = \"point_mass\", mass = 0.5 }\n" +
                        body,
                    "test.toml", host, {}, ".")
                    .network;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k)
    if (k != free) net.fix(k);
  const Node start = net.nodes()[free];
  const Eigen::SelfAdjointEigenSolver<Matrix3> modes(material.stiffness(net, free));
  int decaying = 0;
  for (Eigen::Index mode = 0; mode < 3; ++mode) {
    const double stiffness = modes.eigenvalues()[mode], square = stiffness / start.mass;
    if (stiffness < 1e-9 * modes.eigenvalues()[2]) continue;
    ++decaying;
    // x'' + tau w^2 x' + w^2 x = 0
    const double rate = 0.5 * damping_time * square, w = std::sqrt(square - rate * rate);
    REQUIRE(square > rate * rate);
    constexpr double amplitude = 1e-5;  // m; terms of second order are its share of the body's size
    Node moved = start;
    moved.position += amplitude * modes.eigenvectors().col(mode);
    Network displaced = net;
    displaced.set_node(free, moved);
    Simulation simulation =
        simulate(displaced, recurrent(newton, 1e-9 * stiffness * amplitude, {{"theta", 0.5}}), 2e-3 / w);
    double greatest = 0.0;
    for (int step = 0; step < 2000; ++step) {
      simulation.step();
      const double t = simulation.time(),
                   x = modes.eigenvectors().col(mode).dot(simulation.position(free) - start.position);
      const double expected = amplitude * std::exp(-rate * t) * (std::cos(w * t) + rate / w * std::sin(w * t));
      greatest = std::max(greatest, std::abs(x - expected));
    }
    CAPTURE(mode);
    // Of the second order in the amplitude, and 1e-6 of the time step.
    CHECK(greatest < 2e-4 * amplitude);
    CHECK(std::exp(-rate * simulation.time()) < 0.9);  // something decays
  }
  CHECK(decaying >= 2);
}

}  // namespace

// The elastic moduli times the damping time: each mode of angular frequency w decays at the rate tau w^2 / 2.
TEST_CASE("damping_time of a body of elements damps every mode as a Kelvin-Voigt material") {
  constexpr double modulus = 2e3, nu = 0.3, tau = 2e-3, shear = modulus / (2.0 * (1.0 + nu));
  check_decay(
      "mesh = { lattice = [3, 3, 3], spacing = [0.5, 0.4, 0.3] }\n"
      "material = { youngs_modulus = 2e3, poisson_ratio = 0.3, damping_time = 2e-3, law = \"solid\" }\n",
      13, {modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), shear, 1.0}, tau);
  for (const char* model : {"neo_hookean", "st_venant_kirchhoff"})
    check_decay(
        "mesh = { lattice = [3, 3, 1], spacing = [0.5, 0.4, 0.3] }\nthickness = 0.02\n"
        "material = { youngs_modulus = 2e3, poisson_ratio = 0.3, damping_time = 1e-2, law = { type = "
        "\"membrane\", model = \"" +
            std::string(model) + "\" } }\n",
        4, {modulus * nu / (1.0 - nu * nu), shear, 0.02}, 1e-2);
}
