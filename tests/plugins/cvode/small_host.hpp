// A host of a few nodes whose accelerations are a formula of the test, with dense matrices: what the plugin does with
// its host (which calls, how often, what after a failure) can be seen and provoked here without the engine.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include <springnet/plugin_host.hpp>
#include <springnet/sdk/host.hpp>

// The plugin's parameters.
enum Method { bdf, adams };
enum Solver { automatic, direct, krylov, none };
inline springnet::ParameterValues options(Method method, Solver solver, double tolerance = 1e-8) {
  return {{"method", method}, {"linear_solver", solver}, {"relative_tolerance", tolerance}};
}

class SmallHost {
 public:
  using Vector = Eigen::VectorXd;  // 3 node_count: x of all nodes, then y, then z
  using Matrix = Eigen::MatrixXd;
  template <class Struct>
  static Struct sized() {
    return springnet::sdk::sized<Struct>();
  }
  struct Event {
    std::function<double(double time, const Vector& p, const Vector& v)> value;
    std::int32_t direction;
    std::function<void(SmallHost& host, Vector& p, Vector& v)> happen;
  };

  explicit SmallHost(std::uint32_t node_count) : size_(3 * node_count) {
    network_.struct_size = sizeof network_;
    network_.node_count = node_count;
    network_.length_scale = 1.0;
    network_.velocity_scale = 1.0;
    network_.force_scale = 1.0;
    committed_ = std::make_unique<State>(size_);
    fill_table();
  }
  ~SmallHost() {
    if (integrator_ != nullptr) description().destroy(integrator_);
  }
  SmallHost(const SmallHost&) = delete;
  SmallHost& operator=(const SmallHost&) = delete;

  // The model: a(t, p, v) and its derivatives.
  std::function<Vector(double, const Vector&, const Vector&)> acceleration;
  std::function<std::pair<Matrix, Matrix>(double, const Vector&, const Vector&)> derivatives;  // da/dp, da/dv
  std::vector<Event> events;
  std::vector<double> discontinuities;  // s
  std::function<void(double time)> at_commit = [](double) {};

  // What the plugin has done.
  int evaluations = 0;
  int linearisations = 0;
  int factorisations = 0;
  int products = 0;
  std::vector<std::pair<double, double>> steps_begun;
  std::vector<double> commits;
  std::map<std::string, double> reported;

  void start(const Vector& p, const Vector& v, double time = 0.0) {
    committed_->p = p;
    committed_->v = v;
    time_ = time;
  }
  // The program changes the state or the model: a multistep method has to start afresh.
  void change() { ++network_.revision; }
  // Creates the integrator with options by name; empty, or why it refused.
  std::string create(const springnet::ParameterValues& options) {
    network_.event_count = static_cast<std::uint32_t>(events.size());
    const auto values = springnet::complete_parameters(*component().description, options, "test");
    auto creation = sized<springnet_integrator_creation>();
    creation.host = &table_;
    creation.option_count = static_cast<std::uint32_t>(values.size());
    creation.options = values.data();
    const springnet_status status = description().create(description().context, &creation);
    integrator_ = creation.integrator;
    return status == SPRINGNET_OK ? "" : message_.text;
  }
  // Empty, or why it failed.
  std::string advance(double until) {
    report = {};
    report.struct_size = sizeof report;
    message_ = {};
    auto request = sized<springnet_advance>();
    request.until = until;
    request.report = &report;
    return description().advance(integrator_, &request) == SPRINGNET_OK ? "" : message_.text;
  }
  // The same of sensitivities by the start, a column for each change of it, with errors as for a change by 1.
  std::string begin_sensitivities(const std::vector<std::pair<Vector, Vector>>& changes, double scale = 1.0) {
    std::vector<springnet_sensitivity> columns;
    for (const auto& [p, v] : changes) {
      columns.push_back(sized<springnet_sensitivity>());
      columns.back().position = p.data();
      columns.back().velocity = v.data();
      columns.back().scale = scale;
    }
    std::vector<const springnet_sensitivity*> pointers;
    for (const springnet_sensitivity& each : columns) pointers.push_back(&each);
    auto request = sized<springnet_sensitivities>();
    request.count = static_cast<std::uint32_t>(pointers.size());
    request.columns = pointers.data();
    message_ = {};
    return description().begin_sensitivities(integrator_, &request) == SPRINGNET_OK ? "" : message_.text;
  }
  // Of positions, then of velocities; empty if there is no such column.
  Vector sensitivity(std::uint32_t column) {
    Vector result(2 * size_);
    auto request = sized<springnet_sensitivity_values>();
    request.column = column;
    request.position = result.data();
    request.velocity = result.data() + size_;
    return description().sensitivity(integrator_, &request) == SPRINGNET_OK ? result : Vector();
  }
  springnet_step_report report{};
  springnet_network& network() { return network_; }
  const Vector& position() const { return committed_->p; }
  const Vector& velocity() const { return committed_->v; }
  const Vector& force() const { return committed_->f; }
  double time() const { return time_; }

