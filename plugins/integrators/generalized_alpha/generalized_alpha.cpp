// Integrator: the generalized-alpha method of Chung and Hulbert, implicit, of second order, with a chosen damping of
// motions that a step does not resolve.
//
// Over a step h, with a the accelerations that the method keeps:
//   P = p + h v + h^2 ((1/2 - beta) a + beta A),   V = v + h ((1 - gamma) a + gamma A)
//   (1 - alpha_m) A + alpha_m a = acceleration(p_f, v_f, z_f, t_f),   x_f = (1 - alpha_f) x(end) + alpha_f x(start)
// The four numbers follow from the spectral radius rho at infinite stiffness. z are the states of laws, stepped from
// the start of the step to t_f, and once more to its end.
//
// A step that follows a discontinuity, an event or a step of another length has no a. It takes a = A, which is the
// implicit midpoint rule for rho = 1. A start with the acceleration of that moment would throw stiff modes far off; the
// error of a = A, of second order, is made once.
//
// Contacts, releases, slip and stick, and ruptures are located in the step's cubic interpolation. They end the step.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <springnet/sdk/integrator.hpp>

namespace {
using namespace springnet::sdk;

struct Rule {
  double alpha_m, alpha_f, beta, gamma;
};

Rule rule_of(double rho) noexcept {
  const double alpha_m = (2.0 * rho - 1.0) / (rho + 1.0), alpha_f = rho / (rho + 1.0);
  const double sum = 1.0 - alpha_m + alpha_f;
  return {alpha_m, alpha_f, 0.25 * sum * sum, sum - 0.5};
}

// One vector a node, in memory of its own; x of all nodes first.
class Field {
 public:
  explicit Field(std::size_t nodes) : nodes_(nodes), values_(3 * nodes) {}
  [[nodiscard]] double* data() noexcept { return values_.data(); }
  [[nodiscard]] double& operator[](std::size_t i) noexcept { return values_[i]; }
  [[nodiscard]] double operator[](std::size_t i) const noexcept { return values_[i]; }
  [[nodiscard]] std::size_t size() const noexcept { return values_.size(); }
  [[nodiscard]] std::span<double> values() noexcept { return values_; }
  [[nodiscard]] std::span<const double> values() const noexcept { return values_; }
  void clear() { std::fill(values_.begin(), values_.end(), 0.0); }
  operator springnet_vectors() noexcept { return {data(), data() + nodes_, data() + 2 * nodes_}; }
  operator springnet_const_vectors() const noexcept {
    return {values_.data(), values_.data() + nodes_, values_.data() + 2 * nodes_};
  }

 private:
  std::size_t nodes_;
  std::vector<double> values_;
};

std::array<double*, 3> components(const springnet_vectors& v) noexcept { return {v.x, v.y, v.z}; }

class GeneralizedAlpha : public Integrator {
 public:
  static constexpr const char* id = "generalized_alpha";
  static constexpr const char* summary = "implicit steps of second order with a chosen damping of stiff motions";
  static constexpr const char* reference =
      "Chung, Hulbert: A time integration algorithm for structural dynamics with improved numerical dissipation: the "
      "generalized-alpha method (J. Appl. Mech. 60, 1993)";
  static constexpr bool integrates_states = true;
  static constexpr bool locates_events = true;
  // Of a time step: more are a search without end, as for a law at its limit.
  static constexpr std::uint64_t most_parts = 20000;
  static constexpr Parameter parameters[] = {
      number("spectral_radius", "1", "what a step leaves of motions much faster than it; 1: no damping")
          .preset(0.8)
          .at_least(0)
          .at_most(1),
      number("tolerance", "1", "of the force left over in a step, relative to the greatest").preset(1e-9).above(0),
      integer("iterations", "of Newton's method before a step is halved").preset(20).at_least(1),
      integer("halvings", "of a step that does not converge").preset(24).at_least(0).at_most(40),
      integer("events", "located in a time step; those after them take place at its end").preset(1000).at_least(0)};

