// The C++ layer over the C table and over an integrator class (host.hpp, integrator.hpp), with a table that records its
// calls.
#include <doctest/doctest.h>

#include <array>
#include <complex>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <springnet/sdk/integrator.hpp>

namespace {
using namespace springnet::sdk;

// A host that returns `answer` from each call, and lists the calls.
struct FakeHost {
  std::vector<std::string> calls;
  springnet_status answer = SPRINGNET_OK;
  springnet_message text{};
  springnet_network net{};
  springnet_state state{};
  int states = 0;
  springnet_status update = SPRINGNET_OK;  // of the last node update
  bool out_of_memory = false;
  springnet_host table{};

  FakeHost() {
    net.struct_size = sizeof net;
    net.node_count = 7;
    net.element_number_count = 2;
    state.struct_size = sizeof state;
    std::strcpy(text.text, "said the host");
    table.struct_size = sizeof table;
    table.context = this;
    table.message = &text;
    table.network = [](void* c, springnet_network_query* q) {
      q->network = &of(c).net;
      return q->with_neighbours != 0 ? of(c).note("neighbours") : springnet_status{SPRINGNET_OK};
    };
    table.create_state = [](void* c, springnet_state_creation* creation) -> springnet_status {
      if (of(c).out_of_memory) return SPRINGNET_FAILED;
      ++of(c).states;
      creation->state = new springnet_state{of(c).state};
      return SPRINGNET_OK;
    };
    table.destroy_state = [](void* c, springnet_state* s) -> springnet_status {
      --of(c).states;
      delete s;
      return SPRINGNET_OK;
    };
    table.committed = [](void* c, springnet_committed* r) -> springnet_status {
      r->time = 1.5;
      r->state = &of(c).state;
      return SPRINGNET_OK;
    };
    table.begin = [](void* c, const springnet_interval* r) {
      return of(c).note(r->own_steps != 0 ? "begin own steps" : "begin", r, r->from == 1.0 && r->until == 2.0);
    };
    table.evaluate = [](void* c, const springnet_evaluation* e) {
      if (e->nodes == nullptr) return of(c).note("evaluate", e, e->time == 3.0);
      return of(c).note("evaluate nodes", e, e->time == 3.0 && (e->node_count == 0 || e->nodes[1] == 5));
    };
    table.sweep = [](void* c, const springnet_sweep* s) {
      auto batch = sized<springnet_node_batch>();
      for (batch.first = 0; batch.first < 4; batch.first += 2) {
        batch.count = 2;
        of(c).update = s->update(s->user, &batch);
      }
      return of(c).note("sweep", s, s->time == 4.0);
    };
    table.linearise = [](void* c, const springnet_linearisation* r) {
      return of(c).note("linearise", r, r->at->time == 3.0 && (r->elimination == 0.0 || r->elimination == 0.25));
    };
    table.jacobian_times = [](void* c, const springnet_jacobian_product* r) {
      *r->out = *r->dp - *r->dv;
      return of(c).note("jacobian_times", r);
    };
    table.jacobian_transposed_times = [](void* c, const springnet_transposed_product* r) {
      *r->by_position = 2.0 * *r->weights;
      *r->by_velocity = 3.0 * *r->weights;
      return of(c).note("jacobian_transposed_times", r, r->kind == SPRINGNET_TRUE_FRICTION);
    };
    table.parameter_tangent = [](void* c, const springnet_parameter_product* r) {
      *r->force = *r->sets[0]->values;
      *r->acceleration = *r->sets[1]->values;
      const bool good = r->set_count == 2 && r->internal == nullptr && r->sets[0]->kind == SPRINGNET_BY_MASS &&
                        r->sets[1]->of_elements == 1 && r->sets[1]->parameter == std::string("stiffness");
      return of(c).note("parameter_tangent", r, good);
    };
    table.parameter_cotangent = [](void* c, const springnet_parameter_product* r) {
      *r->sets[0]->values += *r->force;
      return of(c).note("parameter_cotangent", r, r->set_count == 1);
    };
    table.event_derivative = [](void* c, springnet_event_derivative* r) {
      *r->by_position = 4.0;
      r->by_time = 5.0;
      return of(c).note("event_derivative", r, r->event == 6 && r->set_count == 0);
    };
    table.change_internal = [](void* c, const springnet_internal_change* r) {
      *r->change = *r->right_side + 2.0 * *r->dp;
      *r->acceleration = *r->dv;
      return of(c).note("change_internal", r);
    };
    table.diagonal_blocks = [](void* c, const springnet_diagonal_blocks* r) {
      *r->out = r->velocity_weight - r->position_weight;
      return of(c).note("diagonal_blocks", r);
    };
    table.factorise = [](void* c, const springnet_factorisation* r) {
      return of(c).note("factorise", r, r->velocity_weight == 0.1 && r->position_weight == 0.2);
    };
    table.solve = [](void* c, const springnet_solve* r) {
      *r->x = *r->right_side;
      return of(c).note(r->transposed != 0 ? "solve transposed" : "solve", r);
    };
    table.prepare_system = [](void* c, const springnet_linear_system* r) {
      const bool complete = r->velocity_weight == 0.1 && r->position_weight == 0.2 && r->shift == 0.3;
      return of(c).note(r->exact != 0 ? "prepare_system exactly" : "prepare_system", r,
                        complete && (r->exact != 0) == (r->at == nullptr));
    };
    table.solve_system = [](void* c, springnet_linear_solve* r) {
      *r->x = 2.0 * *r->right_side;
      r->outcome = SPRINGNET_STALLED;
      r->residual = 0.5 * r->accuracy;
      r->iterations = 4;
      return of(c).note("solve_system", r);
    };
    table.event_values = [](void* c, const springnet_event_values* r) {
      *r->values = 0.5;
      *r->directions = -1;
      return of(c).note("event_values", r, r->at->time == 3.0);
    };
    table.fire_events = [](void* c, const springnet_event_firing* r) {
      return of(c).note("fire_events", r, r->time == 5.0 && r->state != nullptr && *r->fired == 1);
    };
    table.time_of_impact = [](void* c, springnet_impact_search* search) {
      auto output = sized<springnet_dense_output>();
      output.time = 0.5 * (search->from + search->until);
      const springnet_status status = search->state_at(search->user, &output);
      search->time = search->step_until < 9.0 ? search->until : std::numeric_limits<double>::quiet_NaN();
      const bool complete = search->step_from == 1.0 && search->depth == 0.1;
      return status != SPRINGNET_OK ? status : of(c).note("time_of_impact", search, complete);
    };
    table.linear_sweep = [](void* c, const springnet_sweep* s) {
      auto batch = sized<springnet_node_batch>();
      batch.first = 3;
      of(c).update = s->update(s->user, &batch);
      return of(c).note("linear_sweep", s, s->order_count == 1);
    };
    table.dominant_eigenvalue = [](void* c, springnet_eigenvalue_search* search) {
      auto image = sized<springnet_linear_image>();
      image.x = search->start;
      const springnet_status status = search->map(search->user, &image);
      search->real = search->start[0];
      search->imaginary = -1.0;
      search->error = search->tolerance;
      search->applications = 1;
      search->mode_imaginary[1] = 7.0;
      const bool complete =
          search->size == 2 && search->most_vectors == 40 && search->wanted == SPRINGNET_LARGEST_REAL_PART;
      return status != SPRINGNET_OK ? status : of(c).note("dominant_eigenvalue", search, complete);
    };
    table.next_discontinuity = [](void*, springnet_discontinuity* r) -> springnet_status {
      r->time = r->after + 1.0;
      return SPRINGNET_OK;
    };
    table.commit = [](void* c, const springnet_commitment* r) {
      return of(c).note("commit", r, r->time == 6.0 && r->state != nullptr);
    };
    table.constrain = [](void* c, const springnet_sweep* s) { return of(c).note("constrain", s, s->time == 4.0); };
    table.project = [](void* c, const springnet_projection* r) {
      *r->values = *r->mobility;
      return of(c).note("project", r);
    };
    table.project_state = [](void* c, const springnet_state_projection* r) {
      return of(c).note("project_state", r, r->time == 6.5);
    };
    table.report = [](void* c, const springnet_number_report* r) {
      const char* const more = r->adds != 0 ? "more " : "";
      return of(c).note(std::string(more) + r->name + " " + std::to_string(static_cast<int>(r->value)), r);
    };
    table.note = [](void* c, const springnet_user_note* r) {
      return of(c).note(r->topic == nullptr ? r->text : std::string(r->topic) + ": " + r->text, r);
    };
    table.deadline = [](void*, springnet_deadline* r) -> springnet_status {
      r->time_left = 30.0;
      return SPRINGNET_OK;
    };
  }
  static FakeHost& of(void* context) { return *static_cast<FakeHost*>(context); }
  springnet_status note(const std::string& name) {
    calls.push_back(name);
    return answer;
  }
  // A request must say its size.
  template <class Request>
  springnet_status note(const std::string& name, const Request* request, bool as_expected = true) {
    return note(as_expected && request->struct_size == sizeof *request ? name : name + " with other arguments");
  }
};

enum class Method { bdf, adams };

// Runs `script` in advance().
class Scripted : public Integrator {
 public:
  static constexpr const char* id = "scripted";
  static constexpr const char* summary = "runs a script of the test";
  static constexpr Parameter parameters[] = {choice("method", {"bdf", "adams"}, ""), number("tolerance", "1", ""),
                                             integer("steps", ""), boolean("strict", "")};
  static inline springnet_status (*script)(Host&, springnet_step_report&) = nullptr;
  static inline int alive = 0;
  static inline bool read_undeclared = false;

