// Laws that return nan, throw, or cannot be evaluated by the engine: errors name the law and the spring. The laws are
// plugins registered statically.

#include <doctest/doctest.h>

#include <limits>

#include <springnet/error.hpp>

#define SPRINGNET_STATIC_PLUGIN failures
#include <springnet/sdk/integrator.hpp>
#include <springnet/sdk/law.hpp>
#include <springnet/sdk/neuron.hpp>

#include "facts.hpp"
#include "nets.hpp"

namespace {

namespace sdk = springnet::sdk;

// Not a number beyond a length, like the square root of a negative number.
struct NanBeyond : sdk::SpringFunction {
  static constexpr const char* id = "nan_beyond";
  static constexpr const char* summary = "not a number beyond a length";
  static constexpr sdk::Parameter parameters[] = {sdk::number("length", "m", "where it fails").at_least(0)};
  static auto force(const auto& e, const auto& p) { return sqrt(p[0] - e.q) * 0.0; }
};

struct Throws : sdk::SpringFunction {
  static constexpr const char* id = "throws";
  static constexpr const char* summary = "fails with a message";
  static auto force(const auto& e, const auto&) {
    if (e.q > 1.5) throw std::runtime_error("the tissue is torn");
    return e.q * 0.0;
  }
};

struct Remembers : sdk::SpringFunction {
  static constexpr const char* id = "remembers";
  static constexpr const char* summary = "has internal state";
  static constexpr sdk::Parameter states[] = {sdk::number("damage", "1", "0 is whole").preset(0).at_least(0)};
  static auto force(const auto& e, const auto&) { return e.q * e.state(0); }
  template <class Real>
  static std::array<Real, 1> state_rates(const sdk::Element<Real>& e, const sdk::Parameters<Real>&) {
    return {e.q};
  }
};

struct Steered : sdk::SpringFunction {
  static constexpr const char* id = "steered";
  static constexpr const char* summary = "reads a signal";
  static constexpr sdk::Parameter inputs[] = {sdk::number("activation", "1", "of a muscle").preset(0)};
  static auto force(const auto& e, const auto&) { return e.q * e.input(0); }
};

struct Measured : sdk::SpringFunction {
  static constexpr const char* id = "measured";
  static constexpr const char* summary = "reads a curve";
  static constexpr sdk::Table tables[] = {sdk::table("curve", "N", "tension")};
  static double prepare(const sdk::TableSource& source) { return source[0][0]; }
  static auto force(const auto& e, const auto&) { return e.q * e.table; }
};

// A law of an area, and one that needs a reference value.
struct Skin : sdk::SpringFunction {
  static constexpr const char* id = "skin";
  static constexpr const char* summary = "of an area";
  static constexpr std::uint32_t invariant = SPRINGNET_AREA;
  static auto force(const auto& e, const auto&) { return e.elongation(); }
};
struct LengthOnly : sdk::SpringFunction {
  static constexpr const char* id = "length_only";
  static constexpr const char* summary = "does not say that it fits elements";
  static auto force(const auto& e, const auto&) { return e.elongation(); }
};
struct Strained : sdk::SpringFunction {
  static constexpr const char* id = "strained";
  static constexpr const char* summary = "of the strain";
  static constexpr bool fits_elements = true;
  static constexpr bool divides_by_reference = true;
  static auto force(const auto& e, const auto&) { return e.strain(); }
};

class Forgetful : public sdk::Integrator {
 public:
  static constexpr const char* id = "forgetful";
  static constexpr const char* summary = "does not integrate internal state";
  Forgetful(sdk::Host, sdk::Options) {}
  springnet_status advance(double, springnet_step_report&) { return SPRINGNET_FAILED; }
};

// A finitely extensible spring (Warner 1972): beyond its limit the formula's force is finite, its energy is not.
struct Fene : sdk::SpringFunction {
  using has = sdk::Has<sdk::Energy>;
  static constexpr const char* id = "fene";
  static constexpr const char* summary = "force grows without bound towards a greatest length";
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", "at length 0").at_least(0),
                                                  sdk::number("limit", "m", "greatest length").above(0)};
  static auto force(const auto& e, const auto& p) {
    const auto share = e.q / p[1];
    return p[0] * e.q / (1.0 - share * share);
  }
  static auto energy(const auto& e, const auto& p) {
    const auto share = e.q / p[1];
    return -0.5 * p[0] * p[1] * p[1] * log(1.0 - share * share);
  }
};

struct NanNeuron : sdk::Neuron {
  static constexpr const char* id = "nan_neuron";
  static constexpr const char* summary = "not a number beyond a place";
  static auto acceleration(const auto& n, const auto&) { return n.force * (sqrt(1.5 - n.position.x) * 0.0); }
};

