// The recurrent network as integrator. In a time step of t_c the activities p, v are frozen; outputs P, U start from
// them and are propagated sweep by sweep,
//
//   a  = A(F(P, U, t + t_c), P, U)        springs, loads and neurons, by the host
//   U' = v + t_c a
//   P' = p + t_c U'
//
// until the forces stop changing; then the outputs become the activities. The fixed point is the backward Euler step,
// a single synchronous sweep is the symplectic Euler step. The paper: Nürnberger, Radetzky, Kruse, "A Problem Specific
// Recurrent Neural Network for the Description and Simulation of Dynamic Spring Models", section 3.4.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <springnet/sdk/integrator.hpp>

#include "monitor.hpp"
#include "node_update.hpp"
#include "wavefront.hpp"

namespace {

using namespace springnet::recurrent;
using springnet::sdk::choice;
using springnet::sdk::evaluation_at;
using springnet::sdk::Failure;
using springnet::sdk::Host;
using springnet::sdk::integer;
using springnet::sdk::number;
using springnet::sdk::Options;
using springnet::sdk::Parameter;
using springnet::sdk::sized;
using springnet::sdk::State;
using springnet::sdk::view;

constexpr double automatic_tolerance = 1e-6;  // of the network's force scale

class Recurrent : public springnet::sdk::Integrator {
 public:
  static constexpr const char* id = "recurrent";
  static constexpr const char* summary = "the recurrent network: sweeps until the forces settle (backward Euler)";
  static constexpr const char* reference =
      "Nürnberger, Radetzky, Kruse: A Problem Specific Recurrent Neural Network for the Description and Simulation of "
      "Dynamic Spring Models, section 3.4";
  static constexpr Parameter parameters[] = {
      choice("update", {"synchronous", "wavefront"},
             "all nodes at once, or one after another from the node with the greatest force")
          .preset(1),
      number("force_tolerance", "N",
             "a step has settled when no force changes by more; 0: 1e-6 of the network's force scale")
          .preset(0)
          .at_least(0),
      integer("max_sweeps", "sweeps in a time step at most").preset(1000).at_least(2).at_most(1e9),
      integer("sweeps", "exactly so many sweeps a step; 0: until settled; 1 with update synchronous: symplectic Euler")
          .preset(0)
          .at_least(0)
          .at_most(1e9),
      choice("unsettled", {"error", "accept"}, "what follows when a step does not settle")};

  Recurrent(Host host, Options options)
      : host_(host),
        wavefront_(options.choice<int>("update") == 1),
        tolerance_(options["force_tolerance"]),
        max_sweeps_(options.integer<std::uint64_t>("max_sweeps")),
        exact_sweeps_(options.integer<std::uint64_t>("sweeps")),
        accept_(options.choice<int>("unsettled") == 1),
        states_{host.make_state(), host.make_state()} {}

  springnet_status advance(double until, springnet_step_report& report);

 private:
  // One time step: what it starts from and how far it has come.
  struct Step {
    double until;          // s
    double time_constant;  // s
    double tolerance;      // N
    const springnet_state& start;
    const springnet_network& network;
    const springnet_state* outputs;  // of the last sweep, in states_[written]
    std::size_t written = 0;
    ForceRecord::Differences differences{};
    std::uint64_t sweeps = 0;
    std::uint32_t start_node = no_node;
    bool finite = true;
    double residual = std::numeric_limits<double>::quiet_NaN();
  };

  // Exactly so many sweeps as were asked for settle a step by definition.
  [[nodiscard]] static bool settled(Verdict verdict) noexcept {
    return verdict == Verdict::settled || verdict == Verdict::go_on;
  }
  void prepare(const springnet_network& network);
  // The sweeps of a step; Verdict::go_on where so many sweeps were asked for and done.
  Verdict propagate(Step& step);
  void begin_wavefront(Step& step);
  void sweep_synchronous(Step& step);
  void sweep_wavefront(Step& step);
  // From the outputs `read` to step.outputs; compares forces with those of the sweep before where asked.
  void sweep(Step& step, const springnet_state& read, std::span<const std::uint32_t> order, bool compare);
  // Forces at the new outputs, internal state of laws, residual.
  void complete(Step& step);
  [[nodiscard]] double residual(const Step& step) const;
  [[nodiscard]] static std::uint32_t non_finite_node(const Step& step);
  [[nodiscard]] std::string explain(const Step& step, Verdict verdict, const std::string& law_message) const;

