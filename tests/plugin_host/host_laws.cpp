// Laws and neurons that the program itself registers: from classes with members, lambdas and C functions; how long they
// live, and what is refused.
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/host_laws.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;
namespace sdk = springnet::sdk;

// Counts the objects that exist.
class Counted {
 public:
  explicit Counted(int& alive) : alive_(&alive) { ++*alive_; }
  Counted(const Counted& other) : alive_(other.alive_) { ++*alive_; }
  Counted& operator=(const Counted&) = delete;
  ~Counted() { --*alive_; }

 private:
  int* alive_;
};

struct Scaled : sdk::SpringFunction {
  using has = sdk::Has<sdk::Energy>;
  static constexpr const char *id = "scaled", *summary = "Hooke's law times a factor of the object";
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", "before the factor").at_least(0)};
  std::vector<double> factors;  // heap memory: AddressSanitizer sees a use after it is freed
  Counted counted;

  auto force(const auto& e, const auto& p) const { return factors[0] * p[0] * e.elongation(); }
  auto energy(const auto& e, const auto& p) const { return 0.5 * force(e, p) * e.elongation(); }
};

HostComponent scaled(double factor, int& alive) { return spring_function(Scaled{{}, {factor}, Counted(alive)}); }

SimulationOptions options(const LawUse& integrator = recurrent(newton, 1e-10)) {
  SimulationOptions result;
  result.time_step = 1e-2;
  result.integrator = integrator;
  return result;
}

// 1 kg at 1.1 m from a wall, with a spring of rest length 1 m.
Network hanging(const LawUse& law) { return oscillator({law, std::nullopt}, 1.0, 0.1); }

std::shared_ptr<PluginHost> shipped() { return std::make_shared<PluginHost>(PluginHost::with_default_search()); }

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::plugin);
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("an object's members are what its law computes with") {
  int alive = 0;
  const auto host = shipped();
  const auto component = host->add(scaled(3.0, alive));
  CHECK(component->id() == "scaled");
  CHECK(std::string_view(component->plugin->id) == "host");
  CHECK(component->file.empty());
  CHECK(host->refusals().empty());
  CHECK(host->require(ComponentKind::spring_function, "scaled") == component);
  Simulation simulation(hanging({"scaled", {{"stiffness", 2.0}}}), host, options());
  CHECK(simulation.tension(0) == doctest::Approx(3.0 * 2.0 * 0.1).epsilon(1e-14));
}

TEST_CASE("an object lives as long as a host, a simulation or a component that uses it, and no longer") {
  int alive = 0;
  std::optional<Simulation> simulation;
  {
    std::string id = "renamed_" + std::string(100, 'x');  // on the heap, gone at the end of the block
    id.resize(40);
    auto host = shipped();
    const std::string plugin = "org.example.game", version = "1.2";  // gone, too
    host->add(scaled(3.0, alive).renamed(id), plugin, version);
    CHECK(alive == 1);
    PluginHost moved = std::move(*host);
    CHECK(alive == 1);
    auto last = std::make_shared<const PluginHost>(std::move(moved));
    simulation.emplace(hanging({id, {{"stiffness", 2.0}}}), last, options());
  }
  CHECK(alive == 1);
  simulation->advance_to(0.2);
  CHECK(std::isfinite(simulation->tension(0)));
  Simulation other = std::move(*simulation);
  simulation.reset();
  CHECK(alive == 1);
  other.advance_to(0.4);

  // A component alone keeps all of it.
  std::shared_ptr<const Component> component;
  int kept = 0;
  {
    PluginHost host;
    component = host.add(scaled(1.0, kept), "org.example.game", "1.2");
  }
  CHECK(kept == 1);
  CHECK(std::string_view(component->plugin->version) == "1.2");
  CHECK(std::string_view(component->description->parameters[0]->name) == "stiffness");
  component.reset();
  CHECK(kept == 0);
  { const Simulation last = std::move(other); }
  CHECK(alive == 0);
}

