// Laws and neurons that answer nonsense, fail without a word or throw, at their first call or later, in one thread or
// two, under every integrator: an error that names the component, never a crash.
#include <atomic>
#include <limits>
#include <stdexcept>

#include <doctest/doctest.h>

#include "child.hpp"
#include "hosts.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

enum class Deed {
  fine,
  not_a_number,
  infinite,
  fails_silently,
  fails_with_text,
  fails_without_end,
  fails_rudely,
  throws,
  throws_silently,
  throws_a_number,
  unknown_status,
  negative_status,
  recoverable,
  count
};
constexpr const char* deed_names[] = {
    "fine",         "nan",    "infinity",       "fails silently",  "fails",     "fails, text without an end",
    "fails rudely", "throws", "throws nothing", "throws a number", "status 77", "status -1",
    "recoverable"};

// What is spoilt where the answer is nonsense.
enum class Output { value, energy, derivative, margin, count };
constexpr const char* output_names[] = {"value", "energy", "derivative", "margin"};

Deed deed = Deed::fine;
Output output = Output::value;
int first_bad_call = 0;
std::atomic<int> calls{0};

// Whether this call is to misbehave, and with which status; throws if it is to throw.
bool misbehaves(springnet_message* message, springnet_status& status) {
  status = SPRINGNET_OK;
  if (deed == Deed::fine || calls++ < first_bad_call) return false;
  switch (deed) {
    case Deed::fails_silently:
      status = SPRINGNET_FAILED;
      break;
    case Deed::fails_with_text:
      status = SPRINGNET_FAILED;
      if (message != nullptr) std::copy_n("the tissue is torn", 19, message->text);
      break;
    case Deed::fails_without_end:
      status = SPRINGNET_FAILED;
      if (message != nullptr) std::fill_n(message->text, sizeof message->text, 'a');
      break;
    case Deed::fails_rudely:
      status = SPRINGNET_FAILED;
      if (message != nullptr) std::copy_n("\x1b[2J\xff\xfe\x07", 8, message->text);
      break;
    case Deed::throws:
      throw std::runtime_error("\x1b]0;thrown\x07 by a law");
    case Deed::throws_silently:
      throw std::runtime_error("");
    case Deed::throws_a_number:
      throw 7;
    case Deed::unknown_status:
      status = 77;
      break;
    case Deed::negative_status:
      status = -1;
      break;
    case Deed::recoverable:
      status = SPRINGNET_RECOVERABLE;
      break;
    default:
      break;
  }
  return true;
}

double nonsense() {
  return deed == Deed::not_a_number ? std::numeric_limits<double>::quiet_NaN()
                                    : std::numeric_limits<double>::infinity();
}

springnet_status evaluate_law(void*, const springnet_law_batch* batch) {
  springnet_status status;
  const bool bad = misbehaves(batch->message, status);
  for (std::uint32_t i = 0; i < batch->count; ++i) {
    if (batch->force != nullptr) batch->force[i] = batch->q[i] - 1.0;
    if (batch->energy != nullptr) batch->energy[i] = 0.5 * (batch->q[i] - 1.0) * (batch->q[i] - 1.0);
    if (batch->force_by_q != nullptr) batch->force_by_q[i] = 1.0;
    if (batch->force_by_rate != nullptr) batch->force_by_rate[i] = 0.0;
    if (batch->margin != nullptr) batch->margin[i] = 1.0;
    if (!bad || (deed != Deed::not_a_number && deed != Deed::infinite)) continue;
    double* const spoilt[] = {batch->force, batch->energy, batch->force_by_q, batch->margin};
    if (double* const values = spoilt[static_cast<int>(output)]) values[i] = nonsense();
  }
  return status;
}

springnet_status evaluate_neuron(void*, const springnet_neuron_batch* batch) {
  springnet_status status;
  const bool bad = misbehaves(batch->message, status);
  for (std::uint32_t i = 0; i < batch->count; ++i) {
    batch->acceleration.x[i] = batch->force.x[i] / batch->mass[i];
    batch->acceleration.y[i] = batch->force.y[i] / batch->mass[i];
    batch->acceleration.z[i] = batch->force.z[i] / batch->mass[i];
    for (std::uint32_t e = 0; e < 9; ++e) {
      if (batch->acceleration_by_force != nullptr)
        batch->acceleration_by_force[9 * i + e] = e % 4 == 0 ? 1.0 / batch->mass[i] : 0.0;
      if (batch->acceleration_by_position != nullptr) batch->acceleration_by_position[9 * i + e] = 0.0;
      if (batch->acceleration_by_velocity != nullptr) batch->acceleration_by_velocity[9 * i + e] = 0.0;
    }
    if (!bad || (deed != Deed::not_a_number && deed != Deed::infinite)) continue;
    if (output == Output::value) batch->acceleration.y[i] = nonsense();
    if (output == Output::derivative && batch->acceleration_by_force != nullptr)
      batch->acceleration_by_force[9 * i + 4] = nonsense();
  }
  return status;
}

constexpr std::uint64_t can =
    SPRINGNET_HAS_ENERGY | SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_RUPTURE | SPRINGNET_ACTS_IN_COMPRESSION;
