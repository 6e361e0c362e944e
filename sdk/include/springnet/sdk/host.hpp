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

// An evaluation that reads `state` and has no outputs yet.
[[nodiscard]] inline springnet_evaluation evaluation_at(double time, const springnet_state& state) noexcept {
  auto evaluation = sized<springnet_evaluation>();
  evaluation.time = time;
  evaluation.position = view(state.position);
  evaluation.velocity = view(state.velocity);
  evaluation.internal = state.internal;
  return evaluation;
}

struct StateDeleter {
  const springnet_host* host = nullptr;
  void operator()(springnet_state* state) const noexcept { host->state_destroy(host->context, state); }
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

// The nodes of a batch that is a list, [count]; null for a range.
[[nodiscard]] inline const std::uint32_t* list_of(const springnet_node_batch& batch) noexcept {
  return SPRINGNET_HAS_FIELD(springnet_node_batch, &batch, nodes) ? batch.nodes : nullptr;
}

// The instruction set that the host chose for kernels: of detail::run().
[[nodiscard]] inline std::uint32_t instruction_set_of(const springnet_node_batch& batch) noexcept {
  return SPRINGNET_HAS_FIELD(springnet_node_batch, &batch, instruction_set) ? batch.instruction_set
                                                                            : std::uint32_t{SPRINGNET_GENERIC};
}

// A view of the table, cheap to copy, valid for the life of the integrator. Functions throw Failure with the host's
// message and status; see Failure::recoverable().
class Host {
 public:
  explicit Host(const springnet_host& table) noexcept : table_(&table) {}

  [[nodiscard]] const springnet_host& table() const noexcept { return *table_; }
  // Masses, held nodes, scales; valid until `revision` changes.
  [[nodiscard]] const springnet_network& network() const { return checked(table_->network(table_->context)); }
  // The same with the lists of neighbours, which a large net takes long to build.
  [[nodiscard]] const springnet_network& network_with_neighbours() const {
    if (!SPRINGNET_HAS_FIELD(springnet_host, table_, network_with_neighbours)) return network();
    return checked(table_->network_with_neighbours(table_->context));
  }

  // Throws std::bad_alloc.
  [[nodiscard]] State make_state() const {
    springnet_state* state = table_->state_create(table_->context);
    if (state == nullptr) throw std::bad_alloc();
    return State(state, StateDeleter{table_});
  }
  [[nodiscard]] Committed committed() const {
    double time = 0.0;
    const springnet_state* state = table_->committed(table_->context, &time);
    if (state == nullptr) check(SPRINGNET_FAILED);
    return {time, *state};
  }

  // Loads are averaged over [from, until], s.
  void begin_step(double from, double until) const { check(table_->begin_step(table_->context, from, until)); }
  // Evaluations in [from, until] have the loads of their time, s. A host before ABI 1.2 averages them.
  void begin_interval(double from, double until) const {
    if (SPRINGNET_HAS_FIELD(springnet_host, table_, begin_interval))
      check(table_->begin_interval(table_->context, from, until));
    else
      begin_step(from, until);
  }
  // The network's `load_revision`; 0 for an older host, whose loads change only with `revision`.
  [[nodiscard]] std::uint64_t load_revision() const {
    const springnet_network& known = network();
    return SPRINGNET_HAS_FIELD(springnet_network, &known, load_revision) ? known.load_revision : 0;
  }
  void evaluate(const springnet_evaluation& evaluation) const { check(table_->evaluate(table_->context, &evaluation)); }
  void evaluate_nodes(const springnet_evaluation& evaluation, std::span<const std::uint32_t> nodes) const {
    check(table_->evaluate_nodes(table_->context, &evaluation, nodes.data(), static_cast<std::uint32_t>(nodes.size())));
  }
  // One sweep. `update(const springnet_node_batch&)` replaces sweep.update and sweep.user; unless the sweep has an
  // order, it is called from several threads with different units. With sweep.lists it is given lists of nodes as well,
  // see list_of(). An exception from it is rethrown after the sweep.
  template <class Update>
  void sweep(springnet_sweep sweep, Update&& update) const {
    run_sweep(table_->sweep, sweep, update);
  }

  // Computes the derivatives of the accelerations at a state, for the functions below.
  void linearise(const springnet_evaluation& at) const { check(table_->linearise(table_->context, &at)); }
  // out = da/dp dp + da/dv dv; 3 node_count numbers each, x of all nodes, then y, then z.
  void jacobian_times(const double* dp, const double* dv, double* out) const {
    check(table_->jacobian_times(table_->context, dp, dv, out));
  }
  // Diagonal blocks of A = I - velocity_weight da/dv - position_weight da/dp: out[node][3][3].
  void diagonal_blocks(double velocity_weight, double position_weight, double* out) const {
    check(table_->diagonal_blocks(table_->context, velocity_weight, position_weight, out));
  }
  void factorise(double velocity_weight, double position_weight) const {
    check(table_->factorise(table_->context, velocity_weight, position_weight));
  }
  // A x = right_side, or A^T x = right_side, with the matrix factorised last; x may be right_side.
  void solve(const double* right_side, double* x) const { check(table_->solve(table_->context, 0, right_side, x)); }
  void solve_transposed(const double* right_side, double* x) const {
    check(table_->solve(table_->context, 1, right_side, x));
  }