 private:
  struct State : springnet_state {
    explicit State(Eigen::Index size) : springnet_state{}, p(Vector::Zero(size)), v(p), f(p) {
      struct_size = sizeof(springnet_state);
      point();
    }
    void point() {
      const Eigen::Index n = p.size() / 3;
      position = {p.data(), p.data() + n, p.data() + 2 * n};
      velocity = {v.data(), v.data() + n, v.data() + 2 * n};
      force = {f.data(), f.data() + n, f.data() + 2 * n};
    }
    void swap(State& other) {
      p.swap(other.p);
      v.swap(other.v);
      f.swap(other.f);
      point();
      other.point();
    }
    Vector p, v, f;
  };

  static const springnet::Component& component() {
    static const springnet::PluginHost plugins = springnet::PluginHost::with_default_search();
    static const auto found = plugins.require(springnet::ComponentKind::integrator, "cvode");
    return *found;
  }
  static const springnet_integrator& description() { return component().integrator(); }
  static SmallHost& of(void* context) { return *static_cast<SmallHost*>(context); }

  static Vector read(const springnet_const_vectors& from, Eigen::Index size) {
    const Eigen::Index n = size / 3;
    Vector result(size);
    result << Eigen::Map<const Vector>(from.x, n), Eigen::Map<const Vector>(from.y, n),
        Eigen::Map<const Vector>(from.z, n);
    return result;
  }
  static void write(const Vector& from, const springnet_vectors& to) {
    if (to.x == nullptr) return;
    const Eigen::Index n = from.size() / 3;
    Eigen::Map<Vector>(to.x, n) = from.head(n);
    Eigen::Map<Vector>(to.y, n) = from.segment(n, n);
    Eigen::Map<Vector>(to.z, n) = from.tail(n);
  }
  Matrix matrix(double velocity_weight, double position_weight) const {
    return Matrix::Identity(size_, size_) - velocity_weight * by_velocity_ - position_weight * by_position_;
  }
  void fill_table();

  Eigen::Index size_;
  springnet_network network_{};
  springnet_host table_{};
  springnet_message message_{};
  std::unique_ptr<State> committed_;
  double time_ = 0.0;
  Matrix by_position_, by_velocity_;
  Eigen::PartialPivLU<Matrix> factors_;
  void* integrator_ = nullptr;
};

