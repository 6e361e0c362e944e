// The host's function table for integrators in C++: the same calls, with RAII for states and exceptions for failures.
// Shapes and units are those of plugin.h; node numbers are the engine's.
#pragma once

#include <atomic>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <springnet/sdk/plugin.h>

namespace springnet::sdk {

// A failed call of the host, or a failure of the integrator; the glue turns it into `status` and the host's message.
class Failure : public std::runtime_error {
 public:
  explicit Failure(const std::string& message, springnet_status status = SPRINGNET_FAILED)
      : std::runtime_error(message), status_(status) {}
  [[nodiscard]] springnet_status status() const noexcept { return status_; }
  // No finite result at this state; a smaller step may succeed.
  [[nodiscard]] bool recoverable() const noexcept { return status_ == SPRINGNET_RECOVERABLE; }

 private:
  springnet_status status_;
};

// A struct of the ABI with all fields zero and its size set: auto sweep = sized<springnet_sweep>();
template <class Struct>
[[nodiscard]] constexpr Struct sized() noexcept {
  Struct result{};
  result.struct_size = sizeof(Struct);
  return result;
}

[[nodiscard]] constexpr springnet_const_vectors view(const springnet_vectors& v) noexcept { return {v.x, v.y, v.z}; }

// An evaluation that reads `state` and has no outputs yet; the internal state of laws is that committed.
[[nodiscard]] inline springnet_evaluation evaluation_at(double time, const springnet_state& state) noexcept {
  auto evaluation = sized<springnet_evaluation>();
  evaluation.time = time;
  evaluation.position = view(state.position);
  evaluation.velocity = view(state.velocity);
  return evaluation;
}

struct StateDeleter {
  const springnet_host* host = nullptr;
  void operator()(springnet_state* state) const noexcept { host->destroy_state(host->context, state); }
};
// Owns the state of all nodes, in the host's memory. The pointers inside it change when it is committed.
using State = std::unique_ptr<springnet_state, StateDeleter>;

struct Committed {
  double time;  // s
  const springnet_state& state;
};

struct DominantOptions {
  std::uint32_t wanted = SPRINGNET_LARGEST_MAGNITUDE;
  double tolerance = 1e-4;            // of the residual, relative to the eigenvalue
  std::uint64_t applications = 1000;  // of the map, about
  std::uint32_t vectors = 40;         // kept at a time
};
struct Dominant {
  std::complex<double> value;           // infinity where an image was not finite
  double error = 0.0;                   // norm of the residual
  std::uint64_t applications = 0;       // used
  std::vector<double> real, imaginary;  // the eigenvector, norm 1
};

// A view of the table, cheap to copy, valid for the life of the integrator. Functions throw Failure with the host's
// message and status; see Failure::recoverable().
class Host {
 public:
  explicit Host(const springnet_host& table) noexcept : table_(&table) {}

  [[nodiscard]] const springnet_host& table() const noexcept { return *table_; }
  // Masses, held nodes, scales; valid until `revision` changes.
  [[nodiscard]] const springnet_network& network() const { return query_network(false); }
  // The same with the lists of neighbours, which a large net takes long to build.
  [[nodiscard]] const springnet_network& network_with_neighbours() const { return query_network(true); }

  // Throws std::bad_alloc.
  [[nodiscard]] State make_state() const {
    auto creation = sized<springnet_state_creation>();
    if (table_->create_state(table_->context, &creation) != SPRINGNET_OK || creation.state == nullptr)
      throw std::bad_alloc();
    return State(creation.state, StateDeleter{table_});
  }
  [[nodiscard]] Committed committed() const {
    auto request = sized<springnet_committed>();
    check(table_->committed(table_->context, &request));
    return {request.time, *request.state};
  }

  // Loads are averaged over [from, until], s.
  void begin_step(double from, double until) const { begin(from, until, 0); }
  // Evaluations in [from, until] have the loads of their time, s.
  void begin_interval(double from, double until) const { begin(from, until, 1); }
  // The network's `load_revision`, up to date.
  [[nodiscard]] std::uint64_t load_revision() const { return network().load_revision; }
  // Of all nodes, or of evaluation.nodes each by itself.
  void evaluate(const springnet_evaluation& evaluation) const { check(table_->evaluate(table_->context, &evaluation)); }
  void evaluate_nodes(springnet_evaluation evaluation, std::span<const std::uint32_t> nodes) const {
    static constexpr std::uint32_t none = 0;
    evaluation.nodes = nodes.empty() ? &none : nodes.data();
    evaluation.node_count = static_cast<std::uint32_t>(nodes.size());
    evaluate(evaluation);
  }
  // One sweep. `update(const springnet_node_batch&)` replaces sweep.update and sweep.user; unless the sweep has an
  // order, it is called from several threads with different units. With sweep.lists it is given lists of nodes as well,
  // see list_of(). An exception from it is rethrown after the sweep.
  template <class Update>
  void sweep(springnet_sweep sweep, Update&& update) const {
    run_sweep(table_->sweep, sweep, update);
  }

