#include "simulation/limit_survey.hpp"

#include <cmath>
#include <exception>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "plugin_host/call.hpp"
#include "simulation/host_table.hpp"

namespace springnet {
namespace {

// Size of a limit in ABI 2.0; the struct may grow at its end.
constexpr std::size_t limit_size = SPRINGNET_SIZE_TO(springnet_limit, reason);
constexpr std::size_t max_limits = 100, max_name_length = 40, max_reason_length = 500;

struct Sink {
  const std::vector<std::uint32_t>& user;
  std::vector<ReportedLimit> reported;
};

ReportedLimit read(const springnet_limit& limit, const std::vector<std::uint32_t>& user) {
  ReportedLimit result;
  result.rule = limit.rule == nullptr ? "" : printable(limit.rule, max_name_length);
  result.kind = limit.kind;
  if (limit.reason != nullptr) result.reason = printable(limit.reason, max_reason_length);
  if (limit.node < user.size()) result.node = user[limit.node];
  const bool known = limit.kind == SPRINGNET_LIMIT_KNOWN || limit.kind == SPRINGNET_LIMIT_ESTIMATE;
  if (!known && limit.kind != SPRINGNET_LIMIT_NONE) result.kind = SPRINGNET_LIMIT_UNKNOWN;
  if (!known) return result;
  result.time_step = limit.time_step;
  result.weight = limit.weight > 0.0 && std::isfinite(limit.weight) ? limit.weight : limit.time_step;
  if (limit.time_step > 0.0 && std::isfinite(limit.time_step)) return result;
  result = {result.rule,  SPRINGNET_LIMIT_UNKNOWN,
            0.0,          0.0,
            std::nullopt, fmt::format("the integrator reported a limit of {} s", limit.time_step)};
  return result;
}

// Called by the plugin: nothing may be thrown.
springnet_status report_limit(void* context, const springnet_limit* limit) {
  auto& sink = *static_cast<Sink*>(context);
  if (limit == nullptr || limit->struct_size < limit_size || sink.reported.size() >= max_limits)
    return SPRINGNET_FAILED;
  try {
    sink.reported.push_back(read(*limit, sink.user));
    return SPRINGNET_OK;
  } catch (const std::exception&) {
    return SPRINGNET_FAILED;  // out of memory: the limit is not listed
  }
}

// While this exists, the integrator must not change the network.
class ReportingLimits {
 public:
  explicit ReportingLimits(IntegratorCalls& calls) : calls_(calls) { calls_.set_reporting_limits(true); }
  ~ReportingLimits() { calls_.set_reporting_limits(false); }
  ReportingLimits(const ReportingLimits&) = delete;
  ReportingLimits& operator=(const ReportingLimits&) = delete;

 private:
  IntegratorCalls& calls_;
};

void destroy(const springnet_integrator& functions, void* integrator) noexcept {
  if (integrator == nullptr) return;
  try {
    static_cast<void>(functions.destroy(integrator));
  } catch (...) {
    // plugin.h forbids exceptions; the limits are known already.
  }
}

}  // namespace

LimitSurvey::LimitSurvey(const Network& network, const PluginHost& plugins, const SimulationOptions& options)
    : engine_(network, plugins, options), table_(make_host_table(engine_)) {}

std::vector<ReportedLimit> LimitSurvey::ask(const Component& component, const ParameterValues& parameters) {
  const springnet_integrator& functions = component.integrator();
  if (functions.limits == nullptr) return {};
  Sink sink{engine_.model().layout.ordering().user, {}};
  springnet_limits limits{sizeof limits, 0, &sink, report_limit};
  void* integrator = nullptr;
  const auto failed = [&](const std::string& reason) {
    return std::vector<ReportedLimit>{{"", SPRINGNET_LIMIT_UNKNOWN, 0.0, 0.0, std::nullopt, reason}};
  };
  springnet_message message{};
  springnet_status status = SPRINGNET_FAILED;
  try {
    const std::vector<double> values = complete_parameters(*component.description, parameters, full_name(component));
    const double now = engine_.model().time;
    engine_.calls().begin_advance(now);
    // For the present loads; the length of the interval does not matter.
    status = engine_.begin_interval(now, now + 1.0, false);
    if (status != SPRINGNET_OK) return failed(text_of(engine_.model().journal.message));
    const ReportingLimits guard(engine_.calls());
    status = call_component(component, message, [&](springnet_message& own) {
      engine_.model().journal.message.text[0] = '\0';
      springnet_integrator_creation creation{sizeof creation, static_cast<std::uint32_t>(values.size()), &table_,
                                             values.data(), nullptr};
      springnet_status result = functions.create(functions.context, &creation);
      integrator = creation.integrator;
      if (result == SPRINGNET_OK) result = functions.limits(integrator, &limits);
      if (result != SPRINGNET_OK) own = engine_.model().journal.message;
      return result;
    });
    destroy(functions, integrator);
  } catch (const Error& error) {
    return failed(error.what());
  }
  return status == SPRINGNET_OK ? sink.reported : failed(text_of(message));
}

}  // namespace springnet