struct ThrowingNeuron : sdk::Neuron {
  static constexpr const char* id = "throwing_neuron";
  static constexpr const char* summary = "fails with a message";
  static auto acceleration(const auto& n, const auto&) {
    if (n.position.x > 1.5) throw std::runtime_error("the axon is cut");
    return n.force / n.mass;
  }
};

}  // namespace

SPRINGNET_PLUGIN("test.failures", "1.0.0", "springnet", "MIT", NanBeyond, Throws, Remembers, Steered, Measured, Skin,
                 LengthOnly, Strained, Forgetful, Fene, NanNeuron, ThrowingNeuron);

using namespace springnet;
using namespace springnet::testing;

namespace {

std::shared_ptr<const PluginHost> host() {
  auto plugin_host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  REQUIRE(plugin_host->add(springnet_plugin_entry_failures));
  return plugin_host;
}

}  // namespace

TEST_CASE("a law that returns nan is named with its spring and nodes, and the last finite state stays") {
  for (const LawUse& integrator :
       {recurrent(synchronous, 1e-9), recurrent(wavefront, 1e-9), single_sweep(), cvode(1e-6)}) {
    CAPTURE(integrator.id);
    Network net;
    const MaterialIndex fine = net.add_material(damped(0.0, 0.0));
    const MaterialIndex bad = net.add_material({LawUse{"nan_beyond", {{"length", 1.5}}}, std::nullopt});
    for (int k = 0; k < 5; ++k) net.add_node(point({double(k), 0, 0}, 1.0, {k >= 3 ? 1.0 : 0.0, 0, 0}));
    for (SpringIndex s = 0; s < 4; ++s) net.add_spring(s, s + 1, s == 2 ? bad : fine);
    SimulationOptions options;
    options.time_step = 0.1;
    options.integrator = integrator;
    Simulation simulation(net, host(), options);
    std::string text;
    try {
      simulation.advance_to(2.0);
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::simulation);
      text = error.what();
    }
    CAPTURE(text);
    CHECK(text.find("nan_beyond") != std::string::npos);
    CHECK(text.find("spring 2 (nodes 2 and 3") != std::string::npos);
    CHECK(simulation.time() >= 0.3);
    CHECK(simulation.time() < 0.75);
    CHECK(simulation.positions().allFinite());
    CHECK(simulation.velocities().allFinite());
  }
}

TEST_CASE("an exception of a law becomes the error of the step") {
  for (const LawUse& integrator : {recurrent(synchronous, 1e-9), recurrent(wavefront, 1e-9), cvode(1e-6)}) {
    Network net;
    net.add_node(point({0, 0, 0}));
    net.add_node(point({1, 0, 0}, 1.0, {1, 0, 0}));
    net.add_spring(0, 1, net.add_material({LawUse{"throws", {}}, std::nullopt}));
    SimulationOptions options;
    options.time_step = 0.1;
    options.integrator = integrator;
    Simulation simulation(net, host(), options);
    CHECK_THROWS_WITH_AS(simulation.advance_to(2.0), doctest::Contains("the tissue is torn"), Error);
  }
}

TEST_CASE("a law without its table is refused by name; without a signal an input has its preset") {
  const auto net = [](const char* id) { return oscillator(Material{LawUse{id, {}}, std::nullopt}, 1.0, 0.0); };
  CHECK_THROWS_WITH_AS(Simulation(net("measured"), host(), {}),
                       doctest::Contains("'measured' needs the table 'curve' (N: tension)"), Error);
  const Simulation steered(net("steered"), host(), {});
  CHECK(steered.tension(0) == 0.0);
}

TEST_CASE("an integrator that does not integrate internal state is refused where a law has some") {
  const Network net = oscillator(Material{LawUse{"remembers", {}}, std::nullopt}, 1.0, 0.0);
  SimulationOptions options;
  CHECK_NOTHROW(Simulation(net, host(), options));
  options.integrator = {"forgetful", {}};
  CHECK_THROWS_WITH_AS(Simulation(net, host(), options),
                       doctest::Contains("integrator 'forgetful' does not integrate the internal state of laws"),
                       Error);
  const Network without = oscillator(damped(1.0, 0.0), 1.0, 0.0);
  CHECK_NOTHROW(Simulation(without, host(), options));
}