  // Computes the derivatives of the accelerations at a state, for the functions below; elimination: see plugin.h.
  void linearise(const springnet_evaluation& at, double elimination = 0.0) const {
    auto request = sized<springnet_linearisation>();
    request.at = &at;
    request.elimination = elimination;
    check(table_->linearise(table_->context, &request));
  }
  // out = da/dp dp + da/dv dv; 3 node_count numbers each, x of all nodes, then y, then z. kind: 0, or
  // SPRINGNET_TRUE_FRICTION.
  void jacobian_times(const double* dp, const double* dv, double* out, std::uint32_t kind = 0) const {
    auto request = sized<springnet_jacobian_product>();
    request.kind = kind;
    request.dp = dp;
    request.dv = dv;
    request.out = out;
    check(table_->jacobian_times(table_->context, &request));
  }
  // by_position = (da/dp)^T weights, by_velocity = (da/dv)^T weights; arrays and kinds as above.
  void jacobian_transposed_times(const double* weights, double* by_position, double* by_velocity,
                                 std::uint32_t kind = 0) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, jacobian_transposed_times), "jacobian_transposed_times");
    auto request = sized<springnet_transposed_product>();
    request.kind = kind;
    request.weights = weights;
    request.by_position = by_position;
    request.by_velocity = by_velocity;
    check(table_->jacobian_transposed_times(table_->context, &request));
  }
  // Change of the eliminated internal state, see springnet_internal_change; both outputs may be null.
  void change_internal(const double* right_side, const double* dp, const double* dv, double* change,
                       double* acceleration) const {
    auto request = sized<springnet_internal_change>();
    request.right_side = right_side;
    request.dp = dp;
    request.dv = dv;
    request.change = change;
    request.acceleration = acceleration;
    check(table_->change_internal(table_->context, &request));
  }
  // Diagonal blocks of A = I - velocity_weight da/dv - position_weight da/dp: out[node][3][3].
  void diagonal_blocks(double velocity_weight, double position_weight, double* out) const {
    auto request = sized<springnet_diagonal_blocks>();
    request.velocity_weight = velocity_weight;
    request.position_weight = position_weight;
    request.out = out;
    check(table_->diagonal_blocks(table_->context, &request));
  }
  void factorise(double velocity_weight, double position_weight) const {
    auto request = sized<springnet_factorisation>();
    request.velocity_weight = velocity_weight;
    request.position_weight = position_weight;
    check(table_->factorise(table_->context, &request));
  }
  // A x = right_side, or A^T x = right_side, with the matrix factorised last; x may be right_side.
  void solve(const double* right_side, double* x) const { solve(right_side, x, 0); }
  void solve_transposed(const double* right_side, double* x) const { solve(right_side, x, 1); }

  // What forces and accelerations are differentiated by; see springnet_parameter_set.
  struct ParameterSet {
    std::uint32_t kind;  // SPRINGNET_BY_REFERENCE ...
    std::span<double> values;
    const char* parameter = nullptr;  // its name
    const char* component = nullptr;  // id of the law or neuron; null: any
    bool of_elements = false;
    std::uint32_t input = 0;
  };
  // Arrays of a product by parameters, see springnet_parameter_product; null: not wanted.
  struct ParameterArrays {
    double* force = nullptr;
    double* acceleration = nullptr;
    double* internal = nullptr;
  };
  // out = d(out)/d(values) values, summed over the sets.
  void parameter_tangent(const springnet_evaluation& at, std::span<const ParameterSet> sets,
                         const ParameterArrays& out) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, parameter_tangent), "parameter_tangent");
    parameter_product(table_->parameter_tangent, at, sets, out);
  }
  // The same with sets that the host gave, as those of springnet_sensitivity.
  void parameter_tangent(const springnet_evaluation& at, std::span<const springnet_parameter_set* const> sets,
                         const ParameterArrays& out) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, parameter_tangent), "parameter_tangent");
    parameter_product(table_->parameter_tangent, at, sets, out);
  }
  // values += (d(weighted)/d(values))^T weights; the weights are only read.
  void parameter_cotangent(const springnet_evaluation& at, std::span<const ParameterSet> sets,
                           const ParameterArrays& weights) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, parameter_cotangent), "parameter_cotangent");
    parameter_product(table_->parameter_cotangent, at, sets, weights);
  }
  // Of the value of an event: of a gap or of a margin of rupture. Arrays have 3 node_count numbers; null: not wanted.
  // Adds derivatives by parameters to the values of sets; returns that by time.
  double event_derivative(const springnet_evaluation& at, std::uint32_t event, double* by_position, double* by_velocity,
                          std::span<const ParameterSet> sets = {}) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, event_derivative), "event_derivative");
    const Sets list(*this, sets);
    auto request = sized<springnet_event_derivative>();
    request.event = event;
    request.at = &at;
    request.by_position = by_position;
    request.by_velocity = by_velocity;
    request.sets = list.pointers.data();
    request.set_count = static_cast<std::uint32_t>(list.pointers.size());
    check(table_->event_derivative(table_->context, &request));
    return request.by_time;
  }

  // `values` and `directions` (null: not wanted) have network().event_count entries.
  void event_values(const springnet_evaluation& at, double* values, std::int32_t* directions) const {
    auto request = sized<springnet_event_values>();
    request.at = &at;
    request.values = values;
    request.directions = directions;
    check(table_->event_values(table_->context, &request));
  }
  // The same with what each event is and whose: kinds, nodes (or springs, elements), surfaces. Needs ABI 2.1 of the
  // host.
  struct EventNames {
    std::uint32_t *kinds, *who, *surfaces;  // [event_count]; null: not wanted
  };
  void event_values(const springnet_evaluation& at, double* values, std::int32_t* directions,
                    const EventNames& names) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, part_forces), "event names");
    auto request = sized<springnet_event_values>();
    request.at = &at;
    request.values = values;
    request.directions = directions;
    request.kinds = names.kinds;
    request.who = names.who;
    request.surfaces = names.surfaces;
    check(table_->event_values(table_->context, &request));
  }
  void fire_events(double time, springnet_state& state, const std::int32_t* fired) const {
    auto request = sized<springnet_event_firing>();
    request.time = time;
    request.state = &state;
    request.fired = fired;
    check(table_->fire_events(table_->context, &request));
  }
  struct Span {
    double from, until;  // s
  };
  // Time, s, at which a node first touches a surface in a part of a step, even if it has left again by the end; empty
  // if none does. `depth`: m; see plugin.h. `state_at(time, position, velocity)`
  // writes the state at a time of the step into springnet_vectors; an exception from it is rethrown.
  template <class StateAt>
  [[nodiscard]] std::optional<double> time_of_impact(Span step, Span part, double depth, StateAt&& state_at) const {
    using Callable = std::remove_reference_t<StateAt>;
    struct Call {
      Callable& state_at;
      std::exception_ptr error{};
    } call{state_at};
    auto search = sized<springnet_impact_search>();
    search.step_from = step.from;
    search.step_until = step.until;
    search.from = part.from;
    search.until = part.until;
    search.depth = depth;
    search.user = &call;
    search.state_at = [](void* user, const springnet_dense_output* output) -> springnet_status {
      auto& self = *static_cast<Call*>(user);
      try {
        self.state_at(output->time, output->position, output->velocity);
        return SPRINGNET_OK;
      } catch (...) {
        self.error = std::current_exception();
        return SPRINGNET_FAILED;
      }
    };
    const springnet_status status = table_->time_of_impact(table_->context, &search);
    if (call.error) std::rethrow_exception(call.error);
    check(status);
    return std::isnan(search.time) ? std::nullopt : std::optional(search.time);
  }
  // Time of the next load switch, change of an input or cut, s; infinity if there is none.
  [[nodiscard]] double next_discontinuity(double time) const noexcept {
    auto request = sized<springnet_discontinuity>();
    request.after = time;
    request.time = std::numeric_limits<double>::infinity();
    static_cast<void>(table_->next_discontinuity(table_->context, &request));
    return request.time;
  }

  // `state` and the committed state exchange their memory.
  void commit(double time, springnet_state& state) const {
    auto request = sized<springnet_commitment>();
    request.time = time;
    request.state = &state;
    check(table_->commit(table_->context, &request));
  }

  // The end of a sweep by itself; see plugin.h.
  void constrain(const springnet_sweep& sweep) const { check(table_->constrain(table_->context, &sweep)); }
  // values -= W G^T (G W G^T)^-1 G values; mobility: [node_count][3][3] 1/kg, or null: the neurons' own.
  // kind: 0, or SPRINGNET_TRANSPOSED, SPRINGNET_TRUE_FRICTION or both (then with a null mobility).
  void project(const double* mobility, double* values, std::uint32_t kind = 0) const {
    auto request = sized<springnet_projection>();
    request.kind = kind;
    request.mobility = mobility;
    request.values = values;
    check(table_->project(table_->context, &request));
  }
  // Projects positions and velocities of `state` onto the constraints at `time` (s).
  void project_state(double time, springnet_state& state) const { project_state(time, state.position, state.velocity); }
  void project_state(double time, const springnet_vectors& position, const springnet_vectors& velocity) const {
    auto request = sized<springnet_state_projection>();
    request.time = time;
    request.position = position;
    request.velocity = velocity;
    check(table_->project_state(table_->context, &request));
  }
  // A note to the user; the same text is noted once. With a topic: the first note on it, as of a text with numbers.
  void note(const std::string& text, const char* topic = nullptr) const noexcept {
    auto request = sized<springnet_user_note>();
    request.text = text.c_str();
    request.topic = topic;
    static_cast<void>(table_->note(table_->context, &request));
  }

  // A sweep of the network linearised last, with an order; see plugin.h. `update` as in sweep().
  template <class Update>
  void linear_sweep(springnet_sweep sweep, Update&& update) const {
    run_sweep(table_->linear_sweep, sweep, update);
  }
  // The dominant eigenvalue of a linear map. `map(double* x)` replaces x ([start.size()]) by its image; an exception
  // from it is rethrown. `start` is the first vector of the search, and is replaced by a good one for a similar map. If
  // it is empty, the eigenvalue is 0.
  template <class Map>
  [[nodiscard]] Dominant dominant_eigenvalue(std::vector<double>& start, const DominantOptions& options,
                                             Map&& map) const {
    using Callable = std::remove_reference_t<Map>;
    struct Call {
      Callable& map;
      std::exception_ptr error{};
    } call{map};
    Dominant result;
    result.real.resize(start.size());
    result.imaginary.resize(start.size());
    if (start.empty()) return result;
    auto search = sized<springnet_eigenvalue_search>();
    search.wanted = options.wanted;
    search.size = start.size();
    search.user = &call;
    search.map = [](void* user, const springnet_linear_image* image) -> springnet_status {
      auto& self = *static_cast<Call*>(user);
      try {
        self.map(image->x);
        return SPRINGNET_OK;
      } catch (...) {
        self.error = std::current_exception();
        return SPRINGNET_FAILED;
      }
    };
    search.start = start.data();
    search.tolerance = options.tolerance;
    search.most_applications = options.applications;
    search.most_vectors = options.vectors;
    search.mode_real = result.real.data();
    search.mode_imaginary = result.imaginary.data();
    const springnet_status status = table_->dominant_eigenvalue(table_->context, &search);
    if (call.error) std::rethrow_exception(call.error);
    check(status);
    result.value = {search.real, search.imaginary};
    result.error = search.error;
    result.applications = search.applications;
    return result;
  }

  struct SystemWeights {
    double velocity;     // s
    double position;     // s^2
    double shift = 0.0;  // 1
  };
  // Prepares A = (1 + shift) I - velocity da/dv - position da/dp at a state; see plugin.h. Unless `exact`, the host may
  // leave out small parts of it.
  void prepare_system(const SystemWeights& weights, const springnet_evaluation& at, bool exact = true) const {
    prepare_system(weights, &at, exact);
  }
  // The same with the derivatives of the last linearise().
  void prepare_system(const SystemWeights& weights) const { prepare_system(weights, nullptr, true); }
  struct Solved {
    std::uint32_t outcome;     // SPRINGNET_SOLVED ...
    double residual;           // relative
    std::uint64_t iterations;  // of Krylov's method
  };
  // Solves A x = right_side among the changes that the constraints allow.
  Solved solve_system(const double* right_side, double accuracy, double* x) const {
    auto solve = sized<springnet_linear_solve>();
    solve.right_side = right_side;
    solve.x = x;
    solve.accuracy = accuracy;
    check(table_->solve_system(table_->context, &solve));
    return {solve.outcome, solve.residual, solve.iterations};
  }

  // Wall time left for this advance(), s: infinity without a deadline; below 0 after it.
  [[nodiscard]] double time_left() const noexcept {
    auto request = sized<springnet_deadline>();
    request.time_left = std::numeric_limits<double>::infinity();
    static_cast<void>(table_->deadline(table_->context, &request));
    return request.time_left;
  }

  // ---- from ABI 2.1 of the host on; with an older host they throw Failure

  // Forces of some parts, SPRINGNET_PART_SPRINGS | …, on all nodes, N.
  void part_forces(const springnet_evaluation& at, std::uint32_t parts, const springnet_vectors& force) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, part_forces), "part_forces");
    auto request = sized<springnet_part_forces>();
    request.at = &at;
    request.parts = parts;
    request.force = force;
    check(table_->part_forces(table_->context, &request));
  }
  // Springs or elements one by one; see springnet_element_view. `view.at` and the arrays that are wanted are set.
  void view_elements(springnet_element_view& view) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, view_elements), "view_elements");
    view.struct_size = sizeof view;
    check(table_->view_elements(table_->context, &view));
  }
  // An element whose laws read several scalars.
  [[nodiscard]] springnet_scalar_view view_scalars(const springnet_evaluation& at, std::uint32_t element) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, view_scalars), "view_scalars");
    auto view = sized<springnet_scalar_view>();
    view.at = &at;
    view.element = element;
    check(table_->view_scalars(table_->context, &view));
    view.at = nullptr;
    return view;
  }
  [[nodiscard]] springnet_balance balance(const springnet_evaluation& at) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, balance), "balance");
    auto request = sized<springnet_balance>();
    request.at = &at;
    check(table_->balance(table_->context, &request));
    request.at = nullptr;
    return request;
  }
  // body(begin, end) for parts of 0 … count - 1, in several threads; `part`: things in a part. An exception from it is
  // rethrown, the one of the first part that threw.
  template <class Body>
  void parallel_for(std::uint64_t count, Body&& body, std::uint64_t part = 0) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, parallel_for), "parallel_for");
    struct Call {
      std::remove_reference_t<Body>& body;
      std::mutex caught{};
      std::uint64_t where = 0;
      std::exception_ptr error{};
    } call{body};
    auto loop = sized<springnet_loop>();
    loop.count = count;
    loop.part = part;
    loop.user = &call;
    loop.body = [](void* user, std::uint64_t begin, std::uint64_t end) -> springnet_status {
      auto& self = *static_cast<Call*>(user);
      try {
        self.body(begin, end);
        return SPRINGNET_OK;
      } catch (...) {
        const std::lock_guard<std::mutex> lock(self.caught);
        if (!self.error || begin < self.where) {
          self.error = std::current_exception();
          self.where = begin;
        }
        return SPRINGNET_FAILED;
      }
    };
    const springnet_status status = table_->parallel_for(table_->context, &loop);
    if (call.error) std::rethrow_exception(call.error);
    check(status);
  }
  // The prepared system by rows.
  [[nodiscard]] springnet_system_rows system_rows() const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, system_rows), "system_rows");
    auto rows = sized<springnet_system_rows>();
    check(table_->system_rows(table_->context, &rows));
    return rows;
  }
  // SPRINGNET_GO_ON, or why the step should end early.
  [[nodiscard]] std::uint32_t stop_reason() const noexcept {
    auto request = sized<springnet_stop>();
    if (SPRINGNET_HAS_FIELD(springnet_host, table_, stop)) static_cast<void>(table_->stop(table_->context, &request));
    return request.reason;
  }

  // Reports a number for the summary, under `name`; the last value counts.
  void report(const char* name, double value) const noexcept { report(name, value, false); }
  // Adds to a number of the summary, which saved states keep.
  void count(const char* name, double more = 1.0) const noexcept { report(name, more, true); }

 private:
  void report(const char* name, double value, bool adds) const noexcept {
    auto request = sized<springnet_number_report>();
    request.name = name;
    request.value = value;
    request.adds = adds ? 1 : 0;
    static_cast<void>(table_->report(table_->context, &request));
  }
  // A function that came with ABI 2.1.
  // How many numbers a set has.
  [[nodiscard]] std::uint64_t size_of(const ParameterSet& set) const {
    const springnet_network& all = network();
    if (set.kind == SPRINGNET_BY_INPUT || set.kind == SPRINGNET_BY_TIME) return 1;
    if (set.kind == SPRINGNET_BY_MASS || set.kind == SPRINGNET_BY_NEURON_PARAMETER) return all.node_count;
    return set.of_elements ? all.element_number_count : all.spring_number_count;
  }
  struct Sets {
    Sets(const Host& host, std::span<const ParameterSet> sets) {
      for (const ParameterSet& each : sets) {
        if (each.values.size() != host.size_of(each))
          throw Failure("parameter set " + std::to_string(values.size()) + " has " +
                        std::to_string(each.values.size()) + " numbers, must have " +
                        std::to_string(host.size_of(each)));
        auto set = sized<springnet_parameter_set>();
        set.kind = each.kind;
        set.of_elements = each.of_elements ? 1 : 0;
        set.input = each.input;
        set.component = each.component;
        set.parameter = each.parameter;
        set.values = each.values.data();
        values.push_back(set);
      }
      for (const springnet_parameter_set& set : values) pointers.push_back(&set);
    }
    std::vector<springnet_parameter_set> values;
    std::vector<const springnet_parameter_set*> pointers;
  };
  void parameter_product(springnet_status (*function)(void*, const springnet_parameter_product*),
                         const springnet_evaluation& at, std::span<const ParameterSet> sets,
                         const ParameterArrays& arrays) const {
    const Sets list(*this, sets);
    parameter_product(function, at, std::span<const springnet_parameter_set* const>(list.pointers), arrays);
  }
  void parameter_product(springnet_status (*function)(void*, const springnet_parameter_product*),
                         const springnet_evaluation& at, std::span<const springnet_parameter_set* const> sets,
                         const ParameterArrays& arrays) const {
    auto request = sized<springnet_parameter_product>();
    request.set_count = static_cast<std::uint32_t>(sets.size());
    request.at = &at;
    request.sets = sets.data();
    request.force = arrays.force;
    request.acceleration = arrays.acceleration;
    request.internal = arrays.internal;
    check(function(table_->context, &request));
  }
  [[nodiscard]] const springnet_network& query_network(bool with_neighbours) const {
    auto query = sized<springnet_network_query>();
    query.with_neighbours = with_neighbours ? 1 : 0;
    check(table_->network(table_->context, &query));
    return *query.network;
  }
  void begin(double from, double until, std::uint32_t own_steps) const {
    auto interval = sized<springnet_interval>();
    interval.own_steps = own_steps;
    interval.from = from;
    interval.until = until;
    check(table_->begin(table_->context, &interval));
  }
  void solve(const double* right_side, double* x, std::uint32_t transposed) const {
    auto request = sized<springnet_solve>();
    request.transposed = transposed;
    request.right_side = right_side;
    request.x = x;
    check(table_->solve(table_->context, &request));
  }
  void prepare_system(const SystemWeights& weights, const springnet_evaluation* at, bool exact) const {
    auto system = sized<springnet_linear_system>();
    system.exact = exact ? 1 : 0;
    system.velocity_weight = weights.velocity;
    system.position_weight = weights.position;
    system.shift = weights.shift;
    system.at = at;
    check(table_->prepare_system(table_->context, &system));
  }
  template <class Update>
  void run_sweep(springnet_status (*function)(void*, const springnet_sweep*), springnet_sweep sweep,
                 Update& update) const {
    struct Call {
      Update& update;
      std::atomic_flag caught{};
      std::exception_ptr error{};
    } call{update};
    sweep.user = &call;
    sweep.update = [](void* user, const springnet_node_batch* batch) -> springnet_status {
      auto& self = *static_cast<Call*>(user);
      try {
        self.update(*batch);
        return SPRINGNET_OK;
      } catch (...) {
        if (!self.caught.test_and_set()) self.error = std::current_exception();
        return SPRINGNET_FAILED;
      }
    };
    const springnet_status status = function(table_->context, &sweep);
    if (call.error) std::rethrow_exception(call.error);
    check(status);
  }
  static void require(bool has, const char* what) {
    if (!has) throw Failure(std::string("the host is older than ABI 2.1 and has no ") + what + "; update it");
  }
  void check(springnet_status status) const {
    if (status == SPRINGNET_OK) return;
    const springnet_message* message = table_->message;
    throw Failure(message == nullptr || message->text[0] == '\0' ? "the host gave no reason" : message->text, status);
  }

  const springnet_host* table_;
};

}  // namespace springnet::sdk