  GeneralizedAlpha(Host host, Options options)
      : host_(host),
        rule_(rule_of(options["spectral_radius"])),
        tolerance_(options["tolerance"]),
        iterations_(options.integer("iterations")),
        halvings_(options.integer<int>("halvings")),
        most_events_(options.integer("events")),
        nodes_(host.network().node_count),
        next_(host.make_state()),
        found_(host.make_state()),
        free_(host.make_state()),
        kept_(nodes_),
        new_(nodes_),
        position_(nodes_),
        velocity_(nodes_),
        acceleration_(nodes_),
        force_(nodes_),
        difference_(nodes_),
        tangential_(nodes_) {}

  springnet_status advance(double until, springnet_step_report& report) {
    const double whole = until - host_.committed().time;
    const double smallest = std::ldexp(whole, -halvings_);
    int successes = 0;  // in a row
    std::uint64_t parts = 0;
    double length = whole, interval_end = -std::numeric_limits<double>::infinity();
    events_ = instant_events_ = 0;
    out_of_time_ = false;
    report.outcome = SPRINGNET_SETTLED;
    report.residual = 0.0;
    while (true) {
      const double from = host_.committed().time;
      if (from >= until) break;
      if (++parts > most_parts)
        throw Failure("after " + std::to_string(most_parts) + " parts the step has come to " + std::to_string(from) +
                          " s; look for a law that is near its limit there, or for a spring that has shrunk to nothing",
                      SPRINGNET_UNSETTLED);
      // At a deadline the rest is made at once, as well as it goes.
      if (parts > 1 && host_.time_left() <= 0.0) length = whole;
      if (from >= interval_end) {
        interval_end = std::min(until, host_.next_discontinuity(from));
        host_.begin_interval(from, interval_end);
      }
      // Pieces that rounding would leave are added to the one before.
      const double to = from + length * (1.0 + 1e-6) >= interval_end ? interval_end : from + length;
      if (!settle(from, to, report)) {
        forget();
        successes = 0;
        length = retry_ * (to - from);
        if (length < smallest) {
          report.outcome = SPRINGNET_OUT_OF_SWEEPS;
          throw Failure(why_ + "; halved " + std::to_string(halvings_) + " times, the step still does not converge",
                        SPRINGNET_UNSETTLED);
        }
        continue;
      }
      if (length < whole) ++report.substeps;
      if (finish(from, to, report)) {
        length = whole;
      } else if (++successes % 4 == 0) {
        length = std::min(2.0 * length, whole);
      }
    }
    if (out_of_time_) report.outcome = SPRINGNET_OUT_OF_TIME;
    return SPRINGNET_OK;
  }

  // No step is too long for a linear network.
  void limits(const LimitSink& sink) {
    const auto [time, state] = host_.committed();
    try {
      host_.linearise(evaluation_at(time, state));
      sink.none("", "every step is stable as far as linear theory tells");
    } catch (const Failure& failure) {
      if (!failure.recoverable()) throw;
      sink.unknown("", failure.what());
    }
  }

  void forget() noexcept { kept_length_ = last_end_ = last_start_ = 0.0; }
  void save(const ByteSink& sink) const {
    sink.put(kept_revision_ == host_.network().revision ? kept_length_ : 0.0);
    sink.put(owner());
    sink.put(static_cast<std::uint8_t>(extrapolates_ ? 1 : 0));
    sink.put_all(kept_.values());
  }
  void restore(std::span<const std::byte> bytes) {
    forget();
    ByteSource source(bytes);
    double length = 0.0;
    Owner saved_by{};
    std::uint8_t extrapolates = 0;
    source.get(length);
    source.get(saved_by);
    if (saved_by != owner()) throw Failure("the memory is that of another network or another spectral_radius");
    source.get(extrapolates);
    if (!(length >= 0.0 && std::isfinite(length)) || extrapolates > 1) throw Failure("the memory is damaged");
    source.get_all(kept_.values());
    if (!source.is_empty()) throw Failure("the memory is longer than this network's");
    extrapolates_ = extrapolates != 0;
    kept_length_ = length;
    kept_revision_ = host_.network().revision;
  }
  // The commit has exchanged the memory of both ends.
  void interpolate(double time, const springnet_vectors& position, const springnet_vectors& velocity) const {
    if (!(last_start_ < last_end_ && time >= last_start_ && time <= last_end_))
      throw Failure("no step that ended without an event includes that time");
    const double h = last_end_ - last_start_;
    between({*next_, host_.committed().state, h}, (time - last_start_) / h, position, velocity);
  }