inline void SmallHost::fill_table() {
  table_.struct_size = sizeof table_;
  table_.context = this;
  table_.message = &message_;
  table_.network = [](void* self, springnet_network_query* query) -> springnet_status {
    query->network = &of(self).network_;
    return SPRINGNET_OK;
  };
  table_.create_state = [](void* self, springnet_state_creation* creation) -> springnet_status {
    creation->state = new State(of(self).size_);
    return SPRINGNET_OK;
  };
  table_.destroy_state = [](void*, springnet_state* state) -> springnet_status {
    delete static_cast<State*>(state);
    return SPRINGNET_OK;
  };
  table_.committed = [](void* self, springnet_committed* answer) -> springnet_status {
    answer->time = of(self).time_;
    answer->state = of(self).committed_.get();
    return SPRINGNET_OK;
  };
  table_.begin = [](void* self, const springnet_interval* interval) -> springnet_status {
    of(self).steps_begun.emplace_back(interval->from, interval->until);
    return SPRINGNET_OK;
  };
  table_.evaluate = [](void* self, const springnet_evaluation* e) -> springnet_status {
    SmallHost& host = of(self);
    ++host.evaluations;
    const Vector a = host.acceleration(e->time, read(e->position, host.size_), read(e->velocity, host.size_));
    if (!a.allFinite()) {
      std::snprintf(host.message_.text, sizeof host.message_.text, "law 'made up' answered nan for spring 7");
      return SPRINGNET_RECOVERABLE;
    }
    write(a, e->acceleration);
    write(a, e->force);  // every mass is 1 kg
    return SPRINGNET_OK;
  };
  table_.linearise = [](void* self, const springnet_linearisation* request) -> springnet_status {
    SmallHost& host = of(self);
    const springnet_evaluation* const e = request->at;
    ++host.linearisations;
    std::tie(host.by_position_, host.by_velocity_) =
        host.derivatives(e->time, read(e->position, host.size_), read(e->velocity, host.size_));
    return SPRINGNET_OK;
  };
  table_.jacobian_times = [](void* self, const springnet_jacobian_product* product) -> springnet_status {
    SmallHost& host = of(self);
    ++host.products;
    const Eigen::Map<const Vector> p(product->dp, host.size_);
    const Eigen::Map<const Vector> v(product->dv, host.size_);
    Eigen::Map<Vector>(product->out, host.size_) = Vector(host.by_position_ * p + host.by_velocity_ * v);
    return SPRINGNET_OK;
  };
  table_.diagonal_blocks = [](void* self, const springnet_diagonal_blocks* blocks) -> springnet_status {
    SmallHost& host = of(self);
    const Matrix all = host.matrix(blocks->velocity_weight, blocks->position_weight);
    double* out = blocks->out;
    const Eigen::Index n = host.size_ / 3;
    for (Eigen::Index node = 0; node < n; ++node) {
      for (Eigen::Index row = 0; row < 3; ++row) {
        for (Eigen::Index column = 0; column < 3; ++column) *out++ = all(node + row * n, node + column * n);
      }
    }
    return SPRINGNET_OK;
  };
  table_.factorise = [](void* self, const springnet_factorisation* weights) -> springnet_status {
    SmallHost& host = of(self);
    ++host.factorisations;
    host.factors_.compute(host.matrix(weights->velocity_weight, weights->position_weight));
    return SPRINGNET_OK;
  };
  table_.solve = [](void* self, const springnet_solve* system) -> springnet_status {
    SmallHost& host = of(self);
    const Vector b = Eigen::Map<const Vector>(system->right_side, host.size_);
    Eigen::Map<Vector>(system->x, host.size_) = host.factors_.solve(b);
    return SPRINGNET_OK;
  };
  table_.event_values = [](void* self, const springnet_event_values* request) -> springnet_status {
    SmallHost& host = of(self);
    const Vector p = read(request->at->position, host.size_);
    const Vector v = read(request->at->velocity, host.size_);
    for (std::size_t i = 0; i < host.events.size(); ++i) {
      request->values[i] = host.events[i].value(request->at->time, p, v);
      request->directions[i] = host.events[i].direction;
    }
    return SPRINGNET_OK;
  };
  table_.fire_events = [](void* self, const springnet_event_firing* firing) -> springnet_status {
    SmallHost& host = of(self);
    auto& at = *static_cast<State*>(firing->state);
    const std::vector<Event> before = host.events;  // an event may change the list
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (firing->fired[i] != 0) before[i].happen(host, at.p, at.v);
    }
    host.network_.event_count = static_cast<std::uint32_t>(host.events.size());
    host.change();
    return SPRINGNET_OK;
  };
  table_.time_of_impact = [](void*, springnet_impact_search* search) -> springnet_status {
    search->time = std::numeric_limits<double>::quiet_NaN();
    return SPRINGNET_OK;
  };
  table_.next_discontinuity = [](void* self, springnet_discontinuity* next) -> springnet_status {
    next->time = std::numeric_limits<double>::infinity();
    for (const double each : of(self).discontinuities) {
      if (each > next->after) next->time = std::min(next->time, each);
    }
    return SPRINGNET_OK;
  };
  table_.commit = [](void* self, const springnet_commitment* commitment) -> springnet_status {
    SmallHost& host = of(self);
    const double time = commitment->time;
    host.committed_->swap(*static_cast<State*>(commitment->state));
    host.time_ = time;
    host.commits.push_back(time);
    for (const double each : host.discontinuities) {
      if (each == time) host.change();
    }
    host.at_commit(time);
    return SPRINGNET_OK;
  };
  table_.report = [](void* self, const springnet_number_report* number) -> springnet_status {
    double& known = of(self).reported[number->name];
    known = number->adds != 0 ? known + number->value : number->value;
    return SPRINGNET_OK;
  };
}
