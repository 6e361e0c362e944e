// Velocity Verlet, in the form of
//
//   v_1/2 = v + h/2 a(p, v)
//   p'    = p + h v_1/2
//   v'    = v_1/2 + h/2 a(p', v_1/2 + h/2 a)
//
// Second order; symplectic where forces depend on positions alone. Explicit: stable for h below 2 / omega, omega the
// greatest angular frequency of the network, and below less than that with damping (stability.hpp). The host handles
// rigid connections, moved nodes and surfaces, and projects positions and velocities onto them. Swope, Andersen,
// Berens, Wilson, J. Chem. Phys. 76 (1982) 637; for the constraints Andersen, J. Comput. Phys. 52 (1983) 24. For nodes
// in contact the host constrains both parts of the step, the drift from p to p' and the kick from v_1/2 to v', because
// the reactions of each part decide about contact.
//
// It is also the example of an integrator: see sdk/integrators.md.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <springnet/sdk/integrator.hpp>

#include "stability.hpp"

namespace {

using namespace springnet::sdk;

// A vector quantity as 3n consecutive numbers, x of all nodes first, as in the host's linear functions.
struct Field {
  std::vector<double> values;
  explicit Field(std::size_t nodes) : values(3 * nodes) {}
  [[nodiscard]] springnet_vectors vectors() noexcept {
    const std::size_t n = values.size() / 3;
    return {values.data(), values.data() + n, values.data() + 2 * n};
  }
};

// to = base + factor times change, for n nodes.
void advance_by(const springnet_vectors& to, const springnet_vectors& base, double factor,
                const springnet_vectors& change, std::size_t n) noexcept {
  for (const auto component : {&springnet_vectors::x, &springnet_vectors::y, &springnet_vectors::z})
    for (std::size_t k = 0; k < n; ++k) (to.*component)[k] = (base.*component)[k] + factor * (change.*component)[k];
}

class Verlet : public Integrator {
 public:
  static constexpr const char* id = "verlet";
  static constexpr const char* summary = "velocity Verlet: explicit, second order, one evaluation per step";
  static constexpr const char* reference =
      "Swope, Andersen, Berens, Wilson, Journal of Chemical Physics 76 (1982) 637-649";
  static constexpr bool integrates_states = true;
  static constexpr bool keeps_bodies_apart = true, keeps_rigid_bodies_apart = true;
  static constexpr Parameter parameters[] = {
      integer("substeps", "equal steps within a time step").preset(1).at_least(1).at_most(1e9)};

  Verlet(Host host, Options options)
      : host_(host),
        substeps_(options.integer("substeps")),
        state_(host.make_state()),
        acceleration_(host.network().node_count),
        force_(host.network().node_count),
        half_(host.network().node_count),
        change_(host.network().node_count),
        stability_(host) {}

  springnet_status advance(double until, springnet_step_report& report) {
    const double from = host_.committed().time;
    const double h = (until - from) / static_cast<double>(substeps_);
    // Equal steps differ by the rounding of their ends.
    if (std::abs(h - checked_step_) > 1e-6 * checked_step_ || host_.network().revision != checked_revision_ ||
        ++steps_since_check_ >= steps_per_check)
      check_stability(until - from);
    report.residual = report.force_difference = std::numeric_limits<double>::quiet_NaN();
    made_ = smaller_ = 0;
    commits_ = false;
    try {
      for (std::int64_t i = 1; i <= substeps_; ++i)
        step_to(i == substeps_ ? until : from + static_cast<double>(i) * h, 0);
    } catch (const Failure& failure) {
      if (!failure.recoverable() || commits_) throw;
      report.outcome = SPRINGNET_DIVERGING;
      throw Failure(std::string(failure.what()) + "; use a smaller time_step or more substeps", SPRINGNET_UNSETTLED);
    }
    report.outcome = SPRINGNET_SETTLED;
    report.steps = 1;
    report.sweeps = made_;
    report.substeps = smaller_;
    return SPRINGNET_OK;
  }