TEST_CASE("laws are used on elements that they are made for, or declare to fit") {
  const auto with = [](const char* law, Invariant invariant, double reference) {
    Network net;
    net.add_node(point({0, 0, 0}));
    net.add_node(point({1, 0, 0}));
    net.add_node(point({0, 1, 0}));
    const MaterialIndex material = net.add_material({LawUse{law, {}}, std::nullopt});
    net.set_reference(net.add_element(invariant, {0, 1, 2}, material), reference);
    return net;
  };
  CHECK_NOTHROW(Simulation(with("skin", Invariant::area, 0.5), host(), {}));
  CHECK_NOTHROW(Simulation(with("skin", Invariant::area, 0.0), host(), {}));
  CHECK_NOTHROW(Simulation(with("strained", Invariant::area, 0.5), host(), {}));
  CHECK_THROWS_WITH_AS(Simulation(with("skin", Invariant::angle, 0.5), host(), {}),
                       doctest::Contains("'skin' reads an area"), Error);
  CHECK_THROWS_WITH_AS(Simulation(with("length_only", Invariant::area, 0.5), host(), {}),
                       doctest::Contains("'length_only' reads a length; use a law on the length that declares"), Error);
  CHECK_THROWS_WITH_AS(Simulation(with("strained", Invariant::area, 0.0), host(), {}),
                       doctest::Contains("'strained' divides by the reference value, which is 0 here"), Error);
  const Network spring = oscillator(Material{LawUse{"skin", {}}, std::nullopt}, 1.0, 0.0);
  CHECK_THROWS_WITH_AS(Simulation(spring, host(), {}), doctest::Contains("'skin' reads an area"), Error);
}

TEST_CASE("a law that divides by the rest length is refused on a spring without one, by the spring's number") {
  Network net;
  const MaterialIndex fine = net.add_material(damped(1.0, 0.0));
  const MaterialIndex strained = net.add_material({LawUse{"strained", {}}, std::nullopt});
  const MaterialIndex exponential = net.add_material({LawUse{"exponential", {{"stiffness", 1.0}}}, std::nullopt});
  for (int k = 0; k < 5; ++k) net.add_node(point({double(k), 0, 0}));
  net.add_spring(0, 1, fine, 0.0);  // this law does not divide
  net.add_spring(1, 2, strained, 1.0);
  net.add_spring(2, 3, strained, 2.0);
  CHECK_NOTHROW(Simulation(net, host(), {}));
  net.add_spring(3, 4, exponential, 0.0);
  CHECK_THROWS_WITH_AS(Simulation(net, host(), {}),
                       "spring 3: spring function 'exponential' divides by the rest length, which is 0 here; give one "
                       "above 0, or use another law",
                       Error);
  // All springs alike.
  const Network alike = [&] {
    Network one;
    for (int k = 0; k < 3; ++k) one.add_node(point({double(k), 0, 0}));
    const MaterialIndex material = one.add_material({LawUse{"strained", {}}, std::nullopt});
    for (SpringIndex s = 0; s < 2; ++s) one.add_spring(s, s + 1, material, 0.0);
    return one;
  }();
  CHECK_THROWS_WITH_AS(Simulation(alike, host(), {}), doctest::Contains("spring 0: spring function 'strained' divides"),
                       Error);
}

TEST_CASE("unknown laws and integrators give the nearest name, parameters out of range their own") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}));
  net.add_spring(0, 1, net.add_material({LawUse{"liner", {}}, std::nullopt}));
  CHECK_THROWS_WITH_AS(Simulation(net, host(), {}), doctest::Contains("'linear'"), Error);

  Network negative;
  negative.add_node(point({0, 0, 0}));
  negative.add_node(point({1, 0, 0}));
  negative.add_spring(0, 1, negative.add_material(damped(-1.0, 0.0)));
  CHECK_THROWS_WITH_AS(Simulation(negative, host(), {}), doctest::Contains("stiffness"), Error);

  Network fine;
  fine.add_node(point({0, 0, 0}));
  SimulationOptions options;
  options.integrator = {"recurent", {}};
  CHECK_THROWS_WITH_AS(Simulation(fine, host(), options), doctest::Contains("recurrent"), Error);
  options.integrator = {"recurrent", {{"sweps", 1}}};
  CHECK_THROWS_WITH_AS(Simulation(fine, host(), options), doctest::Contains("sweeps"), Error);
}

