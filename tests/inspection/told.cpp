// What inspect makes of what integrators tell: of the installed ones, and of some that tell nonsense.
#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <springnet/inspection.hpp>
#include <springnet/sdk/host.hpp>

#include "nets.hpp"

using namespace springnet;
using Kind = TimeConstantLimit::Kind;

namespace {

const springnet_host* host_of_instance = nullptr;
std::function<springnet_status(const springnet_limits&)> told;

springnet_status create(void*, springnet_integrator_creation* creation) {
  host_of_instance = creation->host;
  creation->integrator = &host_of_instance;
  return SPRINGNET_OK;
}
springnet_status destroy(void*) { return SPRINGNET_OK; }
springnet_status advance(void*, const springnet_advance*) { return SPRINGNET_FAILED; }
springnet_status limits(void*, const springnet_limits* sink) { return told(*sink); }

constexpr springnet_integrator functions{sizeof(springnet_integrator),
                                         0,
                                         nullptr,
                                         create,
                                         destroy,
                                         advance,
                                         limits,
                                         nullptr,
                                         nullptr,
                                         nullptr,
                                         nullptr,
                                         nullptr,
                                         nullptr};
constexpr springnet_integrator functions_without{sizeof(springnet_integrator),
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
constexpr springnet_component teller{
    sizeof(springnet_component), SPRINGNET_INTEGRATOR, "teller", "", "", 0, 0, 0, 0, nullptr, &functions};
constexpr springnet_component silent{
    sizeof(springnet_component), SPRINGNET_INTEGRATOR, "silent", "", "", 0, 0, 0, 0, nullptr, &functions_without};
constexpr const springnet_component* components[] = {&teller, &silent};
constexpr springnet_plugin plugin{SPRINGNET_MAGIC,
                                  sizeof(springnet_plugin),
                                  SPRINGNET_ABI_MAJOR,
                                  SPRINGNET_ABI_MINOR,
                                  0,
                                  2,
                                  0,
                                  "test.teller",
                                  "1",
                                  "tests",
                                  "MIT",
                                  components};

Network pair() {
  Network net = testing::chain(2, Vector3::Zero(), Vector3::UnitX(), testing::damped(8.0, 0.4), 2.0);
  net.fix(0);
  return net;
}

Inspection inspect_with(std::function<springnet_status(const springnet_limits&)> tell, const Network& net = pair()) {
  told = std::move(tell);
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  REQUIRE(host->add(plugin));
  return inspect(net, *host);
}

springnet_limit limit(std::uint32_t kind, const char* rule, double time_step) {
  auto result = sdk::sized<springnet_limit>();
  result.kind = kind;
  result.rule = rule;
  result.time_step = time_step;
  result.node = 0xffffffffu;
  return result;
}

}  // namespace

TEST_CASE("every installed integrator tells its limit, the scene's first") {
  InspectionOptions options;
  options.integrator = {"verlet", {{"substeps", 4}}};
  const Inspection found = inspect(pair(), *testing::plugins(), options);
  CHECK(found.limits.front().integrator == "verlet");
  // h^2 k / (4 m) + h d / m = 1 with k / m = 4, d / m = 0.2.
  const double h = (std::sqrt(0.2 * 0.2 + 4.0) - 0.2) / 2.0;
  CHECK(found.limit("verlet").time_constant == doctest::Approx(4.0 * h).epsilon(2e-3));
  CHECK(found.limit("verlet").set_by->node == 1);
  CHECK(found.limit("verlet").set_by->elastic_share + found.limit("verlet").set_by->viscous_share ==
        doctest::Approx(1.0 - 0.5 * h * 0.2).epsilon(5e-3));
  CHECK(found.limit("cvode").kind == Kind::none);
  CHECK(found.limit("generalized_alpha").kind == Kind::none);
  CHECK_FALSE(found.limit("cvode").reason.empty());
  CHECK(found.limit("synchronous").integrator == "recurrent");
  CHECK(found.limit("synchronous").time_constant ==
        doctest::Approx((std::sqrt(0.04 + 16.0) - 0.2) / 8.0).epsilon(2e-3));
  CHECK_THROWS_WITH(static_cast<void>(found.limit("euler")), doctest::Contains("'euler'"));
  // The same order every time, and the recurrent network's rules first by default.
  CHECK(inspect(pair(), *testing::plugins()).limits.front().name() == "synchronous");
}

TEST_CASE("an integrator without limits() tells nothing, one that tells is in the JSON, under its own name if needed") {
  const Inspection found = inspect_with([](const springnet_limits& sink) -> springnet_status {
    springnet_limit one = limit(SPRINGNET_LIMIT_KNOWN, "wavefront", 0.25);
    one.weight = 0.5;
    one.node = 1;
    sink.tell(sink.context, &one);
    springnet_limit other = limit(SPRINGNET_LIMIT_NONE, "leaping", 0.0);
    other.reason = "it leaps";
    sink.tell(sink.context, &other);
    return SPRINGNET_OK;
  });
  for (const TimeConstantLimit& each : found.limits) CHECK(each.integrator != "silent");
  const auto json = nlohmann::json::parse(to_json(found))["time_constants"];
  CHECK(json["teller.wavefront"]["time_constant_s"] == 0.25);
  CHECK(json["teller.wavefront"]["set_by"]["elastic_share"] == doctest::Approx(0.5 * 0.5 * 8.0 / 2.0));
  CHECK(json["leaping"]["limit"] == "none");
  CHECK(json["wavefront"]["time_constant_s"] != 0.25);
  CHECK(found.limit("leaping").reason == "it leaps");
}

TEST_CASE("nonsense that an integrator tells, or does, is a limit that is unknown") {
  const auto unknown = [](std::function<springnet_status(const springnet_limits&)> tell) {
    const Inspection found = inspect_with(std::move(tell));
    const TimeConstantLimit& result = found.limit("teller");
    CHECK(result.kind == Kind::unknown);
    CHECK(found.limit("synchronous").kind == Kind::known);
    return result.reason;
  };
  for (const double nonsense : {0.0, -1.0, std::nan(""), double{INFINITY}}) {
    const std::string reason = unknown([=](const springnet_limits& sink) -> springnet_status {
      const springnet_limit one = limit(SPRINGNET_LIMIT_KNOWN, nullptr, nonsense);
      sink.tell(sink.context, &one);
      sink.tell(sink.context, nullptr);
      return SPRINGNET_OK;
    });
    CHECK(reason.find("reported a limit of") != std::string::npos);
  }
  CHECK_FALSE(unknown([](const springnet_limits&) -> springnet_status { return SPRINGNET_FAILED; }).empty());
  CHECK(unknown([](const springnet_limits&) -> springnet_status {
          throw std::runtime_error("out of luck");
        }).find("out of luck") != std::string::npos);
  // Neither may it change the network that others are asked about.
  const std::string refused = unknown([](const springnet_limits&) -> springnet_status {
    auto creation = sdk::sized<springnet_state_creation>();
    host_of_instance->create_state(host_of_instance->context, &creation);
    auto commitment = sdk::sized<springnet_commitment>();
    commitment.state = creation.state;
    return host_of_instance->commit(host_of_instance->context, &commitment);
  });
  CHECK(refused.find("springnet_host::commit") != std::string::npos);
  const Inspection many = inspect_with([](const springnet_limits& sink) -> springnet_status {
    for (int i = 0; i < 1000; ++i) {
      const std::string rule = "rule_" + std::to_string(i);
      const springnet_limit one = limit(17, rule.c_str(), 1.0);
      sink.tell(sink.context, &one);
    }
    return SPRINGNET_OK;
  });
  CHECK(many.limits.size() < 200);
}