  // `values` and `directions` (null: not wanted) have network().event_count entries.
  void event_values(const springnet_evaluation& at, double* values, std::int32_t* directions) const {
    check(table_->event_values(table_->context, &at, values, directions));
  }
  void fire_events(double time, springnet_state& state, const std::int32_t* fired) const {
    check(table_->fire_events(table_->context, time, &state, fired));
  }
  struct Span {
    double from, until;  // s
  };
  // Time, s, at which a node first touches a surface in a part of a step, even if it has left again by the end; empty
  // if none does, or the host is older than ABI 1.3. `depth`: m; see plugin.h. `state_at(time, position, velocity)`
  // writes the state at a time of the step into springnet_vectors; an exception from it is rethrown.
  template <class StateAt>
  [[nodiscard]] std::optional<double> time_of_impact(Span step, Span part, double depth, StateAt&& state_at) const {
    if (!SPRINGNET_HAS_FIELD(springnet_host, table_, time_of_impact)) return std::nullopt;
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
    search.state_at = [](void* user, double time, springnet_vectors position,
                         springnet_vectors velocity) -> springnet_status {
      auto& self = *static_cast<Call*>(user);
      try {
        self.state_at(time, position, velocity);
        return SPRINGNET_OK;
      } catch (...) {
        self.error = std::current_exception();
        return SPRINGNET_FAILED;
      }
    };
    double time = 0.0;
    const springnet_status status = table_->time_of_impact(table_->context, &search, &time);
    if (call.error) std::rethrow_exception(call.error);
    check(status);
    return std::isnan(time) ? std::nullopt : std::optional(time);
  }
  // Time of the next load switch or cut, s; infinity if there is none.
  [[nodiscard]] double next_discontinuity(double time) const noexcept {
    return table_->next_discontinuity(table_->context, time);
  }

  // `state` and the committed state exchange their memory.
  void commit(double time, springnet_state& state) const { check(table_->commit(table_->context, time, &state)); }

  // Functions of ABI 1.1; they throw Failure if the host is older.
  // The end of a sweep by itself; see plugin.h.
  void constrain(const springnet_sweep& sweep) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, constrain));
    check(table_->constrain(table_->context, &sweep));
  }
  // values -= W G^T (G W G^T)^-1 G values; mobility: [node_count][3][3] 1/kg, or null: the neurons' own.
  void project(const double* mobility, double* values) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, project));
    check(table_->project(table_->context, mobility, values));
  }
  // Projects positions and velocities of `state` onto the constraints at `time` (s).
  void project_state(double time, springnet_state& state) const { project_state(time, state.position, state.velocity); }
  void project_state(double time, const springnet_vectors& position, const springnet_vectors& velocity) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, project_state));
    check(table_->project_state(table_->context, time, position, velocity));
  }
  // A note to the user, once. No effect if the host is older.
  void note(const std::string& text) const noexcept {
    if (SPRINGNET_HAS_FIELD(springnet_host, table_, note)) table_->note(table_->context, text.c_str());
  }

  // Functions of ABI 1.4; they throw Failure if the host is older.
  // A sweep of the network linearised last, with an order; see plugin.h. `update` as in sweep().
  template <class Update>
  void linear_sweep(springnet_sweep sweep, Update&& update) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, linear_sweep), "1.4");
    run_sweep(table_->linear_sweep, sweep, update);
  }
  // The dominant eigenvalue of a linear map. `map(double* x)` replaces x ([start.size()]) by its image; an exception
  // from it is rethrown. `start` is the first vector of the search, and is replaced by a good one for a similar map. If
  // it is empty, the eigenvalue is 0.
  template <class Map>
  [[nodiscard]] Dominant dominant_eigenvalue(std::vector<double>& start, const DominantOptions& options,
                                             Map&& map) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, dominant_eigenvalue), "1.4");
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
    search.map = [](void* user, double* x) -> springnet_status {
      auto& self = *static_cast<Call*>(user);
      try {
        self.map(x);
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

  // Functions of ABI 1.5; they throw Failure if the host is older.
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
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, solve_system), "1.5");
    auto solve = sized<springnet_linear_solve>();
    solve.right_side = right_side;
    solve.x = x;
    solve.accuracy = accuracy;
    check(table_->solve_system(table_->context, &solve));
    return {solve.outcome, solve.residual, solve.iterations};
  }

  // Wall time left for this advance(), s: infinity without a deadline, and with an older host; below 0 after it.
  [[nodiscard]] double time_left() const noexcept {
    if (!SPRINGNET_HAS_FIELD(springnet_host, table_, time_left)) return std::numeric_limits<double>::infinity();
    return table_->time_left(table_->context);
  }

  // Reports a number for the summary, under `name`.
  void report(const char* name, double value) const noexcept { table_->report(table_->context, name, value); }

 private:
  [[nodiscard]] const springnet_network& checked(const springnet_network* network) const {
    if (network == nullptr) throw Failure(table_->message(table_->context)->text);
    return *network;
  }
  void prepare_system(const SystemWeights& weights, const springnet_evaluation* at, bool exact) const {
    require(SPRINGNET_HAS_FIELD(springnet_host, table_, solve_system), "1.5");
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
    sweep.update = [](void* user, const springnet_node_batch* batch) {
      auto& self = *static_cast<Call*>(user);
      try {
        self.update(*batch);
      } catch (...) {
        if (!self.caught.test_and_set()) self.error = std::current_exception();
      }
    };
    const springnet_status status = function(table_->context, &sweep);
    if (call.error) std::rethrow_exception(call.error);
    check(status);
  }
  static void require(bool available, const char* since = "1.1") {
    if (available) return;
    throw Failure(std::string("the host is older than ABI ") + since +
                  ", which this integrator needs; update the host");
  }
  void check(springnet_status status) const {
    if (status == SPRINGNET_OK) return;
    const springnet_message* message = table_->message(table_->context);
    throw Failure(message == nullptr ? "the host gave no reason" : message->text, status);
  }

  const springnet_host* table_;
};

}  // namespace springnet::sdk