 private:
  // What memory belongs to.
  using Owner = std::array<double, 4>;
  [[nodiscard]] Owner owner() const {
    const springnet_network& network = host_.network();
    return {static_cast<double>(network.node_count), static_cast<double>(network.spring_number_count),
            static_cast<double>(network.element_number_count), rule_.alpha_f};
  }
  // Solves the step for new_, and writes the state at its end to next_. False if a smaller step is needed.
  bool settle(double from, double to, springnet_step_report& report) {
    h_ = to - from;
    retry_ = 0.5;
    last_start_ = last_end_ = 0.0;  // next_ is overwritten
    const bool starts = kept_revision_ != host_.network().revision || std::abs(kept_length_ - h_) > 1e-6 * h_;
    step_rule_ = starts ? Rule{0.0, rule_.alpha_f, 0.5, 1.0} : rule_;
    if (starts) kept_.clear();
    if (starts) extrapolates_ = true;
    try {
      predict();
      find_prescribed(to);
      if (!iterate(to, report)) return false;
      if (constrained_) copy(*next_, *free_);
      host_.project_state(to, *next_);
      // In a bend the projection takes velocity that nodes had until there: the step is interpolated without.
      bent_ = constrained_ && bends(*free_, *next_, 0.01);
      if (bent_ && bends(*free_, *next_, 0.2)) return fail_at_bend(from);
      extrapolates_ = predicts_well();
      return true;
    } catch (const Failure& failure) {
      if (!failure.recoverable()) throw;
      why_ = failure.what();
      return false;
    }
  }

  // The first guess: as before, or, where that was worse than no motion, none. Stiff motions, which a step does not
  // resolve, would be thrown far off by their accelerations.
  void predict() {
    new_ = kept_;
    if (extrapolates_) return;
    const auto v = components(host_.committed().state.velocity);
    for (std::size_t i = 0; i < new_.size(); ++i)
      new_[i] = -(v[i / nodes_][i % nodes_] / h_ + (0.5 - step_rule_.beta) * kept_[i]) / step_rule_.beta;
  }
  [[nodiscard]] bool predicts_well() const {
    const springnet_state& now = host_.committed().state;
    const auto p = components(now.position), v = components(now.velocity), next = components(next_->position);
    double moved = 0.0, missed = 0.0;
    for (std::size_t i = 0; i < new_.size(); ++i) {
      const std::size_t c = i / nodes_, k = i % nodes_;
      const double way = next[c][k] - p[c][k], guess = h_ * (v[c][k] + 0.5 * h_ * kept_[i]);
      moved = std::max(moved, std::abs(way));
      missed = std::max(missed, std::abs(guess - way));
    }
    return missed <= moved;
  }

