// Integrators that commit invalid states, or call the host's functions with arbitrary arguments: an error that names
// them, never a crash, a hang or a state that is not finite.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "child.hpp"
#include "hosts.hpp"
#include "misdeeds.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// When the present case misbehaves.
enum class When { at_once, in_the_second_step, and_then_commits, on_creation };
constexpr const char* when_names[] = {"at once", "in the second step", "and then commits", "on creation"};

const Misdeed* misdeed = nullptr;
When when = When::at_once;
bool step_follows = false;
int advances = 0;

struct Instance {
  const springnet_host* host;
};

springnet_status step(const springnet_host* host, double until, springnet_step_report* report, bool misbehave) {
  StepContext h{host, host->context, 0.0, until, nullptr, report};
  const springnet_state* now = h.committed(&h.from);
  const double from = h.from;
  if (const springnet_status begun = h.begin(from, until); begun != SPRINGNET_OK) return begun;
  springnet_state* next = h.state = h.create_state();
  for (std::uint32_t k = 0; k < h.nodes(); ++k) {
    const auto move = [&](const double* p, const double* v, double* to_p, double* to_v) {
      to_p[k] = p[k] + 1e-3 * (until - from) * v[k];
      to_v[k] = v[k];
    };
    move(now->position.x, now->velocity.x, next->position.x, next->velocity.x);
    move(now->position.y, now->velocity.y, next->position.y, next->velocity.y);
    move(now->position.z, now->velocity.z, next->position.z, next->velocity.z);
  }
  springnet_status status = SPRINGNET_OK;
  if (misbehave) {
    status = (*misdeed)(h);
    // Where the host let it through, a step without fault follows: the case has to be refused for itself.
    if (when != When::and_then_commits && (status != SPRINGNET_OK || !step_follows)) return status;
    double committed = 0.0;
    h.committed(&committed);
    if (committed >= until) return SPRINGNET_OK;  // the host took a time that it must not take
    return step(host, until, report, false);
  }
  status = h.commit(until, next);
  h.destroy_state(next);
  report->outcome = SPRINGNET_SETTLED;
  report->steps = report->sweeps = 1;
  return status;
}

springnet_status create(void*, springnet_integrator_creation* creation) {
  creation->integrator = new Instance{creation->host};
  if (when != When::on_creation) return SPRINGNET_OK;
  auto report = sdk::sized<springnet_step_report>();
  return step(creation->host, 0.05, &report, true);
}
springnet_status destroy(void* integrator) {
  delete static_cast<Instance*>(integrator);
  return SPRINGNET_OK;
}
springnet_status advance(void* integrator, const springnet_advance* request) {
  const bool misbehave = when == When::in_the_second_step ? ++advances == 2 : true;
  return step(static_cast<Instance*>(integrator)->host, request->until, request->report, misbehave);
}

constexpr springnet_integrator implementation{sizeof(springnet_integrator),
                                              0,
                                              nullptr,
                                              create,
                                              destroy,
                                              advance,
                                              nullptr,
                                              nullptr,
                                              nullptr,
                                              nullptr,
                                              nullptr,
                                              nullptr,
                                              nullptr};
constexpr springnet_component component{
    sizeof(springnet_component), SPRINGNET_INTEGRATOR, "hostile", "", "", 0, 0, 0, 0, nullptr, &implementation};
constexpr const springnet_component* components[] = {&component};
constexpr springnet_plugin plugin{SPRINGNET_MAGIC,
                                  sizeof(springnet_plugin),
                                  SPRINGNET_ABI_MAJOR,
                                  SPRINGNET_ABI_MINOR,
                                  0,
                                  1,
                                  0,
                                  "test.hostile",
                                  "1",
                                  "tests",
                                  "MIT",
                                  components};

std::string run(const Case& each, When time, unsigned threads) {
  misdeed = &each.misdeed;
  when = time;
  step_follows = each.refused && !each.incomplete;
  return in_child([&]() -> std::string {
    SimulationOptions options;
    options.time_step = 0.05;
    options.threads = threads;
    options.renumber = false;
    options.integrator = {"hostile", {}};
    Expectation expected;
    expected.fails = each.refused && when != When::and_then_commits && when != When::on_creation;
    if (expected.fails) expected.kind = ErrorKind::plugin;
    if (expected.fails) expected.names = "integrator 'hostile' of plugin test.hostile";
    return run_with(plugin, row(damped(1.0, 0.1), {}, threads > 1), options, expected);
  });
}

}  // namespace

TEST_CASE("misbehaving integrators end in an error that names them, without other effects") {
  static_cast<void>(plugins());  // their libraries are open before the children are made
  std::size_t number = 0, tried = 0;
  const std::vector<Case> cases = all_cases();
  for (const Case& each : cases) {
    for (const When time : {When::at_once, When::in_the_second_step, When::and_then_commits, When::on_creation}) {
      for (const unsigned threads : {1u, 2u}) {
        // All of them once; the rest of the combinations in the suite now and then.
        if ((time != When::at_once || threads > 1) && !is_chosen(number++)) continue;
        ++tried;
        const std::string text = run(each, time, threads);
        INFO(std::string(each.name), " ", std::string(when_names[static_cast<int>(time)]), ", threads: ", threads);
        CHECK(text == "");
      }
    }
  }
  MESSAGE(tried, " hostile integrators");
}