  Scripted(Host host, Options options) : host_(host), state_(host.make_state()) {
    CHECK(options.choice<Method>("method") == Method::adams);
    CHECK(options["tolerance"] == 1e-8);
    CHECK(options.integer("steps") == 12);
    CHECK(options.integer<std::uint32_t>("steps") == 12u);
    CHECK(options.boolean("strict"));
    if (read_undeclared) static_cast<void>(options["colour"]);
    ++alive;
  }
  Scripted(const Scripted&) = delete;
  Scripted& operator=(const Scripted&) = delete;
  ~Scripted() { --alive; }

  springnet_status advance(double until, springnet_step_report& report) {
    CHECK(until == 8.0);
    return script(host_, report);
  }

 private:
  Host host_;
  State state_;
};

constexpr const springnet_component& scripted = ComponentEntry<Scripted>::value;
const springnet_integrator& functions = *static_cast<const springnet_integrator*>(scripted.implementation);
constexpr std::array<double, 4> options{1.0, 1e-8, 12.0, 1.0};

// Creates an integrator with the first `count` options.
springnet_status create(const springnet_integrator& table, FakeHost& host, void*& integrator,
                        std::uint32_t count = static_cast<std::uint32_t>(options.size())) {
  auto creation = sized<springnet_integrator_creation>();
  creation.host = &host.table;
  creation.option_count = count;
  creation.options = options.data();
  creation.integrator = integrator;
  const springnet_status status = table.create(table.context, &creation);
  integrator = creation.integrator;
  return status;
}

// One advance() that runs `script`.
springnet_status run(FakeHost& host, springnet_status (*script)(Host&, springnet_step_report&),
                     springnet_step_report* report = nullptr) {
  void* integrator = nullptr;
  REQUIRE(create(functions, host, integrator) == SPRINGNET_OK);
  CHECK(Scripted::alive == 1);
  Scripted::script = script;
  auto own = sized<springnet_step_report>();
  auto request = sized<springnet_advance>();
  request.until = 8.0;
  request.report = report != nullptr ? report : &own;
  const springnet_status status = functions.advance(integrator, &request);
  CHECK(functions.destroy(integrator) == SPRINGNET_OK);
  CHECK(Scripted::alive == 0);
  CHECK(host.states == 0);
  return status;
}

}  // namespace