  bool iterate(double to, springnet_step_report& report) {
    const double share = 1.0 - step_rule_.alpha_f, inertia = 1.0 - step_rule_.alpha_m;
    const Host::SystemWeights weights{share * step_rule_.gamma * h_ / inertia,
                                      share * step_rule_.beta * h_ * h_ / inertia};
    const springnet_network& network = host_.network();
    constrained_ = network.rigid_count > 0;
    for (std::size_t k = 0; k < nodes_ && !constrained_; ++k) constrained_ = network.touching[k] != 0;

    auto states = sized<springnet_internal>();
    states.order = 2;
    states.time_step = share * h_;
    auto evaluation = sized<springnet_evaluation>();
    evaluation.time = to - step_rule_.alpha_f * h_;
    evaluation.position = position_;
    evaluation.velocity = velocity_;
    evaluation.internal = network.internal_count > 0 ? &states : nullptr;

    double before = std::numeric_limits<double>::infinity(), first = before;
    bool last = false;
    constexpr std::int64_t patience = 8;  // iterations
    for (std::int64_t iteration = 0;; ++iteration) {
      end_state();
      between();
      evaluation.acceleration = acceleration_;
      evaluation.force = force_;
      host_.evaluate(evaluation);
      ++report.sweeps;
      for (std::size_t i = 0; i < new_.size(); ++i)
        difference_[i] = (acceleration_[i] - step_rule_.alpha_m * kept_[i]) / inertia - new_[i];
      evaluation.acceleration = evaluation.force = {};
      const auto split = [&] {
        tangential_ = difference_;
        if (constrained_) host_.project(nullptr, tangential_.data());
        return measure();
      };
      const auto assemble = [&] {
        host_.linearise(evaluation);
        host_.prepare_system(weights);
      };
      if (iteration == 0) assemble();
      const Size size = split();
      report.residual = inertia * size.residual;
      if (!std::isfinite(size.residual)) return fail("a force is not finite");
      const bool settled = last || inertia * size.residual <= tolerance_ * size.force;
      if (!settled && iteration >= iterations_) return fail("Newton's method takes too many iterations");
      if (!settled && host_.time_left() < 0.0 && iteration > 0) out_of_time_ = true;
      if (iteration == 0) first = size.residual;
      if (size.residual > 1e3 * first || (iteration >= patience && size.residual > 0.5 * first))
        return fail("Newton's method does not converge");
      if (settled || (out_of_time_ && iteration > 0)) {
        // What constraints ask for needs no system.
        for (std::size_t i = 0; i < new_.size(); ++i) new_[i] += difference_[i] - tangential_[i];
        end_state();
        return true;
      }
      if (iteration > 0 && size.residual > 0.2 * before) {
        assemble();
        split();
      }
      before = size.residual;
      // x among the motions that constraints allow; the rest of the difference is the constraints' own.
      Field& x = acceleration_;
      const Host::Solved solved = host_.solve_system(tangential_.data(), 1e-4, x.data());
      if (solved.outcome == SPRINGNET_TRUNCATED) return fail("the linear system is not definite");
      double change = 0.0;
      for (std::size_t i = 0; i < new_.size(); ++i) {
        new_[i] += x[i] + (difference_[i] - tangential_[i]);
        change = std::max(change, std::abs(x[i]));
      }
      // A change that rounding of the positions hides, and so of the forces, cannot be improved upon.
      const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * size.position;
      last = step_rule_.beta * h_ * h_ * change <= rounding;
    }
  }

  bool fail(const char* why) {
    why_ = why;
    return false;
  }

  struct Size {
    double residual = 0.0, force = 0.0, position = 0.0;  // N, N, m: greatest of a node
  };
  Size measure() const {
    const springnet_network& network = host_.network();
    Size size{0.0, 1e-6 * network.force_scale, network.length_scale};
    for (std::size_t i = 0; i < new_.size(); ++i) {
      const std::size_t k = i % nodes_;
      size.position = std::max(size.position, std::abs(position_[i]));
      if (network.fixed[k] != 0 || network.held[k] != 0) continue;
      const double mass = network.mass[k], residual = mass * std::abs(tangential_[i]);
      size.residual = std::isfinite(residual) ? std::max(size.residual, residual) : residual;
      if (!std::isfinite(residual)) return size;
      size.force =
          std::max({size.force, mass * std::abs(new_[i]), mass * std::abs(acceleration_[i]), std::abs(force_[i])});
    }
    return size;
  }