  Host host_;
  bool wavefront_;
  double tolerance_;  // N, 0: automatic
  std::uint64_t max_sweeps_;
  std::uint64_t exact_sweeps_;  // 0: until settled
  bool accept_;

  std::array<State, 2> states_;
  ForceRecord record_;
  Wavefront order_;
  std::optional<std::uint64_t> revision_;  // of the network that the buffers fit
  std::vector<double> acceleration_[3];    // [node_count] m/s^2
  std::vector<double> internal_rate_;      // [internal_count]
  double evaluations_ = 0.0;               // besides the sweeps
  double accepted_ = 0.0;                  // steps that had not settled
};

springnet_status Recurrent::advance(double until, springnet_step_report& report) {
  const auto [from, start] = host_.committed();
  if (!(until > from)) {
    throw Failure("a time step has to end after " + std::to_string(from) + " s, where the network stands");
  }
  host_.begin_step(from, until);
  const springnet_network& network = host_.network();
  prepare(network);
  const double tolerance = tolerance_ > 0.0 ? tolerance_ : automatic_tolerance * network.force_scale;
  Step step{until, until - from, tolerance, start, network, nullptr};

  Verdict verdict = Verdict::diverging;
  std::string law_message;
  try {
    verdict = propagate(step);
    const bool single_sweep = exact_sweeps_ == 1 && !wavefront_ && network.internal_count == 0;
    if (step.finite && (settled(verdict) || accept_) && !single_sweep) complete(step);
  } catch (const Failure& failure) {
    if (!failure.recoverable()) throw;
    step.finite = false;  // some law or neuron has no finite answer where the outputs went
    law_message = failure.what();
  }
  if (!step.finite) {
    verdict = Verdict::diverging;
    if (law_message.empty()) step.differences.node = non_finite_node(step);
  }

  report.outcome = static_cast<std::int32_t>(settled(verdict) ? Verdict::settled : verdict);
  report.steps = 1;
  report.sweeps = step.sweeps;
  const bool compared = wavefront_ || exact_sweeps_ != 1;
  report.force_difference = compared ? step.differences.greatest : std::numeric_limits<double>::quiet_NaN();
  report.residual = step.residual;
  report.node = step.differences.node == no_node ? 0 : step.differences.node;
  report.start_node = step.start_node;
  if (!settled(verdict) && (!accept_ || !step.finite)) {
    throw Failure(explain(step, verdict, law_message), SPRINGNET_UNSETTLED);
  }
  springnet_state& result = *states_[step.written];
  result.force_is_current = std::isfinite(step.residual) ? 1 : 0;  // complete() evaluated it
  host_.commit(until, result);
  if (!settled(verdict)) host_.report("unsettled_steps", ++accepted_);
  return SPRINGNET_OK;
}

void Recurrent::prepare(const springnet_network& network) {
  if (revision_ == network.revision) return;
  record_.resize(network);
  internal_rate_.resize(network.internal_count);
  for (auto& component : acceleration_) component.resize(network.node_count);
  if (wavefront_) order_.attach(network);
  revision_ = network.revision;
}

Verdict Recurrent::propagate(Step& step) {
  if (wavefront_) {
    begin_wavefront(step);
  } else if (exact_sweeps_ != 1) {
    record_.begin();
  }
  Monitor monitor(step.tolerance, max_sweeps_);
  Verdict verdict = Verdict::go_on;
  while (verdict == Verdict::go_on) {
    if (exact_sweeps_ > 0 && step.sweeps == exact_sweeps_) break;
    if (wavefront_) {
      sweep_wavefront(step);
    } else {
      sweep_synchronous(step);
    }
    step.finite = record_.finite() && std::isfinite(step.differences.greatest);
    if (!step.finite) return Verdict::diverging;
    if (exact_sweeps_ == 0) verdict = monitor.judge(step.differences.greatest);
  }
  return verdict;
}

void Recurrent::sweep_synchronous(Step& step) {
  const springnet_state& read = step.outputs == nullptr ? step.start : *step.outputs;
  step.written = step.sweeps % 2;
  const springnet_state& write = *states_[step.written];
  ++step.sweeps;
  step.outputs = &write;
  sweep(step, read, {}, exact_sweeps_ != 1);
}

// "During the first propagation, the node with the greatest force vector is identified": the springs are evaluated at
// the frozen activities, with the loads of the new step, so that a load which moved takes the start node with it.
void Recurrent::begin_wavefront(Step& step) {
  const springnet_state& outputs = *states_[0];
  const std::uint32_t count = step.network.node_count;
  const auto copy = [count](const springnet_vectors& from, const springnet_vectors& to) {
    std::copy_n(from.x, count, to.x);
    std::copy_n(from.y, count, to.y);
    std::copy_n(from.z, count, to.z);
  };
  copy(step.start.position, outputs.position);
  copy(step.start.velocity, outputs.velocity);
  springnet_evaluation evaluation = evaluation_at(step.until, step.start);
  evaluation.force = outputs.force;
  evaluation.acceleration = {acceleration_[0].data(), acceleration_[1].data(), acceleration_[2].data()};
  host_.evaluate(evaluation);
  ++evaluations_;
  record_.begin(step.network, view(outputs.force), view(evaluation.acceleration));
  step.start_node = order_.strongest(step.network, view(outputs.force));
}

void Recurrent::sweep_wavefront(Step& step) {
  const springnet_state& outputs = *states_[0];
  if (step.differences.free_node != no_node) step.start_node = step.differences.free_node;
  const auto order = order_.order(step.network, step.start_node, view(outputs.force));
  ++step.sweeps;
  step.outputs = &outputs;
  sweep(step, outputs, order, true);
}

void Recurrent::sweep(Step& step, const springnet_state& read, std::span<const std::uint32_t> order, bool compare) {
  const springnet_state& write = *step.outputs;
  auto call = sized<springnet_sweep>();
  call.order = order.empty() ? nullptr : order.data();
  call.order_count = static_cast<std::uint32_t>(order.size());
  call.time = step.until;
  call.start_position = view(step.start.position);
  call.start_velocity = view(step.start.velocity);
  call.position = view(read.position);
  call.velocity = view(read.velocity);
  call.next_position = write.position;
  call.next_velocity = write.velocity;
  call.force = write.force;
  const NodeUpdate update(step.time_constant, step.start, write);
  record_.begin_sweep();
  host_.sweep(call, [&](const springnet_node_batch& batch) {
    record_.take_finite(batch, update(batch));
    if (compare) record_.take(step.network, batch);
  });
  if (compare) step.differences = record_.differences(step.network);
}

void Recurrent::complete(Step& step) {
  const springnet_state& outputs = *step.outputs;
  // Laws with memory: z is frozen during the propagation like any activity, then Z = z + t_c r.
  for (std::uint64_t i = 0; i < step.network.internal_count; ++i) outputs.internal[i] = step.start.internal[i];
  springnet_evaluation evaluation = evaluation_at(step.until, outputs);
  evaluation.force = outputs.force;
  evaluation.acceleration = {acceleration_[0].data(), acceleration_[1].data(), acceleration_[2].data()};
  evaluation.internal_rate = step.network.internal_count > 0 ? internal_rate_.data() : nullptr;
  host_.evaluate(evaluation);
  ++evaluations_;
  for (std::uint64_t i = 0; i < step.network.internal_count; ++i) {
    outputs.internal[i] += step.time_constant * internal_rate_[i];
  }
  host_.report("evaluations", evaluations_);
  step.residual = residual(step);
  step.finite = std::isfinite(step.residual);
}

// max_k m_k |(U_k - v_k) / t_c - a_k| over the nodes that moved freely: how far the outputs are from the equation of
// motion of the backward Euler step. A node that a surface stopped is none of them: it is not where its velocity would
// have taken it, or, if it started on the surface, has no velocity.
double Recurrent::residual(const Step& step) const {
  const springnet_vectors &p = step.start.position, &v = step.start.velocity;
  const springnet_vectors &next = step.outputs->position, &u = step.outputs->velocity;
  const double t_c = step.time_constant;
  const auto stopped = [&](std::uint32_t k) {
    const bool resting = u.x[k] == 0.0 && u.y[k] == 0.0 && u.z[k] == 0.0;
    return resting || next.x[k] != p.x[k] + t_c * u.x[k] || next.y[k] != p.y[k] + t_c * u.y[k] ||
           next.z[k] != p.z[k] + t_c * u.z[k];
  };
  Greatest greatest;
  for (std::uint32_t k = 0; k < step.network.node_count; ++k) {
    if (step.network.fixed[k] != 0) continue;
    if (step.network.plane_count > 0 && stopped(k)) continue;
    const double m = step.network.mass[k];
    const double x = m * ((u.x[k] - v.x[k]) / t_c - acceleration_[0][k]);
    const double y = m * ((u.y[k] - v.y[k]) / t_c - acceleration_[1][k]);
    const double z = m * ((u.z[k] - v.z[k]) / t_c - acceleration_[2][k]);
    greatest.offer(x * x + y * y + z * z, k, step.network.user_number);
  }
  return std::sqrt(greatest.square);
}

std::uint32_t Recurrent::non_finite_node(const Step& step) {
  const springnet_vectors& p = step.outputs->position;
  std::uint32_t first = no_node;
  for (std::uint32_t k = 0; k < step.network.node_count; ++k) {
    if (std::isfinite(p.x[k]) && std::isfinite(p.y[k]) && std::isfinite(p.z[k])) continue;
    if (first == no_node || step.network.user_number[k] < step.network.user_number[first]) first = k;
  }
  return first == no_node ? step.differences.node : first;
}

std::string Recurrent::explain(const Step& step, Verdict verdict, const std::string& law_message) const {
  const std::uint32_t node = step.network.user_number[step.differences.node == no_node ? 0 : step.differences.node];
  const auto sweeps = static_cast<unsigned long long>(step.sweeps);
  const char* calmer = wavefront_ || exact_sweeps_ > 0 ? "use a smaller time_step, or less stiffness and damping"
                                                       : "use a smaller time_step or update = \"wavefront\"";
  std::array<char, 512> text{};
  if (!law_message.empty()) {
    std::snprintf(text.data(), text.size(), "the step diverges after %llu sweeps: %s; %s", sweeps, law_message.c_str(),
                  calmer);
    return text.data();
  }
  if (!step.finite) {
    std::snprintf(text.data(), text.size(),
                  "the step diverges after %llu sweeps: numbers are no longer finite, first at node %u; %s", sweeps,
                  node, calmer);
    return text.data();
  }
  const char* outcome = "diverges";
  const char* remedy = calmer;
  if (verdict == Verdict::oscillating) {
    outcome = "oscillates";
    remedy =
        "use a smaller time_step or more damping, or raise force_tolerance if it is near the rounding of the forces";
  } else if (verdict == Verdict::out_of_sweeps) {
    outcome = "ran out of sweeps";
    remedy = "raise max_sweeps, use a smaller time_step, or raise force_tolerance";
  }
  std::snprintf(text.data(), text.size(),
                "the step %s after %llu sweeps: the forces still change by %.3g N at node %u, more than "
                "force_tolerance %.3g N; %s; unsettled = \"accept\" takes the step as it is",
                outcome, sweeps, step.differences.greatest, node, step.tolerance, remedy);
  return text.data();
}

}  // namespace

SPRINGNET_PLUGIN("springnet.integrator.recurrent", "0.1.0", "springnet", "MIT", Recurrent);