TEST_CASE("an integrator reaches every function of the host") {
  FakeHost host;
  const springnet_status status = run(host, [](Host& h, springnet_step_report& report) -> springnet_status {
    CHECK(h.network().node_count == 7);
    CHECK(h.network_with_neighbours().node_count == 7);
    CHECK(h.time_left() == 30.0);
    CHECK(h.table().struct_size == sizeof(springnet_host));
    CHECK(h.committed().time == 1.5);
    h.begin_step(1.0, 2.0);
    h.begin_interval(1.0, 2.0);
    auto at = evaluation_at(3.0, h.committed().state);
    CHECK(at.struct_size == sizeof(springnet_evaluation));
    CHECK(at.force.x == nullptr);
    h.evaluate(at);
    const std::uint32_t nodes[] = {3, 5};
    h.evaluate_nodes(at, nodes);
    h.evaluate_nodes(at, {});  // of no nodes, not of all
    auto sweep = sized<springnet_sweep>();
    sweep.time = 4.0;
    std::uint32_t updated = 0;
    h.sweep(sweep, [&](const springnet_node_batch& batch) { updated += batch.first + batch.count; });
    CHECK(updated == 6);
    h.linearise(at);
    h.linearise(at, 0.25);
    const double one = 1.0, two = 2.0;
    double out = 0.0;
    h.jacobian_times(&one, &two, &out);
    CHECK(out == -1.0);
    double second = 0.0;
    h.jacobian_transposed_times(&two, &out, &second, SPRINGNET_TRUE_FRICTION);
    CHECK(out == 4.0);
    CHECK(second == 6.0);
    std::vector<double> masses(7, 7.0), stiffnesses(2, 8.0);
    const Host::ParameterSet sets[] = {{SPRINGNET_BY_MASS, masses},
                                       {SPRINGNET_BY_SPRING_PARAMETER, stiffnesses, "stiffness", nullptr, true}};
    h.parameter_tangent(at, sets, {&out, &second});
    CHECK(out == 7.0);
    CHECK(second == 8.0);
    h.parameter_cotangent(at, std::span(sets).first(1), {&out});
    CHECK(masses[0] == 14.0);
    CHECK(h.event_derivative(at, 6, &out, nullptr) == 5.0);
    CHECK(out == 4.0);
    double acceleration = 0.0;
    h.change_internal(&one, &two, &one, &out, &acceleration);
    CHECK(out == 5.0);
    CHECK(acceleration == 1.0);
    h.diagonal_blocks(0.5, 0.25, &out);
    CHECK(out == 0.25);
    h.factorise(0.1, 0.2);
    h.solve(&two, &out);
    CHECK(out == 2.0);
    h.solve_transposed(&one, &out);
    CHECK(out == 1.0);
    h.prepare_system({0.1, 0.2, 0.3}, at, false);
    h.prepare_system({0.1, 0.2, 0.3});
    const Host::Solved solved = h.solve_system(&two, 0.5, &out);
    CHECK(out == 4.0);
    CHECK(solved.outcome == SPRINGNET_STALLED);
    CHECK(solved.residual == 0.25);
    CHECK(solved.iterations == 4);
    std::int32_t direction = 0;
    h.event_values(at, &out, &direction);
    CHECK(out == 0.5);
    CHECK(direction == -1);
    const State state = h.make_state();
    const std::int32_t fired = 1;
    h.fire_events(5.0, *state, &fired);
    double asked = 0.0;
    const auto ask = [&](double time, const springnet_vectors&, const springnet_vectors&) { asked = time; };
    CHECK(h.time_of_impact({1.0, 3.0}, {1.5, 2.5}, 0.1, ask) == 2.5);
    CHECK(asked == 2.0);
    CHECK_FALSE(h.time_of_impact({1.0, 9.0}, {1.5, 2.5}, 0.1, ask).has_value());
    const auto refuse = [](double, const springnet_vectors&, const springnet_vectors&) { throw Failure("no state"); };
    CHECK_THROWS_WITH_AS(static_cast<void>(h.time_of_impact({1.0, 3.0}, {1.5, 2.5}, 0.1, refuse)), "no state", Failure);
    sweep.order_count = 1;
    h.linear_sweep(sweep, [&](const springnet_node_batch& batch) { updated = batch.first; });
    CHECK(updated == 3);
    std::vector<double> start{3.0, 4.0};
    DominantOptions dominant;
    dominant.wanted = SPRINGNET_LARGEST_REAL_PART;
    const Dominant mode = h.dominant_eigenvalue(start, dominant, [](double* x) { x[0] = 5.0; });
    CHECK(mode.value == std::complex<double>(5.0, -1.0));
    CHECK(mode.error == dominant.tolerance);
    CHECK(mode.imaginary == std::vector<double>{0.0, 7.0});
    CHECK(start[0] == 5.0);
    const auto no_image = [](double*) { throw Failure("no image"); };
    CHECK_THROWS_WITH_AS(static_cast<void>(h.dominant_eigenvalue(start, dominant, no_image)), "no image", Failure);
    CHECK(h.next_discontinuity(7.0) == 8.0);
    h.constrain(sweep);
    h.project(&two, &out);
    CHECK(out == 2.0);
    h.project_state(6.5, *state);
    h.commit(6.0, *state);
    h.report("sweeps", 9.0);
    h.note("slowly");
    h.count("iterations", 4.0);
    h.note("limit 0.1 s", "limit");
    report.outcome = SPRINGNET_SETTLED;
    return SPRINGNET_OK;
  });
  CHECK(status == SPRINGNET_OK);
  CHECK(host.calls == std::vector<std::string>{"neighbours",
                                               "begin",
                                               "begin own steps",
                                               "evaluate",
                                               "evaluate nodes",
                                               "evaluate nodes",
                                               "sweep",
                                               "linearise",
                                               "linearise",
                                               "jacobian_times",
                                               "jacobian_transposed_times",
                                               "parameter_tangent",
                                               "parameter_cotangent",
                                               "event_derivative",
                                               "change_internal",
                                               "diagonal_blocks",
                                               "factorise",
                                               "solve",
                                               "solve transposed",
                                               "prepare_system",
                                               "prepare_system exactly",
                                               "solve_system",
                                               "event_values",
                                               "fire_events",
                                               "time_of_impact",
                                               "time_of_impact",
                                               "linear_sweep",
                                               "dominant_eigenvalue",
                                               "constrain",
                                               "project",
                                               "project_state",
                                               "commit",
                                               "sweeps 9",
                                               "slowly",
                                               "more iterations 4",
                                               "limit: limit 0.1 s"});
  CHECK(host.update == SPRINGNET_OK);
}