  // The state at the end of the step by new_. Nodes that are fixed or moved are where they have to be.
  void end_state() {
    const springnet_state& now = host_.committed().state;
    const auto p = components(now.position), v = components(now.velocity);
    const auto next_p = components(next_->position), next_v = components(next_->velocity);
    const double beta = step_rule_.beta, gamma = step_rule_.gamma;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < nodes_; ++k) {
        const double a = kept_[c * nodes_ + k], b = new_[c * nodes_ + k];
        next_p[c][k] = p[c][k] + h_ * (v[c][k] + h_ * ((0.5 - beta) * a + beta * b));
        next_v[c][k] = v[c][k] + h_ * ((1.0 - gamma) * a + gamma * b);
      }
    }
    for (const Prescribed& node : prescribed_) {
      for (std::size_t c = 0; c < 3; ++c) {
        next_p[c][node.node] = node.position[c];
        next_v[c][node.node] = node.velocity[c];
      }
    }
  }
  void copy(const springnet_state& from, springnet_state& to) const {
    for (std::size_t c = 0; c < 3; ++c) {
      std::copy_n(components(from.position)[c], nodes_, components(to.position)[c]);
      std::copy_n(components(from.velocity)[c], nodes_, components(to.velocity)[c]);
    }
  }
  void between() {
    const springnet_state& now = host_.committed().state;
    const auto p = components(now.position), v = components(now.velocity);
    const auto next_p = components(next_->position), next_v = components(next_->velocity);
    const double start = step_rule_.alpha_f, end = 1.0 - start;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < nodes_; ++k) {
        position_[c * nodes_ + k] = end * next_p[c][k] + start * p[c][k];
        velocity_[c * nodes_ + k] = end * next_v[c][k] + start * v[c][k];
      }
    }
  }
  void find_prescribed(double to) {
    prescribed_.clear();
    const springnet_network& network = host_.network();
    for (std::uint32_t k = 0; k < nodes_; ++k)
      if (network.fixed[k] != 0) prescribed_.push_back({k, {}, {}});
    if (prescribed_.empty()) return;
    const std::vector<Prescribed> nodes = std::move(prescribed_);
    prescribed_.clear();
    end_state();
    host_.project_state(to, *next_);
    const auto p = components(next_->position), v = components(next_->velocity);
    for (const Prescribed& node : nodes) {
      const std::uint32_t k = node.node;
      prescribed_.push_back({k, {p[0][k], p[1][k], p[2][k]}, {v[0][k], v[1][k], v[2][k]}});
    }
  }

  // Whether a surface that a node slides on, or a rigid connection, turns over the step by more than about `angle`: the
  // projection onto it takes that share of the node's velocity. At a sharp edge it would take all.
  [[nodiscard]] bool bends(const springnet_state& free, const springnet_state& bound, double angle) const {
    const springnet_network& network = host_.network();
    const auto v = components(host_.committed().state.velocity), u = components(free.velocity),
               w = components(bound.velocity);
    for (std::size_t k = 0; k < nodes_; ++k) {
      if (network.fixed[k] != 0 || network.held[k] != 0) continue;
      double before = 0.0, gained = 0.0, lost = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        before = std::hypot(before, v[c][k]);
        gained = std::hypot(gained, u[c][k] - v[c][k]);
        lost = std::hypot(lost, w[c][k] - u[c][k]);
      }
      if (lost > angle * (before + gained) + 1e-6 * network.velocity_scale) return true;
    }
    return false;
  }
  // The next try ends early in the bend, so that the event at its beginning is found.
  bool fail_at_bend(double from) {
    constexpr double accuracy = 1e-12;
    double low = 0.0, high = 1.0;
    while (high - low > accuracy) {
      const double s = 0.5 * (low + high);
      between({host_.committed().state, *free_, h_}, s, next_->position, next_->velocity);
      copy(*next_, *found_);
      host_.project_state(from + s * h_, *found_);
      (bends(*next_, *found_, 0.1) ? high : low) = s;
    }
    retry_ = std::clamp(low, 1.0 / 64.0, 0.999);
    return fail("constraints turn too sharply");
  }

  // Commits the step, or its part up to the first event; true if there was one.
  bool finish(double from, double to, springnet_step_report& report) {
    next_->force_is_current = 0;
    step_states(from, to, *next_);
    ++report.steps;
    if (locate(from, to)) return true;
    // Read before the commit, which carries out cuts: after one of these the accelerations are others.
    kept_revision_ = host_.network().revision;
    host_.commit(to, *next_);
    kept_ = new_;
    kept_length_ = h_;
    last_start_ = from;
    last_end_ = to;
    return false;
  }
  springnet_internal states_until(double from, double time) const {
    auto states = sized<springnet_internal>();
    states.order = 2;
    states.time_step = time - from;
    return states;
  }
  // The states of laws at `time` where nodes are as in `state`, from those at `from`.
  void step_states(double from, double time, springnet_state& state) {
    if (host_.network().internal_count == 0) return;
    auto states = states_until(from, time);
    states.next = state.internal;
    auto evaluation = evaluation_at(time, state);
    evaluation.internal = &states;
    evaluation.force = force_;
    host_.evaluate(evaluation);
  }

  // ---- events

  void values_at(double from, double time, const springnet_state& state, std::vector<double>& values) {
    auto states = states_until(from, time);
    auto evaluation = evaluation_at(time, state);
    if (time > from && host_.network().internal_count > 0) evaluation.internal = &states;
    values.resize(host_.network().event_count);
    directions_.resize(values.size());
    host_.event_values(evaluation, values.data(), directions_.data());
  }
  // The interpolation of a step: cubic in the positions; s from 0 to 1.
  struct Ends {
    const springnet_state &start, &end;
    double length;  // s
  };
  void between(const Ends& ends, double s, const springnet_vectors& position, const springnet_vectors& velocity) const {
    const double r = 1.0 - s, h = ends.length;
    const auto p = components(ends.start.position), v = components(ends.start.velocity);
    const auto q = components(ends.end.position), w = components(ends.end.velocity);
    const auto to_p = components(position), to_v = components(velocity);
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < nodes_; ++k) {
        const double way = q[c][k] - p[c][k];
        to_p[c][k] = p[c][k] + s * s * (3.0 - 2.0 * s) * way + h * s * r * (r * v[c][k] - s * w[c][k]);
        to_v[c][k] = 6.0 * s * r * (way / h) + r * (1.0 - 3.0 * s) * v[c][k] + s * (3.0 * s - 2.0) * w[c][k];
      }
    }
  }
  void within(double from, double time, const springnet_vectors& position, const springnet_vectors& velocity) const {
    between({host_.committed().state, bent_ ? *free_ : *next_, h_}, (time - from) / h_, position, velocity);
  }
  void find_state(double from, double time) {
    within(from, time, found_->position, found_->velocity);
    if (bent_) host_.project_state(time, *found_);
    found_->force_is_current = 0;
    step_states(from, time, *found_);
  }
  // An event is due where its value is beyond zero.
  [[nodiscard]] static bool is_due(double value, double start, std::int32_t direction) noexcept {
    return direction < 0 ? value < 0.0 : direction > 0 ? value > 0.0 : value * start < 0.0;
  }
  [[nodiscard]] static bool is_ahead(double start, std::int32_t direction) noexcept {
    return direction < 0 ? start > 0.0 : direction > 0 ? start < 0.0 : start != 0.0;
  }
  // Marks what is due of the events that were ahead at the start; true if there are any.
  bool mark(const std::vector<double>& values) {
    fired_.assign(values.size(), 0);
    for (std::size_t i = 0; i < values.size(); ++i)
      fired_[i] = is_ahead(start_[i], directions_[i]) && is_due(values[i], start_[i], directions_[i]) ? 1 : 0;
    return std::find(fired_.begin(), fired_.end(), 1) != fired_.end();
  }
  void fire(double time, State& state) {
    host_.fire_events(time, *state, fired_.data());
    host_.commit(time, *state);
    forget();
    ++events_;
  }

  // Commits the state after the first event of the step; false if there is none.
  bool locate(double from, double to) {
    const springnet_network& network = host_.network();
    if (network.event_count == 0 && network.surface_count == 0) return false;
    values_at(from, to, *next_, end_);
    bool some = false;
    for (std::size_t i = 0; i < end_.size(); ++i)
      some = some || directions_[i] == 0 || is_due(end_[i], 0.0, directions_[i]);
    if (some) {
      values_at(from, from, host_.committed().state, start_);
      // Due from the start, and more so at the end: a contact that pulls, say.
      fired_.assign(end_.size(), 0);
      bool early = false;
      for (std::size_t i = 0; i < end_.size(); ++i) {
        if (is_ahead(start_[i], directions_[i]) || !is_due(end_[i], start_[i], directions_[i])) continue;
        if (std::abs(end_[i]) <= std::abs(start_[i])) continue;
        early = true;
        fired_[i] = 1;
      }
      if (early) return fire_early(from, to);
      some = mark(end_);
    }
    if (out_of_time_ || events_ >= most_events_) {
      if (some) fire(to, next_);
      return some;
    }
    double time = to;
    if (some) time = first_root(from, to);
    bool touches = false;
    if (network.surface_count > 0) {
      const auto impact = host_.time_of_impact(
          {from, to}, {from, time}, 1e-9 * network.length_scale,
          [&](double at, const springnet_vectors& p, const springnet_vectors& v) { within(from, at, p, v); });
      touches = impact.has_value() && *impact < time;
      if (touches) time = *impact;
    }
    if (!some && !touches) return false;
    if (touches) fired_.assign(end_.size(), 0);
    count_instant(from, time);
    if (time >= to) {
      fire(to, next_);
    } else {
      find_state(from, time);
      fire(time, found_);
    }
    return true;
  }
  void count_instant(double from, double time) { instant_events_ = time - from > 1e-9 * h_ ? 0 : instant_events_ + 1; }
  bool fire_early(double from, double to) {
    constexpr int most = 8;  // at one time; what goes on after that goes on at the end of the step
    count_instant(from, from);
    if (instant_events_ > most || out_of_time_ || events_ >= most_events_) {
      instant_events_ = 0;
      fire(to, next_);
      return true;
    }
    find_state(from, from);
    fire(from, found_);
    return true;
  }
  // Of the events marked; marks those that are due then. The method of false position, after Illinois.
  double first_root(double from, double to) {
    double low = from, high = to, low_weight = 1.0, high_weight = 1.0;
    int side = 0;
    low_ = start_;
    const double accuracy =
        1e-11 * (to - from) + 4.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(from), std::abs(to));
    for (int trial = 0; trial < 150 && high - low > accuracy; ++trial) {
      double share = 1.0;
      for (std::size_t i = 0; i < end_.size(); ++i) {
        if (fired_[i] == 0) continue;
        const double a = low_weight * std::abs(low_[i]), b = high_weight * std::abs(end_[i]);
        share = std::min(share, a + b > 0.0 ? a / (a + b) : 0.5);
      }
      if (trial % 3 == 2) share = 0.5;  // a value that jumps, as a reaction does at a seam, misleads false position
      const double margin = 0.5 * accuracy / (high - low);
      const double time = low + (high - low) * std::clamp(share, std::min(margin, 0.5), std::max(1.0 - margin, 0.5));
      find_state(from, time);
      values_at(from, time, *found_, trial_);
      std::swap(fired_, marked_);
      if (mark(trial_)) {
        high = time;
        end_ = trial_;
        high_weight = 1.0;
        low_weight = side > 0 ? 0.5 * low_weight : 1.0;
        side = 1;
      } else {
        std::swap(fired_, marked_);
        low = time;
        low_ = trial_;
        low_weight = 1.0;
        high_weight = side < 0 ? 0.5 * high_weight : 1.0;
        side = -1;
      }
    }
    return high;
  }

  struct Prescribed {
    std::uint32_t node;
    std::array<double, 3> position, velocity;  // m, m/s, at the end of the step
  };

  Host host_;
  Rule rule_, step_rule_{};  // step_rule_: of the present step
  double tolerance_;
  std::int64_t iterations_;
  int halvings_;
  std::int64_t most_events_;
  std::size_t nodes_;
  State next_, found_, free_;  // the end of the step; the state at an event; the end before it is projected
  Field kept_, new_;           // a, A, m/s^2
  Field position_, velocity_, acceleration_, force_, difference_, tangential_;
  std::vector<Prescribed> prescribed_;

  // From one step to the next: a belongs to a step of this length, s, after which the network was this one.
  double kept_length_ = 0.0;
  std::uint64_t kept_revision_ = 0;
  bool extrapolates_ = true;
  double last_start_ = 0.0, last_end_ = 0.0;  // s, of the step that can be interpolated; equal: none

  double h_ = 0.0;                           // s
  bool constrained_ = false, bent_ = false;  // by surfaces or rigid connections
  double retry_ = 0.5;                       // share of a step that failed to try next
  std::string why_;                          // it failed
  bool out_of_time_ = false;
  std::int64_t events_ = 0;
  int instant_events_ = 0;  // in a row that took no time
  std::vector<double> start_, end_, low_, trial_;
  std::vector<std::int32_t> directions_, fired_, marked_;
};

}  // namespace

SPRINGNET_PLUGIN("springnet.integrator.generalized_alpha", "0.1.0", "springnet", "MIT", GeneralizedAlpha);