constexpr springnet_law law = [] {
  springnet_law result{};
  result.struct_size = sizeof result;
  result.invariant = SPRINGNET_LENGTH;
  result.update_order = 1;
  result.largest_stretch = std::numeric_limits<double>::infinity();
  result.evaluate = evaluate_law;
  return result;
}();
constexpr springnet_neuron_model neuron{sizeof(springnet_neuron_model), 0, nullptr, evaluate_neuron};
constexpr springnet_component spring_function{
    sizeof(springnet_component), SPRINGNET_SPRING_FUNCTION, "hostile", "", "", can, 0, 0, 0, nullptr, &law};
constexpr springnet_component viscosity_function{
    sizeof(springnet_component), SPRINGNET_VISCOSITY_FUNCTION, "hostile", "", "", can, 0, 0, 0, nullptr, &law};
constexpr springnet_component neuron_component{sizeof(springnet_component),
                                               SPRINGNET_NEURON,
                                               "hostile",
                                               "",
                                               "",
                                               SPRINGNET_HAS_DERIVATIVES,
                                               0,
                                               0,
                                               0,
                                               nullptr,
                                               &neuron};
constexpr const springnet_component* law_components[] = {&spring_function, &viscosity_function, &neuron_component};
constexpr springnet_plugin law_plugin{SPRINGNET_MAGIC,
                                      sizeof(springnet_plugin),
                                      SPRINGNET_ABI_MAJOR,
                                      SPRINGNET_ABI_MINOR,
                                      0,
                                      3,
                                      0,
                                      "test.hostile",
                                      "1",
                                      "tests",
                                      "MIT",
                                      law_components};

struct Way {
  const char* name;
  LawUse integrator;
  bool large;  // fast enough for a large network
};

std::vector<Way> ways() {
  return {{"single sweep", single_sweep(), true},
          {"synchronous", recurrent(synchronous, 1e-9), true},
          {"wavefront", recurrent(wavefront, 1e-9), false},
          {"block", recurrent(block, 1e-9), false},
          {"coloured", recurrent(coloured, 1e-9), true},
          {"newton", recurrent(newton, 1e-9), false},
          {"accepting", recurrent(wavefront, 1e-9, {{"unsettled", on_unsettled_accept}}), false},
          {"adapting", recurrent(wavefront, 1e-9, {{"unsettled", on_unsettled_adapt}}), false},
          {"verlet", LawUse{"verlet", {}}, true},
          {"cvode", cvode(1e-6), false}};
}

// An answer that every step needs.
bool has_to_fail(Deed what) { return what != Deed::fine && what != Deed::recoverable; }

}  // namespace

TEST_CASE("misbehaving laws and neurons end in an error that names them, without other effects") {
  static_cast<void>(plugins());  // their libraries are open before the children are made
  std::size_t number = 0, run = 0;
  for (const Way& way : ways())
    for (const bool large : {false, true})
      for (const char* role : {"spring", "viscosity", "neuron"})
        for (int d = 1; d < static_cast<int>(Deed::count); ++d)
          for (int o = 0; o < static_cast<int>(Output::count); ++o)
            for (const int call : {0, 3, 40}) {
              deed = static_cast<Deed>(d);
              output = static_cast<Output>(o);
              first_bad_call = call;
              const bool nonsense_only = deed == Deed::not_a_number || deed == Deed::infinite;
              if (!nonsense_only && output != Output::value) continue;
              const bool is_neuron = std::string_view(role) == "neuron";
              if (is_neuron && (output == Output::energy || output == Output::margin)) continue;
              if (large && !way.large) continue;
              // One update rule sees every deed, in one thread and in two, in the suite too.
              const bool always = std::string_view(way.name) == "synchronous" && call == 0 && output == Output::value;
              // Methods that need derivatives, or ask whether a step is stable.
              const std::string_view method = way.name;
              const bool needs =
                  method == "newton" || method == "verlet" || method == "cvode" || (method == "block" && !is_neuron);
              const bool misleads = needs && nonsense_only && output == Output::derivative && call == 0 && !large;
              if (!is_chosen(number++) && !always && !misleads) continue;
              ++run;
              const std::string text = in_child([&]() -> std::string {
                calls = 0;
                Material material = damped(1.0, 0.1);
                if (std::string_view(role) == "spring") material.spring = LawUse{"hostile", {}};
                if (std::string_view(role) == "viscosity") material.viscosity = LawUse{"hostile", {}};
                SimulationOptions options;
                options.time_step = 0.05;
                options.integrator = way.integrator;
                options.threads = large ? 2 : 1;
                Expectation expected;
                expected.fails = misleads || (call == 0 && output == Output::value && has_to_fail(deed));
                // One that is fine again when it is asked why is past finding out.
                expected.names = call == 0 && output == Output::value ? "'hostile'" : "";
                if (misleads)
                  expected.names = fmt::format("'hostile' of plugin test.hostile answered a derivative {}",
                                               is_neuron                    ? "that is not finite for node"
                                               : deed == Deed::not_a_number ? "of nan for spring"
                                                                            : "of inf for spring");
                return run_with(law_plugin, row(material, is_neuron ? LawUse{"hostile", {}} : LawUse{}, large), options,
                                expected);
              });
              const std::string what =
                  fmt::format("{}{}, {}, {} of the {} from call {}", way.name, large ? ", two threads" : "", role,
                              deed_names[d], output_names[o], call);
              INFO(what);
              CHECK(text == "");
            }
  MESSAGE(run, " hostile laws and neurons");
}