namespace {

// Reports limits, or fails.
class Limited : public Integrator {
 public:
  static constexpr const char* id = "limited";
  static constexpr const char* summary = "reports limits";
  static constexpr bool integrates_states = true;
  static inline bool fails = false;
  explicit Limited(Host, Options) {}
  springnet_status advance(double, springnet_step_report&) { return SPRINGNET_OK; }
  void limits(const LimitSink& sink) {
    if (fails) throw Failure("no derivatives");
    sink.report("leap", {SPRINGNET_LIMIT_ESTIMATE, 0.5, 0.25, 3});
    sink.report("", {SPRINGNET_LIMIT_KNOWN, std::numeric_limits<double>::infinity()});
    sink.unknown("hop", "it is dark");
  }
};

// Answers the sum of all scales, and the number of the column.
class Differentiating : public Integrator {
 public:
  static constexpr const char* id = "differentiating";
  static constexpr const char* summary = "";
  Differentiating(Host, Options) {}
  springnet_status advance(double, springnet_step_report&) { return SPRINGNET_OK; }
  void begin_sensitivities(std::span<const springnet_sensitivity* const> columns) {
    for (const springnet_sensitivity* const each : columns) sum_ += each->scale;
  }
  void sensitivity(std::uint32_t column, double* position, double* velocity) const {
    if (column > 1) throw Failure("there are two");
    *position = sum_;
    *velocity = column;
  }