  void forget() noexcept {
    revisions_.reset();
    checked_step_ = 0.0;
    checked_revision_ = steps_since_check_ = 0;
  }

  void limits(const LimitSink& sink) {
    if (is_any_sliding()) {
      sink.unknown("", "nodes slide on an obstacle, and the effect of their friction on the limit is not known");
      return;
    }
    const auto [time, state] = host_.committed();
    try {
      host_.linearise(evaluation_at(time, state));
    } catch (const Failure& failure) {
      sink.unknown("", failure.what());
      return;
    }
    const double h = stability_.limit(host_.network().rigid_count > 0);
    // Half a step is the weight: h^2 k / (4 m) + h d / m reaches 1.
    sink.report("", {SPRINGNET_LIMIT_KNOWN, h * static_cast<double>(substeps_), 0.5 * h, stability_.node()});
  }

 private:
  // Divides the step where the host finds no outputs that keep bodies apart, before it has taken any. Throws Failure.
  void step_to(double until, int halvings) {
    const double from = host_.committed().time;
    try {
      step(until);
    } catch (const Failure& failure) {
      revisions_.reset();
      const double middle = 0.5 * (from + until);
      const bool may_help = host_.network().body_contact_count > 0 && from < middle && middle < until;
      if (!failure.recoverable() || !may_repeat_ || !may_help || halvings == max_halvings) throw;
      step_to(middle, halvings + 1);
      step_to(until, halvings + 1);
      return;
    }
    ++made_;
    if (halvings > 0) ++smaller_;
    commits_ = true;               // a smaller step does not help if the commit is refused
    host_.commit(until, *state_);  // ruptures are carried out there
    commits_ = false;
  }

  void step(double until) {
    const auto [from, start] = host_.committed();
    host_.begin_step(from, until);
    const springnet_network& network = host_.network();
    const std::size_t n = network.node_count;
    const double h = until - from;
    may_repeat_ = true;
    // The acceleration at the end of the last step, unless something changed since then.
    const std::pair revisions(network.revision, host_.load_revision());
    if (revisions_ != revisions || network.rigid_count > 0) {
      springnet_evaluation at_start = evaluation_at(from, start);
      at_start.force = force_.vectors();
      at_start.acceleration = acceleration_.vectors();
      host_.evaluate(at_start);
      revisions_ = revisions;
    }

    springnet_state& next = *state_;
    const springnet_vectors half = half_.vectors();
    advance_by(half, start.velocity, 0.5 * h, acceleration_.vectors(), n);  // v_1/2
    advance_by(next.position, start.position, h, half, n);
    constrain(drift, start, next, until, h, half);
    advance_by(next.velocity, half, 0.5 * h, acceleration_.vectors(), n);  // v', predicted
    host_.project_state(until, next);

    change_.values = acceleration_.values;
    springnet_evaluation at_end = evaluation_at(until, next);
    const springnet_internal internal{sizeof internal, 2, h, nullptr, next.internal, nullptr};
    if (network.internal_count > 0) at_end.internal = &internal;
    at_end.force = force_.vectors();
    at_end.acceleration = acceleration_.vectors();
    host_.evaluate(at_end);
    for (std::size_t i = 0; i < 3 * n; ++i) change_.values[i] = acceleration_.values[i] - change_.values[i];
    advance_by(next.velocity, next.velocity, 0.5 * h, change_.vectors(), n);
    host_.project_state(until, next);
    may_repeat_ = network.surface_count == 0;  // the host takes the contacts that obstacles decide in the kick
    constrain(kick, start, next, until, h, next.velocity);

    next.force_is_current = 0;  // velocity-dependent forces belong to the predicted velocity
  }

