#include "integrator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <sstream>
#include <string>
#include <utility>

#include "failure_text.hpp"

namespace springnet::cvode {
namespace {

// Up to this many nodes a factorisation costs about as much as iterations, and copes with any stiffness. Beyond, its
// cost grows faster: 3 times that of iterations at 500 nodes, 5 times at 1300, measured on lattices of stiff springs.
constexpr std::size_t max_nodes_direct = 300;
// Each failure shortens the step by up to a factor of ten, so that any step length is found.
constexpr int max_shortenings = 20;
// More events at one time, beyond one of each kind, are a chattering contact, not a chain of ruptures or contacts.
constexpr std::uint64_t max_events_at_once = 16;

constexpr double shortest_product = 1e-100;  // s: products of shorter steps are 0

// Whether two times differ by at most this many roundings.
bool same_time(double a, double b, double roundings) noexcept {
  const double rounding = std::numeric_limits<double>::epsilon() * std::max(std::abs(a), std::abs(b));
  return std::abs(b - a) <= std::max(roundings * rounding, shortest_product);
}
constexpr double shortest_step = 16.0;    // roundings: CVODE cannot step between closer times
constexpr double root_accuracy = 1000.0;  // roundings: CVODE locates roots to 100 of the time and of the step

// Uncertainty of positions between the ends of a step, in units of the position tolerance.
constexpr double position_uncertainty = 10.0;

// Internal steps between checks that the time still advances by more than its rounding.
constexpr long steps_per_check = 500;
// Each failure makes the step four times shorter, so that a step past the edge of a face finally ends at the edge.
constexpr int max_projection_failures = 40;

// Networks without springs or motion may have no scale.
double positive_or_one(double scale) noexcept { return scale > 0.0 && std::isfinite(scale) ? scale : 1.0; }

Callbacks& callbacks_of(void* user_data) noexcept { return *static_cast<Callbacks*>(user_data); }

int right_side(double time, N_Vector y, N_Vector rate, void* user_data) {
  return callbacks_of(user_data).equations.right_side(time, y, rate);
}
int error_weights(N_Vector y, N_Vector weights, void* user_data) {
  return callbacks_of(user_data).equations.error_weights(y, weights);
}
int event_values(double time, N_Vector y, double* values, void* user_data) {
  return callbacks_of(user_data).equations.event_values(time, y, values);
}

int correction(double time, N_Vector y, N_Vector correction, double, N_Vector, void* user_data) {
  return callbacks_of(user_data).equations.correction(time, y, correction);
}

// y = [px py pz vx vy vz] to vectors of the host.
void unpack(const double* y, const springnet_vectors& position, const springnet_vectors& velocity,
            std::size_t n) noexcept {
  for (const springnet_vectors& part : {position, velocity}) {
    for (double* component : {part.x, part.y, part.z}) {
      std::copy_n(y, n, component);
      y += n;
    }
  }
}

void copy(const springnet_state& from, springnet_state& to, const springnet_network& network) noexcept {
  const std::size_t n = network.node_count;
  std::copy_n(from.internal, network.internal_count, to.internal);
  for (const auto part : {&springnet_state::position, &springnet_state::velocity}) {
    for (const auto component : {&springnet_vectors::x, &springnet_vectors::y, &springnet_vectors::z}) {
      std::copy_n(from.*part.*component, n, to.*part.*component);
    }
  }
}

}  // namespace

ReferenceIntegrator::ReferenceIntegrator(const sdk::Host& host, const Settings& settings)
    : host_(host),
      settings_(settings),
      equations_(host),
      sensitivities_(equations_),
      callbacks_{equations_, &sensitivities_, nullptr},
      last_event_time_(-std::numeric_limits<double>::infinity()) {
  if (settings.method == Method::bdf && settings.max_order > 5) {
    throw sdk::Failure("cvode: max_order is at most 5 for method \"bdf\", is " + std::to_string(settings.max_order));
  }
}

LinearSolverKind ReferenceIntegrator::linear_solver() const {
  if (settings_.linear_solver != LinearSolverKind::automatic) return settings_.linear_solver;
  if (settings_.method == Method::adams) return LinearSolverKind::none;
  return equations_.node_count() <= max_nodes_direct ? LinearSolverKind::direct : LinearSolverKind::krylov;
}

void ReferenceIntegrator::check(int status) const {
  if (status < 0) throw sdk::Failure("cvode: " + context_.last_error());
}

// SUNDIALS 6 does not check whether vectors could be allocated (N_VClone), so allocate as many once beforehand.
void ReferenceIntegrator::require_memory() const {
  // 13 for the orders of Adams, weights, corrections, and those of the fixed-point solver.
  constexpr std::size_t vectors_of_cvode = 30;
  constexpr std::size_t vectors_of_krylov = 46;
  constexpr std::size_t vectors_of_a_sensitivity = 20;
  std::vector<Vector> vectors(vectors_of_cvode + vectors_of_a_sensitivity * sensitivities_.count() +
                              (linear_solver() == LinearSolverKind::krylov ? vectors_of_krylov : 0));
  const auto size = static_cast<sunindextype>(6 * equations_.node_count());
  for (Vector& vector : vectors) vector = make_vector(size, context_);
}

void ReferenceIntegrator::create(double time) {
  require_memory();
  Memory created(CVodeCreate(settings_.method == Method::bdf ? CV_BDF : CV_ADAMS, context_.get()));
  if (!created) throw std::bad_alloc();
  void* memory = created.get();
  context_.watch(memory);
  check(CVodeSetUserData(memory, &callbacks_));
  check(CVodeInit(memory, &right_side, time, y_.get()));
  check(CVodeWFtolerances(memory, &error_weights));
  switch (linear_solver()) {
    case LinearSolverKind::direct:
      attach_direct(memory, callbacks_, context_);
      break;
    case LinearSolverKind::krylov:
      attach_krylov(memory, y_.get(), callbacks_, context_);
      break;
    default:
      fixed_point_.reset(SUNNonlinSol_FixedPoint(y_.get(), 0, context_.get()));
      if (!fixed_point_) throw std::bad_alloc();
      check(CVodeSetNonlinearSolver(memory, fixed_point_.get()));
  }
  sensitivities_.attach(memory, linear_solver() == LinearSolverKind::none, context_);
  if (settings_.max_order > 0) check(CVodeSetMaxOrd(memory, settings_.max_order));
  if (settings_.max_step > 0.0) check(CVodeSetMaxStep(memory, settings_.max_step));
  check(CVodeSetMaxErrTestFails(memory, max_shortenings));
  // Suppress the only warnings of CVODE, which SUNDIALS 7 would print: steps below the rounding of the time, and events
  // that are 0 at the start.
  check(CVodeSetMaxHnilWarns(memory, -1));
  check(CVodeSetNoInactiveRootWarn(memory));
  memory_ = std::move(created);
}

void ReferenceIntegrator::restart(double time, const springnet_state& state, double stop) {
  const springnet_network& network = host_.network();
  const std::size_t n = network.node_count;
  require_differentiable(time);
  if (!y_) {
    for (Vector* vector : {&y_, &rate_, &probe_, &probe_rate_}) {
      *vector = make_vector(static_cast<sunindextype>(equations_.size()), context_);
    }
  }
  double* y = data(y_.get());
  for (const springnet_vectors& part : {state.position, state.velocity}) {
    for (const double* component : {part.x, part.y, part.z}) y = std::copy_n(component, n, y);
  }
  std::copy_n(state.internal, network.internal_count, y);

  const double relative = settings_.relative_tolerance;
  const double position = settings_.position_tolerance, velocity = settings_.velocity_tolerance;
  equations_.set_tolerances({relative, position > 0.0 ? position : relative * positive_or_one(network.length_scale),
                             velocity > 0.0 ? velocity : relative * positive_or_one(network.velocity_scale)});
  if (!memory_) {
    create(time);
  } else {
    total_ += counters();
    ++restarts_;
    check(CVodeReInit(memory_.get(), time, y_.get()));
    sensitivities_.restart(memory_.get());
  }
  bind(network);
  check(CVodeSetInitStep(memory_.get(), first_step(time, stop)));
  watch_events(time);
  impact_.reset();
  searched_until_ = restart_time_ = time;
  revision_ = network.revision;
  restart_ = false;
}

// Accelerations satisfy the constraints up to the integration error; the projection after each step removes it. CVODE
// has a projection for BDF only.
void ReferenceIntegrator::bind(const springnet_network& network) {
  // The stiffness of friction may change by orders of magnitude within a few steps. With the greater stiffness of an
  // earlier state, Newton's corrections would be so small that they seem converged.
  if (linear_solver() != LinearSolverKind::none) {
    const bool slides = equations_.slides();
    check(CVodeSetLSetupFrequency(memory_.get(), slides ? 1 : 0));
    check(CVodeSetJacEvalFrequency(memory_.get(), slides ? 1 : 0));
  }
  if (settings_.method != Method::bdf) {
    if (network.rigid_count > 0)
      throw sdk::Failure("cvode keeps rigid connections with method \"bdf\" only; set method = \"bdf\"");
    return;
  }
  const bool bound = equations_.bound();
  if (bound && !projects_) {
    check(CVodeSetProjFn(memory_.get(), &correction));
    // Test the error before the projection: the tolerances are meant for nodes, not for constraints.
    check(CVodeSetProjErrEst(memory_.get(), SUNFALSE));
    check(CVodeSetEpsProj(memory_.get(), 0.1));
    check(CVodeSetMaxNumProjFails(memory_.get(), max_projection_failures));
  }
  if (bound || projects_) check(CVodeSetProjFrequency(memory_.get(), bound ? 1 : 0));
  projects_ = projects_ || bound;
}

// First step: its second-order term h^2/2 y'' is a quarter of the tolerance. CVODE's own choice would depend on the
// time of the first output; outputs must not influence the solution.
double ReferenceIntegrator::first_step(double time, double stop) {
  const springnet_network& network = host_.network();
  const double longest = 0.1 * positive_or_one(network.length_scale) / positive_or_one(network.velocity_scale);
  N_Vector y = y_.get(), rate = rate_.get(), weights = probe_rate_.get();
  if (const int status = equations_.right_side(time, y, rate); status != 0) {
    fail(status > 0 ? CV_FIRST_RHSFUNC_ERR : CV_RHSFUNC_FAIL, time);
  }
  equations_.error_weights(y, weights);
  const double speed = N_VWrmsNorm(rate, weights);  // tolerances per second
  // y'' from the change of y' over a probe step that changes y by the tolerance.
  const double probe = std::min({longest, stop - time, 1.0 / speed});
  N_VLinearSum(1.0, y, probe, rate, probe_.get());
  if (equations_.right_side(time + probe, probe_.get(), probe_rate_.get()) != 0) return 0.01 * probe;
  N_VLinearSum(1.0, probe_rate_.get(), -1.0, rate, rate);
  equations_.error_weights(y, weights);
  const double curvature = N_VWrmsNorm(rate, weights) / probe;  // tolerances per second squared
  return std::min(longest, std::sqrt(0.5 / curvature));
}

void ReferenceIntegrator::watch_events(double time) {
  const std::uint32_t count = host_.network().event_count;
  std::vector<std::int32_t>& directions = equations_.event_directions();
  // Initialise anew each time: CVODE deactivates roots that were 0 at the start, but their indices may belong to other
  // events now.
  check(CVodeRootInit(memory_.get(), 0, nullptr));
  if (count > 0) check(CVodeRootInit(memory_.get(), static_cast<int>(count), &event_values));
  if (count != directions.size()) {
    directions.resize(count);
    event_values_.resize(count);
    fired_.resize(count);
  }
  if (count == 0) return;
  if (equations_.event_values(time, y_.get(), event_values_.data()) != 0) fail(CV_RTFUNC_FAIL, time);
  check(CVodeSetRootDirection(memory_.get(), directions.data()));
}

// The event function of a release is a force that rises through 0. If a switched load or a cut makes it jump past 0,
// CVODE would wait for a crossing in vain. (Gaps and rupture margins do not jump.)
bool ReferenceIntegrator::mark_past_events() noexcept {
  bool any = false;
  const std::vector<std::int32_t>& directions = equations_.event_directions();
  for (std::size_t i = 0; i < fired_.size(); ++i) {
    fired_[i] = directions[i] > 0 && event_values_[i] > 0.0 ? 1 : 0;
    any = any || fired_[i] != 0;
  }
  return any;
}

void ReferenceIntegrator::advance(double until, springnet_step_report& report) {
  const std::uint64_t evaluations_before = equations_.work().evaluations;
  steps_before_ = internal_steps();
  dense_from_ = host_.committed().time;
  dense_.begin(dense_from_);
  const auto fill_report = [&](std::int32_t outcome) {
    report.outcome = outcome;
    report.steps = static_cast<std::uint64_t>(internal_steps() - steps_before_);
    report.sweeps = equations_.work().evaluations - evaluations_before;
    report.force_difference = 0.0;
    report.residual = std::numeric_limits<double>::quiet_NaN();
    report.node = 0;
    report.start_node = std::numeric_limits<std::uint32_t>::max();
    report_statistics();
  };
  try {
    while (host_.committed().time < until) step_towards(until);
  } catch (const sdk::Failure& failure) {
    restart_ = true;  // CVODE's history is no longer valid
    forget_dense();
    fill_report(SPRINGNET_DIVERGING);
    if (failure.recoverable()) throw sdk::Failure(failure.what());
    throw;
  }
  fill_report(SPRINGNET_SETTLED);
}

// CVODE is created anew: CVodeReInit leaves estimates behind, such as the rate at which iterations converge.
void ReferenceIntegrator::forget() {
  if (memory_) total_ += counters();  // not a restart: a simulation that is restored here would count one less
  memory_.reset();
  callbacks_.newton.reset();
  fixed_point_.reset();
  projects_ = false;
  restart_ = true;
  equations_.event_directions().clear();
  event_values_.clear();
  fired_.clear();
  impact_.reset();
  forget_dense();
  events_at_once_ = 0;
  last_event_time_ = -std::numeric_limits<double>::infinity();
}

void ReferenceIntegrator::step_towards(double until) {
  const auto [time, committed] = host_.committed();
  const double stop = host_.next_discontinuity(time);
  const double target = std::min(until, stop);
  host_.begin_interval(time, stop);  // loads have no kink in between
  if (!state_) state_ = host_.make_state();

  if (same_time(time, target, shortest_step)) {
    copy(committed, *state_, host_.network());
    commit(target);
    restart_ = true;
    return;
  }
  if (restart_ || host_.network().revision != revision_) {
    restart(time, committed, stop);
    if (mark_past_events()) {
      copy(committed, *state_, host_.network());
      fire_events(time);
      return;
    }
  }

  // CVODE does not step past a stop time; an earlier output must not shorten a step.
  void* memory = memory_.get();
  check(CVodeSetStopTime(memory, std::min(stop, std::numeric_limits<double>::max())));
  context_.clear_error();
  equations_.clear_failure();

  bool event = false;
  const double reached = solve_until(target, event);
  springnet_state& state = *state_;
  unpack(data(y_.get()), state.position, state.velocity, host_.network().node_count);
  std::copy_n(data(y_.get()) + 6 * equations_.node_count(), equations_.internal_count(), state.internal);
  if (event) {
    fire_events(reached);
  } else {
    sensitivities_.keep(memory, target);
    commit(target);
    if (target == stop) restart_ = true;
  }
}

double ReferenceIntegrator::solve_until(double target, bool& event) {
  double reached = host_.committed().time;
  // In parts, to check that the time advances.
  for (long left = settings_.max_steps - (internal_steps() - steps_before_); left > 0; left -= steps_per_check) {
    const double before = reached;
    if (steps_reach(target, std::min(left, steps_per_check), reached, event)) return reached;
    const double rounding = std::numeric_limits<double>::epsilon() * std::max(std::abs(reached), std::abs(target));
    if (reached - before <= static_cast<double>(steps_per_check) * rounding) fail(creeping, reached);
  }
  fail(CV_TOO_MUCH_WORK, reached);
}

bool ReferenceIntegrator::steps_reach(double target, long max_steps, double& reached, bool& event) {
  void* memory = memory_.get();
  const bool searches = host_.network().surface_count > 0 || host_.network().body_contact_count > 0;
  // One step at a time if each is searched for impacts, or kept.
  const bool one_by_one = searches || settings_.dense_output;
  check(CVodeSetMaxNumSteps(memory, one_by_one ? 1 : max_steps));
  for (long done = 0; done < max_steps; done += one_by_one ? 1 : max_steps) {
    // After an output, search the rest of the last step first.
    if (searches) search_for_impact(target);
    const int flag = CVode(memory, impact_ ? std::min(target, *impact_) : target, y_.get(), &reached, CV_NORMAL);
    if (flag < 0 && flag != CV_TOO_MUCH_WORK) fail(flag, reached);
    // CVODE takes any time for reached if the product with the step is 0.
    double length = 0.0;
    check(CVodeGetCurrentStep(memory, &length));
    if (std::abs(length) < shortest_product) {
      check(CVodeGetCurrentTime(memory, &reached));
      fail(creeping, reached);
    }
    if (settings_.dense_output) dense_.add_step(memory, restart_time_, context_);
    if (searches) search_for_impact(target);
    // A root at the same time marks further events.
    const bool is_root = flag == CV_ROOT_RETURN && impact_ && same_time(*impact_, reached, root_accuracy);
    if (impact_ && *impact_ <= reached && !is_root) {
      reached = *impact_;
      return_to(reached);
      std::fill(fired_.begin(), fired_.end(), 0);
      event = true;
      return true;
    }
    if (flag == CV_ROOT_RETURN) {
      check(CVodeGetRootInfo(memory, fired_.data()));
      for (std::int32_t& fired : fired_) fired = fired != 0 ? 1 : 0;
      event = true;
    }
    if (flag != CV_TOO_MUCH_WORK) return true;
  }
  return false;
}

void ReferenceIntegrator::search_for_impact(double until) {
  double end = 0.0, length = 0.0;
  check(CVodeGetCurrentTime(memory_.get(), &end));
  check(CVodeGetLastStep(memory_.get(), &length));
  const sdk::Host::Span part{searched_until_, std::min(end, until)};
  if (impact_ || part.until <= part.from) return;
  searched_until_ = part.until;
  const std::size_t n = host_.network().node_count;
  const double depth = position_uncertainty * equations_.tolerances().position;
  const auto write = [&](double time, const springnet_vectors& position, const springnet_vectors& velocity) {
    check(CVodeGetDky(memory_.get(), time, 0, probe_.get()));
    unpack(data(probe_.get()), position, velocity, n);
  };
  impact_ = host_.time_of_impact({std::max(end - length, restart_time_), end}, part, depth, write);
}

void ReferenceIntegrator::return_to(double time) { check(CVodeGetDky(memory_.get(), time, 0, y_.get())); }

void ReferenceIntegrator::interpolate(double time, const springnet_vectors& position,
                                      const springnet_vectors& velocity) const {
  if (!settings_.dense_output) throw sdk::Failure("cvode keeps no states within a time step; set dense_output = true");
  const std::size_t n = host_.network().node_count;
  std::vector<double> y(6 * n);
  const bool is_within = time >= dense_from_ && time <= host_.committed().time;
  if (!is_within || !dense_.evaluate(time, y.size(), y.data()))
    throw sdk::Failure("no step that is kept includes that time");
  unpack(y.data(), position, velocity, n);
}

void ReferenceIntegrator::begin_sensitivities(std::span<const springnet_sensitivity* const> columns) {
  if (!columns.empty() && equations_.internal_count() > 0)
    throw sdk::Failure("cvode has no sensitivities of laws with internal states");
  if (!columns.empty() && host_.network().rigid_count > 0)
    throw sdk::Failure("cvode has no sensitivities of networks with rigid connections");
  forget();
  sensitivities_.begin(columns, context_);
}

// Contact makes the motion of a node depend on where the surface is, and sudden changes of velocities on when.
void ReferenceIntegrator::require_differentiable(double time) const {
  if (!sensitivities_.any()) return;
  const springnet_network& network = host_.network();
  for (std::size_t k = 0; network.surface_count > 0 && k < network.node_count; ++k)
    if (network.touching[k] != 0) refuse_event("contact", time);
  if (equations_.touches_bodies()) refuse_event("contact of bodies", time);
}

void ReferenceIntegrator::refuse_event(const char* what, double time) {
  std::ostringstream text;
  text.precision(9);
  text << "cvode has no sensitivities of a motion with " << what << ", which there is at " << time << " s";
  throw sdk::Failure(text.str());
}

// Carries out the events marked in fired_, on state_, and commits it.
void ReferenceIntegrator::fire_events(double time) {
  if (sensitivities_.any()) refuse_event("contact or ruptures", time);
  events_at_once_ = same_time(time, last_event_time_, root_accuracy) ? events_at_once_ + 1 : 0;
  last_event_time_ = time;
  if (events_at_once_ > max_events_at_once + fired_.size()) {
    std::ostringstream text;
    text.precision(9);
    text << "cvode stopped at t = " << time << " s: contacts, releases and ruptures repeat without end at this time. "
         << "Look at what holds and pulls the nodes in contact then";
    throw sdk::Failure(text.str());
  }
  host_.fire_events(time, *state_, fired_.data());
  commit(time);
  restart_ = true;
}

// Commits the state, with its net forces.
void ReferenceIntegrator::commit(double time) {
  equations_.evaluate_force(time, *state_);
  (*state_).force_is_current = 1;
  host_.commit(time, *state_);
}

void ReferenceIntegrator::fail(int flag, double time) const {
  FailureFacts facts{flag, time, 0.0, {}, context_.last_error()};
  CVodeGetLastStep(memory_.get(), &facts.last_step);
  if (const auto& failure = equations_.failure()) facts.reason = failure->what();
  throw sdk::Failure(failure_text(facts, settings_));
}

}  // namespace springnet::cvode