 private:
  double sum_ = 0.0;
};

}  // namespace

TEST_CASE("an integrator class with limits() reports them; one without has no such function") {
  const bool has_limits = functions.limits != nullptr;
  CHECK_FALSE(has_limits);
  const auto& limited = *static_cast<const springnet_integrator*>(ComponentEntry<Limited>::value.implementation);
  const bool reports = limited.limits != nullptr;
  REQUIRE(reports);
  FakeHost host;
  void* integrator = nullptr;
  REQUIRE(create(limited, host, integrator, 0) == SPRINGNET_OK);
  std::vector<std::string> reported;
  springnet_limits sink{sizeof sink, 0, &reported, [](void* context, const springnet_limit* limit) -> springnet_status {
                          static_cast<std::vector<std::string>*>(context)->push_back(
                              std::string(limit->rule) + " " + std::to_string(limit->kind) + " " +
                              (limit->reason == nullptr ? std::to_string(limit->node) : limit->reason));
                          return SPRINGNET_OK;
                        }};
  CHECK(limited.limits(integrator, &sink) == SPRINGNET_OK);
  CHECK(reported == std::vector<std::string>{"leap 1 3", " 2 4294967295", "hop 3 it is dark"});
  Limited::fails = true;
  CHECK(limited.limits(integrator, &sink) == SPRINGNET_FAILED);
  Limited::fails = false;
  CHECK(std::string(host.text.text) == "no derivatives");
  CHECK(limited.destroy(integrator) == SPRINGNET_OK);
}