TEST_CASE("what is refused is freed, and the host goes on") {
  int alive = 0;
  PluginHost host;
  host.add(scaled(1.0, alive));
  CHECK(message_of([&] { host.add(scaled(2.0, alive)); }).find("spring function 'scaled' is already provided") !=
        std::string::npos);
  CHECK(alive == 1);
  CHECK(host.components().size() == 1);
  CHECK(host.refusals().empty());
  CHECK(message_of([&] { static_cast<void>(scaled(1.0, alive).renamed("Bad Name")); }).find("has the id 'Bad Name'") !=
        std::string::npos);
  CHECK(message_of([&] { host.add(scaled(1.0, alive).renamed("other"), ""); }).find("the plugin has no id") !=
        std::string::npos);
  CHECK(alive == 1);
  host.add(scaled(2.0, alive).renamed("second"));
  CHECK(alive == 2);
}

TEST_CASE("a component keeps its object alone, however often it was renamed") {
  int alive = 0;
  {
    HostComponent component = scaled(1.0, alive);
    for (int k = 0; k < 200'000; ++k)
      component = component.renamed("other");  // a chain of all would overflow the stack
    CHECK(alive == 1);
  }
  CHECK(alive == 0);
}

TEST_CASE("an id that a plugin has, too, is ambiguous unless the plugin is named") {
  const auto host = shipped();
  host->add(spring_function(describe("linear", "twice as stiff", sdk::number("stiffness", "N/m", "half of it")),
                            [](const auto& e, const auto& p) { return 2.0 * p[0] * e.elongation(); }),
            "org.example.game");
  const ParameterValues stiffness{{"stiffness", 5.0}};
  CHECK(message_of([&] {
          Simulation(hanging({"linear", stiffness}), host, options());
        }).find("'linear@org.example.game'") != std::string::npos);
  CHECK(Simulation(hanging({"linear@org.example.game", stiffness}), host, options()).tension(0) ==
        doctest::Approx(1.0).epsilon(1e-14));
  CHECK(Simulation(hanging({"linear@springnet.spring.linear", stiffness}), host, options()).tension(0) ==
        doctest::Approx(0.5).epsilon(1e-14));
}

TEST_CASE("descriptions of lambdas arrive as written") {
  PluginHost host;
  const auto law = host.add(spring_function(
      describe("muscle", "pulls", sdk::number("strength", "N", "most").above(0).at_most(9).learnable(3),
               sdk::choice("mode", {"slow", "fast"}, "which"))
          .reference("A. V. Hill 1938")
          .reads_rate()
          .reads_time()
          .pulls_only()
          .adds_power()
          .not_zero_at_rest()
          .divides_by_reference()
          .fits_elements()
          .monotone()
          .calling_thread_only()
          .holds_for_stretch(0.5, 1.5),
      [](const auto& e, const auto& p) { return p[0] * e.strain() * e.time + p[1] * e.rate; },
      [](const auto& e, const auto& p) { return p[0] * e.q; }));
  const springnet_component& description = *law->description;
  CHECK(std::string_view(description.summary) == "pulls");
  CHECK(std::string_view(description.reference) == "A. V. Hill 1938");
  CHECK(description.capabilities ==
        (SPRINGNET_HAS_ENERGY | SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_ALL_DERIVATIVES |
         SPRINGNET_HAS_PARAMETER_DERIVATIVES | SPRINGNET_READS_RATE | SPRINGNET_READS_TIME | SPRINGNET_ADDS_POWER |
         SPRINGNET_NOT_ZERO_AT_REST | SPRINGNET_DIVIDES_BY_REFERENCE | SPRINGNET_FITS_ELEMENTS | SPRINGNET_MONOTONE |
         SPRINGNET_CALLING_THREAD_ONLY));
  REQUIRE(description.parameter_count == 2);
  const springnet_parameter& strength = *description.parameters[0];
  CHECK(std::string_view(strength.unit) == "N");
  CHECK(strength.largest == 9);
  CHECK(strength.scale == 3);
  CHECK(strength.flags == (SPRINGNET_REQUIRED | SPRINGNET_LEARNABLE | SPRINGNET_EXCLUDES_SMALLEST));
  const springnet_parameter& mode = *description.parameters[1];
  REQUIRE(mode.choice_count == 2);
  CHECK(std::string_view(mode.choices[1]) == "fast");
  CHECK(law->law().smallest_stretch == 0.5);
  CHECK(law->law().largest_stretch == 1.5);

  const auto drag = host.add(viscosity_function(describe("drag", "of the air").on_relative_speed(),
                                                [](const auto& e, const auto&) { return e.q * e.q; }));
  CHECK(drag->kind() == ComponentKind::viscosity_function);
  CHECK(drag->law().invariant == SPRINGNET_RELATIVE_SPEED);
  CHECK(drag->description->capabilities ==
        (SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_ALL_DERIVATIVES | SPRINGNET_ACTS_IN_COMPRESSION));
  const auto model = host.add(
      neuron(describe("heavy", "twice the mass"), [](const auto& n, const auto&) { return n.force / n.mass; }));
  CHECK(model->kind() == ComponentKind::neuron);
  CHECK(model->description->capabilities == (SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_PARAMETER_DERIVATIVES));
}

TEST_CASE("a law can be added while simulations run, for those that come") {
  const auto host = shipped();
  Simulation before(hanging({"linear", {{"stiffness", 2.0}}}), host, options());
  before.advance_to(0.1);
  int alive = 0;
  host->add(scaled(1.0, alive));
  before.advance_to(0.2);
  Simulation after(hanging({"scaled", {{"stiffness", 2.0}}}), host, options());
  after.advance_to(0.2);
  CHECK(after.position(1) == before.position(1));
}

TEST_CASE("what a law of the host throws ends the step with an error that names it") {
  for (const unsigned threads : {1u, 2u}) {
    const auto host = shipped();
    host->add(spring_function(describe("tearing", "fails beyond 1.15 m"), [](const auto& e, const auto&) {
      if (e.q > 1.15) throw std::runtime_error("the tissue is torn");
      return -1.0 * e.q;
    }));
    host->add(neuron(describe("cut", "fails beyond 1.15 m"), [](const auto& n, const auto&) {
      if (n.position.x > 1.15) throw 7;
      return n.force / n.mass;
    }));
    SimulationOptions given = options();
    given.threads = threads;
    Simulation simulation(hanging({"tearing", {}}), host, given);
    std::string text;
    try {
      simulation.advance_to(5.0);
    } catch (const Error& error) {
      text = error.what();
    }
    CHECK(text.find("spring function 'tearing' of plugin host failed: the tissue is torn") != std::string::npos);
    Network net = hanging({"linear", {{"stiffness", 2.0}}});
    Node moving = point({1.1, 1, 0}, 1.0, {1, 0, 0});
    moving.neuron = net.add_neuron({"cut", {}});
    net.add_node(moving);
    Simulation other(net, host, given);
    text.clear();
    try {
      other.advance_to(5.0);
    } catch (const Error& error) {
      text = error.what();
    }
    CHECK(text.find("neuron 'cut' of plugin host failed") != std::string::npos);
  }
}

TEST_CASE("a law cannot step or change the simulation that evaluates it") {
  const std::vector<std::pair<const char*, std::function<void(Simulation&)>>> misdeeds{
      {"step", [](Simulation& own) { own.step(); }},
      {"advance_to", [](Simulation& own) { own.advance_to(9.0); }},
      {"drop_history", [](Simulation& own) { own.drop_history(); }},
      {"set_force",
       [](Simulation& own) {
         own.set_force(1, {0, 0, 1});
       }},
      {"set_velocity",
       [](Simulation& own) {
         own.set_velocity(1, {0, 0, 1});
       }},
      {"cut", [](Simulation& own) { own.cut({0}); }}};
  for (const auto& [name, misdeed] : misdeeds) {
    CAPTURE(name);
    Simulation* running = nullptr;
    const auto host = shipped();
    host->add(spring_function(describe("meddling", "changes what evaluates it"),
                              [&running, &does = misdeed](const auto& e, const auto&) {
                                if (running != nullptr) does(*running);
                                return 3.0 * e.q;
                              }));
    SimulationOptions given = options();
    given.threads = 1;
    Simulation simulation(hanging({"meddling", {}}), host, given);
    simulation.step();
    running = &simulation;
    CHECK_THROWS_WITH(
        simulation.step(),
        doctest::Contains(
            "'meddling' of plugin host failed: a simulation cannot be stepped or changed within its own step"));
    running = nullptr;
    CHECK_NOTHROW(simulation.step());
  }
}

namespace {

// A law as a binding of another language makes it: functions in C with a context, and one that frees the context.
struct ForeignContext {
  double factor;
  int* released;
};

springnet_status evaluate_foreign(void* context, const springnet_law_batch* batch) {
  const double factor = static_cast<const ForeignContext*>(context)->factor;
  for (std::uint32_t i = 0; i < batch->count; ++i) {
    const double k = factor * batch->parameters[0][batch->parameter_strides[0] * i];
    const double x = batch->q[i] - batch->reference[batch->reference_stride * i];
    if (batch->force != nullptr) batch->force[i] = k * x;
    if (batch->force_by_q != nullptr) batch->force_by_q[i] = k;
    if (batch->force_by_rate != nullptr) batch->force_by_rate[i] = 0.0;
  }
  return SPRINGNET_OK;
}

void release_foreign(void* context) {
  const auto* const own = static_cast<ForeignContext*>(context);
  ++*own->released;
  delete own;
}

// Every text and struct is on the heap and gone afterwards.
HostComponent foreign(int& released, const char* parameter_name = "stiffness") {
  std::vector<std::unique_ptr<std::string>> texts;
  const auto text = [&texts](const char* value) {
    texts.push_back(std::make_unique<std::string>(value));
    return texts.back()->c_str();
  };
  springnet_parameter stiffness{};
  stiffness.struct_size = sizeof stiffness;
  stiffness.name = text(parameter_name);
  stiffness.unit = text("N/m");
  stiffness.summary = text("tension per elongation, before the factor");
  stiffness.largest = 1e6;
  stiffness.scale = 1;
  stiffness.flags = SPRINGNET_REQUIRED;
  const auto list = std::make_unique<const springnet_parameter*>(&stiffness);
  springnet_law law{};
  law.struct_size = sizeof law;
  law.invariant = SPRINGNET_LENGTH;
  law.update_order = 1;
  law.largest_stretch = 10;
  law.context = new ForeignContext{4.0, &released};
  law.evaluate = evaluate_foreign;
  springnet_component description{};
  description.struct_size = sizeof description;
  description.kind = SPRINGNET_SPRING_FUNCTION;
  description.id = text("foreign");
  description.summary = text("a law in C");
  description.reference = text("");
  description.capabilities = SPRINGNET_HAS_DERIVATIVES | SPRINGNET_ACTS_IN_COMPRESSION;
  description.parameter_count = 1;
  description.parameters = list.get();
  description.implementation = &law;
  return {description, std::shared_ptr<void>(law.context, release_foreign)};
}

}  // namespace

TEST_CASE("functions in C keep their context until the last use, and release it once") {
  int released = 0;
  {
    std::optional<Simulation> simulation;
    {
      const auto host = shipped();
      host->add(foreign(released));
      simulation.emplace(hanging({"foreign", {{"stiffness", 2.0}}}), host, options());
    }
    simulation->advance_to(0.3);
    CHECK(released == 0);
    const Simulation same = simulate(hanging({"linear", {{"stiffness", 8.0}}}), recurrent(newton, 1e-10), 1e-2);
    CHECK(simulation->tension(0) == doctest::Approx(8.0 * (simulation->position(1).x() - 1.0)).epsilon(1e-12));
  }
  CHECK(released == 1);
  CHECK(message_of([&] { static_cast<void>(foreign(released, "Stiff ness")); }).find("has the name 'Stiff ness'") !=
        std::string::npos);
  CHECK(released == 2);
}