TEST_CASE("a neuron that returns nan or throws is named with its node") {
  for (const LawUse& integrator :
       {recurrent(synchronous, 1e-9), recurrent(wavefront, 1e-9), single_sweep(), cvode(1e-6)}) {
    for (const char* id : {"nan_neuron", "throwing_neuron"}) {
      Network net;
      net.add_node(point({0, 5, 0}));
      Node node = point({1, 0, 0}, 1.0, {1, 0, 0});
      node.neuron = net.add_neuron({id, {}});
      net.add_node(node);
      SimulationOptions options;
      options.time_step = 0.1;
      options.integrator = integrator;
      Simulation simulation(net, host(), options);
      std::string text;
      try {
        simulation.advance_to(2.0);
      } catch (const Error& error) {
        text = error.what();
      }
      CAPTURE(integrator.id);
      CAPTURE(text);
      CHECK(text.find(id) != std::string::npos);
      CHECK(text.find("node 1") != std::string::npos);
      CHECK((id == std::string("nan_neuron") || text.find("the axon is cut") != std::string::npos));
      CHECK(simulation.last_report().outcome == Outcome::diverging);
      CHECK(simulation.time() < 0.75);
    }
  }
}

TEST_CASE("of springs that fail in several threads the same one is named, for every number of threads") {
  for (const unsigned threads : {1u, 2u, 4u}) {
    Lattice lattice;
    lattice.nodes = {2, 2, 6000};  // three units
    Network net;
    net.add_lattice("rod", lattice, Node{}, net.add_material({LawUse{"throws", {}}, std::nullopt}));
    for (const NodeIndex k : {5000u, 23000u, 12000u}) {
      Node node = net.nodes()[k];
      node.velocity = {0, 30, 0};
      net.set_node(k, node);
    }
    SimulationOptions options;
    options.time_step = 0.1;
    options.threads = threads;
    options.integrator = single_sweep();
    Simulation simulation(net, host(), options);
    CHECK(simulation.threads() == std::min(threads, 4u));
    simulation.step();
    std::string text;
    try {
      simulation.step();
    } catch (const Error& error) {
      text = error.what();
    }
    CAPTURE(text);
    CHECK(text.find("the tissue is torn") != std::string::npos);
    CHECK(has_all(text, {"'throws'", "test.failures", "spring "}));
    static std::string first;
    if (first.empty()) first = text;
    CHECK(text == first);
  }
}

TEST_CASE("an energy that is not finite is noted once, with time, law, spring and nodes") {
  Network net;
  Node wall = point(Vector3::Zero());
  wall.fixed = true;
  net.add_node(wall);
  net.add_node(point({1.0, 0, 0}, 1.0, {50.0, 0, 0}));
  const MaterialIndex material = net.add_material({LawUse{"fene", {{"stiffness", 1.0}, {"limit", 1.5}}}, std::nullopt});
  net.add_spring(0, 1, material);
  SimulationOptions options;
  options.time_step = 0.05;
  options.integrator = {"verlet", {}};
  Simulation simulation(net, host(), options);
  CHECK(std::isfinite(simulation.potential_energy()));
  CHECK(simulation.notes().empty());
  simulation.step();
  CHECK(simulation.last_report().outcome == Outcome::settled);
  CHECK(std::isnan(simulation.potential_energy()));
  REQUIRE(simulation.notes().size() == 1);
  const std::string note = simulation.notes()[0];
  CAPTURE(note);
  CHECK(has_all(note,
                {"0.05 s", "energy", "'fene'", "test.failures", " nan ", "spring 0", "nodes 0 and 1", "length 3."}));
  simulation.step();
  static_cast<void>(simulation.potential_energy());
  CHECK(simulation.notes().size() == 1);
}

TEST_CASE("distances in messages are rounded to the digits that matter") {
  springnet::Network net = springnet::testing::oscillator(springnet::testing::damped(4.0, 0.0), 1.0, 0.1);
  net.add_plane({.name = "wall", .point = {1.4, 0, 0}, .normal = {1, 0, 0}});  // 1.4 - 1.1 is 0.2999999999999998
  try {
    static_cast<void>(springnet::testing::simulate(net, springnet::testing::recurrent(1, 1e-9), 0.01));
    FAIL("a node started behind a plane");
  } catch (const springnet::Error& error) {
    CHECK(has_all(error.what(), {"node 1", " 0.3 m", "plane 'wall'"}));
  }
}

TEST_CASE("times in messages have no rounding error from summed steps") {
  springnet::Simulation simulation =
      springnet::testing::simulate(springnet::testing::oscillator(springnet::testing::damped(4.0, 0.0), 1.0, 0.1),
                                   springnet::testing::recurrent(1, 1e-9), 0.01);
  for (int k = 0; k < 57; ++k) simulation.step();
  try {
    simulation.advance_to(0.1);
    FAIL("advanced to an earlier time");
  } catch (const springnet::Error& error) {
    CHECK(has_all(error.what(), {" 0.57 s", " 0.1 s"}));
  }
}