TEST_CASE("an integrator class with sensitivities takes columns and answers them; one without has no such functions") {
  const bool has_none = functions.begin_sensitivities == nullptr && functions.sensitivity == nullptr;
  CHECK(has_none);
  const auto& table = *static_cast<const springnet_integrator*>(ComponentEntry<Differentiating>::value.implementation);
  const bool has_both = table.begin_sensitivities != nullptr && table.sensitivity != nullptr;
  REQUIRE(has_both);
  FakeHost host;
  void* integrator = nullptr;
  REQUIRE(create(table, host, integrator, 0) == SPRINGNET_OK);
  auto column = sized<springnet_sensitivity>();
  column.scale = 2.5;
  const springnet_sensitivity* const columns[] = {&column, &column};
  auto request = sized<springnet_sensitivities>();
  request.count = 2;
  request.columns = columns;
  CHECK(table.begin_sensitivities(integrator, &request) == SPRINGNET_OK);
  double position = 0.0, velocity = 0.0;
  auto values = sized<springnet_sensitivity_values>();
  values.column = 1;
  values.position = &position;
  values.velocity = &velocity;
  CHECK(table.sensitivity(integrator, &values) == SPRINGNET_OK);
  CHECK(position == 5.0);
  CHECK(velocity == 1.0);
  values.column = 2;
  CHECK(table.sensitivity(integrator, &values) == SPRINGNET_FAILED);
  CHECK(std::string(host.text.text) == "there are two");
  CHECK(table.destroy(integrator) == SPRINGNET_OK);
}

TEST_CASE("a failed host call becomes an exception, and its status that of advance") {
  FakeHost host;
  for (const springnet_status answer : {SPRINGNET_FAILED, SPRINGNET_RECOVERABLE}) {
    host.answer = answer;
    CHECK(run(host, [](Host& h, springnet_step_report&) -> springnet_status {
            h.begin_step(1.0, 2.0);
            return SPRINGNET_OK;
          }) == answer);
    CHECK(std::string(host.text.text) == "said the host");
  }
  host.answer = SPRINGNET_RECOVERABLE;
  CHECK(run(host, [](Host& h, springnet_step_report&) -> springnet_status {
          try {
            h.begin_step(1.0, 2.0);
          } catch (const Failure& failure) {
            CHECK(failure.recoverable());
            CHECK(std::string(failure.what()) == "said the host");
          }
          return SPRINGNET_UNSETTLED;
        }) == SPRINGNET_UNSETTLED);
}

TEST_CASE("no exception leaves an integrator; the host's message says why") {
  FakeHost host;
  CHECK(run(host, [](Host&, springnet_step_report&) -> springnet_status { throw std::runtime_error("no pivot"); }) ==
        SPRINGNET_FAILED);
  CHECK(std::string(host.text.text) == "no pivot");
  CHECK(run(host, [](Host&, springnet_step_report&) -> springnet_status {
          throw Failure("too large a step", SPRINGNET_RECOVERABLE);
        }) == SPRINGNET_RECOVERABLE);
  CHECK(std::string(host.text.text) == "too large a step");
  CHECK(run(host, [](Host&, springnet_step_report&) -> springnet_status { throw 1; }) == SPRINGNET_FAILED);
  CHECK(std::string(host.text.text) == "the integrator threw something that is not a std::exception");
}