  // Nodes in contact: see springnet_sweep::contacts.
  enum Part : std::uint32_t { drift = 2, kick = 3 };
  void constrain(Part part, const springnet_state& start, springnet_state& next, double until, double h,
                 const springnet_vectors& velocity) {
    if (host_.network().surface_count == 0 && host_.network().body_contact_count == 0) return;
    springnet_sweep sweep{};
    sweep.struct_size = sizeof sweep;
    sweep.time = until;
    sweep.time_constant = h;
    sweep.start_position = view(start.position);
    sweep.start_velocity = view(start.velocity);
    sweep.position = view(next.position);
    sweep.velocity = view(next.velocity);
    sweep.next_position = next.position;
    sweep.next_velocity = velocity;
    sweep.force = force_.vectors();
    sweep.contacts = part;
    host_.constrain(sweep);
  }

  // Nets with sliding nodes are not checked: the derivative of friction turns its direction and, however stiff, limits
  // no step.
  [[nodiscard]] bool is_any_sliding() const {
    const springnet_network& network = host_.network();
    for (std::uint32_t k = 0; network.surface_count > 0 && k < network.node_count; ++k)
      if (network.touching[k] != 0 && network.held[k] == 0) return true;
    return false;
  }

  // Throws if steps are above the limit of stability, where the solution grows without bound.
  void check_stability(double time_step) {
    const double h = time_step / static_cast<double>(substeps_);
    checked_step_ = h;
    checked_revision_ = host_.network().revision;
    steps_since_check_ = 0;
    if (is_any_sliding()) return;
    const springnet_network& network = host_.network();
    const auto [from, start] = host_.committed();
    char text[320 + sizeof(springnet_message)];
    try {
      host_.linearise(evaluation_at(from, start));
    } catch (const Failure& failure) {
      if (failure.recoverable()) {
        std::snprintf(text, sizeof text,
                      "verlet: at %.9g s the derivatives of the forces are not finite, so that no step is stable: %s; "
                      "use another integrator if the law is at its limit there",
                      from, failure.what());
        throw Failure(text);
      }
      host_.note(
          "verlet: a law or neuron has no derivatives, so the limit of stability of the time step is not checked");
      return;
    }
    const double limit = stability_.limit(network.rigid_count > 0);
    if (h <= limit) return;
    if (!(limit > 0.0)) {
      std::snprintf(text, sizeof text,
                    "verlet: at %.9g s the derivatives of the forces are not finite, so that no step is stable; look "
                    "for a law that is at its limit there, or use another integrator",
                    from);
      throw Failure(text);
    }
    const double needed = std::ceil(reserve * time_step / limit);
    char advice[64] = "";
    if (needed <= parameters[0].largest) std::snprintf(advice, sizeof advice, ", substeps = %.0f or more,", needed);
    std::snprintf(text, sizeof text,
                  "verlet: steps of %.3g s are above the limit of stability, about %.3g s for this network; use a "
                  "smaller time_step%s or another integrator",
                  h, limit, advice);
    throw Failure(text);
  }

  Host host_;
  std::int64_t substeps_;
  State state_;
  Field acceleration_;  // m/s^2, at the committed state
  Field force_;         // N, likewise, without constraint forces
  Field half_;          // m/s, v_1/2
  Field change_;
  Stability stability_;
  // Revisions of the network and its loads that acceleration_ belongs to.
  std::optional<std::pair<std::uint64_t, std::uint64_t>> revisions_;
  static constexpr int max_halvings = 8;                 // 1/256 of a step
  static constexpr std::uint64_t steps_per_check = 256;  // laws may stiffen
  static constexpr double reserve = 1.03;                // of the advice: laws may stiffen a little
  double checked_step_ = 0.0;                            // s
  std::uint64_t made_ = 0, smaller_ = 0;                 // steps of this time step; those of them of divided ones
  bool may_repeat_ = true, commits_ = false;
  std::uint64_t checked_revision_ = 0;
  std::uint64_t steps_since_check_ = 0;
};

}  // namespace

SPRINGNET_PLUGIN("springnet.integrator.verlet", "0.1.0", "springnet", "MIT", Verlet);