TEST_CASE("an exception of a node update fails the advance after the sweep has ended") {
  FakeHost host;
  CHECK(run(host, [](Host& h, springnet_step_report&) -> springnet_status {
          auto sweep = sized<springnet_sweep>();
          sweep.time = 4.0;
          h.sweep(sweep, [](const springnet_node_batch& batch) {
            throw std::runtime_error("node " + std::to_string(batch.first));
          });
          return SPRINGNET_OK;
        }) == SPRINGNET_FAILED);
  CHECK(std::string(host.text.text) == "node 0");          // the first exception
  CHECK(host.update == SPRINGNET_FAILED);                  // so that the host may end the sweep
  CHECK(host.calls == std::vector<std::string>{"sweep"});  // the sweep was completed
}

TEST_CASE("the report of a host with another minor version is not written beyond its end") {
  FakeHost host;
  struct Short {
    springnet_step_report report;
  } memory{};
  std::memset(&memory, 0x7f, sizeof memory);
  const auto size = static_cast<std::uint32_t>(SPRINGNET_SIZE_TO(springnet_step_report, sweeps));
  memory.report.struct_size = size;
  memory.report.steps = 3;
  CHECK(run(
            host,
            [](Host&, springnet_step_report& report) -> springnet_status {
              CHECK(report.struct_size == sizeof(springnet_step_report));
              report.steps += 1;
              report.sweeps = 20;
              report.residual = 0.0;
              return SPRINGNET_OK;
            },
            &memory.report) == SPRINGNET_OK);
  CHECK(memory.report.struct_size == size);
  CHECK(memory.report.steps == 4);
  CHECK(memory.report.sweeps == 20);
  std::uint64_t beyond = 0;
  std::memcpy(&beyond, &memory.report.residual, sizeof beyond);
  CHECK(beyond == 0x7f7f7f7f7f7f7f7fu);
}

TEST_CASE("an integrator that cannot be constructed leaves nothing behind") {
  FakeHost host;
  void* integrator = &host;
  Scripted::read_undeclared = true;
  CHECK(create(functions, host, integrator) == SPRINGNET_FAILED);
  Scripted::read_undeclared = false;
  CHECK(integrator == nullptr);
  CHECK(host.states == 0);
  CHECK(std::string(host.text.text) == "the integrator reads an option that it does not declare: colour");

  host.out_of_memory = true;
  CHECK(create(functions, host, integrator) == SPRINGNET_FAILED);
  host.out_of_memory = false;

  CHECK(create(functions, host, integrator, 3) == SPRINGNET_FAILED);
  CHECK(std::string(host.text.text) == "the host gave another number of options than the integrator declares");

  host.table.struct_size = offsetof(springnet_host, deadline);
  CHECK(create(functions, host, integrator) == SPRINGNET_FAILED);
  CHECK(integrator == nullptr);
  CHECK(std::string(host.text.text).find("smaller than that of ABI 2.0") != std::string::npos);
  host.table.struct_size = offsetof(springnet_host, message);  // it has no place for a reason
  CHECK(create(functions, host, integrator) == SPRINGNET_FAILED);
  CHECK(integrator == nullptr);
}

TEST_CASE("metadata of an integrator come from its class") {
  CHECK(scripted.kind == SPRINGNET_INTEGRATOR);
  CHECK(scripted.parameter_count == 4);
  CHECK(scripted.capabilities == 0);
  CHECK(scripted.needs == 0);
  CHECK(scripted.needs_minor == SPRINGNET_ABI_MINOR);
  CHECK(functions.struct_size == sizeof(springnet_integrator));
  CHECK((functions.forget == nullptr));
  CHECK(ComponentEntry<Limited>::value.capabilities == SPRINGNET_INTEGRATES_STATES);
}
