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
  bool out_of_memory = false;
  springnet_host table{};

  FakeHost() {
    net.struct_size = sizeof net;
    net.node_count = 7;
    state.struct_size = sizeof state;
    std::strcpy(text.text, "said the host");
    table.struct_size = sizeof table;
    table.context = this;
    table.network = [](void* c) -> const springnet_network* { return &of(c).net; };
    table.state_create = [](void* c) -> springnet_state* {
      if (of(c).out_of_memory) return nullptr;
      ++of(c).states;
      return new springnet_state{of(c).state};
    };
    table.state_destroy = [](void* c, springnet_state* s) {
      --of(c).states;
      delete s;
    };
    table.committed = [](void* c, double* time) -> const springnet_state* {
      *time = 1.5;
      return &of(c).state;
    };
    table.begin_step = [](void* c, double from, double until) {
      return of(c).note("begin_step", from == 1.0 && until == 2.0);
    };
    table.begin_interval = [](void* c, double from, double until) {
      return of(c).note("begin_interval", from == 1.0 && until == 2.0);
    };
    table.evaluate = [](void* c, const springnet_evaluation* e) { return of(c).note("evaluate", e->time == 3.0); };
    table.evaluate_nodes = [](void* c, const springnet_evaluation* e, const std::uint32_t* nodes, std::uint32_t n) {
      return of(c).note("evaluate_nodes", e->time == 3.0 && n == 2 && nodes[1] == 5);
    };
    table.sweep = [](void* c, const springnet_sweep* s) {
      auto batch = sized<springnet_node_batch>();
      for (batch.first = 0; batch.first < 4; batch.first += 2) {
        batch.count = 2;
        s->update(s->user, &batch);
      }
      return of(c).note("sweep", s->time == 4.0);
    };
    table.linearise = [](void* c, const springnet_evaluation* e) { return of(c).note("linearise", e->time == 3.0); };
    table.jacobian_times = [](void* c, const double* dp, const double* dv, double* out) {
      *out = *dp - *dv;
      return of(c).note("jacobian_times");
    };
    table.diagonal_blocks = [](void* c, double v, double p, double* out) {
      *out = v - p;
      return of(c).note("diagonal_blocks");
    };
    table.factorise = [](void* c, double v, double p) { return of(c).note("factorise", v == 0.1 && p == 0.2); };
    table.solve = [](void* c, std::int32_t transposed, const double* b, double* x) {
      *x = *b;
      return of(c).note(transposed != 0 ? "solve transposed" : "solve");
    };
    table.event_values = [](void* c, const springnet_evaluation*, double* values, std::int32_t* directions) {
      *values = 0.5;
      *directions = -1;
      return of(c).note("event_values");
    };
    table.fire_events = [](void* c, double time, springnet_state* s, const std::int32_t* fired) {
      return of(c).note("fire_events", time == 5.0 && s != nullptr && *fired == 1);
    };
    table.time_of_impact = [](void* c, const springnet_impact_search* search, double* time) {
      const springnet_status status = search->state_at(search->user, 0.5 * (search->from + search->until), {}, {});
      *time = search->step_until < 9.0 ? search->until : std::numeric_limits<double>::quiet_NaN();
      const bool complete = search->struct_size == sizeof *search && search->step_from == 1.0 && search->depth == 0.1;
      return status != SPRINGNET_OK ? status : of(c).note("time_of_impact", complete);
    };
    table.linear_sweep = [](void* c, const springnet_sweep* s) {
      auto batch = sized<springnet_node_batch>();
      batch.first = 3;
      s->update(s->user, &batch);
      return of(c).note("linear_sweep", s->order_count == 1);
    };
    table.dominant_eigenvalue = [](void* c, springnet_eigenvalue_search* search) {
      const springnet_status status = search->map(search->user, search->start);
      search->real = search->start[0];
      search->imaginary = -1.0;
      search->error = search->tolerance;
      search->applications = 1;
      search->mode_imaginary[1] = 7.0;
      const bool complete = search->struct_size == sizeof *search && search->size == 2 && search->most_vectors == 40 &&
                            search->wanted == SPRINGNET_LARGEST_REAL_PART;
      return status != SPRINGNET_OK ? status : of(c).note("dominant_eigenvalue", complete);
    };
    table.next_discontinuity = [](void*, double time) { return time + 1.0; };
    table.commit = [](void* c, double time, springnet_state* s) {
      return of(c).note("commit", time == 6.0 && s != nullptr);
    };
    table.report = [](void* c, const char* name, double value) {
      of(c).calls.push_back(std::string(name) + " " + std::to_string(static_cast<int>(value)));
    };
    table.message = [](void* c) { return &of(c).text; };
  }
  static FakeHost& of(void* context) { return *static_cast<FakeHost*>(context); }
  springnet_status note(const char* name, bool as_expected = true) {
    calls.push_back(as_expected ? name : std::string(name) + " with other arguments");
    return answer;
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

// One advance() that runs `script`.
springnet_status run(FakeHost& host, springnet_status (*script)(Host&, springnet_step_report&),
                     springnet_step_report* report = nullptr) {
  void* integrator = nullptr;
  REQUIRE(functions.create(&host.table, options.data(), &integrator) == SPRINGNET_OK);
  CHECK(Scripted::alive == 1);
  Scripted::script = script;
  auto own = sized<springnet_step_report>();
  const springnet_status status = functions.advance(integrator, 8.0, report != nullptr ? report : &own);
  functions.destroy(integrator);
  CHECK(Scripted::alive == 0);
  CHECK(host.states == 0);
  return status;
}

}  // namespace

TEST_CASE("an integrator reaches every function of the host") {
  FakeHost host;
  const springnet_status status = run(host, [](Host& h, springnet_step_report& report) -> springnet_status {
    CHECK(h.network().node_count == 7);
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
    auto sweep = sized<springnet_sweep>();
    sweep.time = 4.0;
    std::uint32_t updated = 0;
    h.sweep(sweep, [&](const springnet_node_batch& batch) { updated += batch.first + batch.count; });
    CHECK(updated == 6);
    h.linearise(at);
    const double one = 1.0, two = 2.0;
    double out = 0.0;
    h.jacobian_times(&one, &two, &out);
    CHECK(out == -1.0);
    h.diagonal_blocks(0.5, 0.25, &out);
    CHECK(out == 0.25);
    h.factorise(0.1, 0.2);
    h.solve(&two, &out);
    CHECK(out == 2.0);
    h.solve_transposed(&one, &out);
    CHECK(out == 1.0);
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
    h.commit(6.0, *state);
    h.report("sweeps", 9.0);
    report.outcome = SPRINGNET_SETTLED;
    return SPRINGNET_OK;
  });
  CHECK(status == SPRINGNET_OK);
  CHECK(host.calls == std::vector<std::string>{"begin_step", "begin_interval", "evaluate", "evaluate_nodes", "sweep",
                                               "linearise", "jacobian_times", "diagonal_blocks", "factorise", "solve",
                                               "solve transposed", "event_values", "fire_events", "time_of_impact",
                                               "time_of_impact", "linear_sweep", "dominant_eigenvalue", "commit",
                                               "sweeps 9"});
}

TEST_CASE("with a host before ABI 1.2, begin_interval falls back to begin_step") {
  FakeHost host;
  host.table.struct_size = offsetof(springnet_host, begin_interval);
  CHECK(run(host, [](Host& h, springnet_step_report&) -> springnet_status {
          h.begin_interval(1.0, 2.0);
          return SPRINGNET_OK;
        }) == SPRINGNET_OK);
  CHECK(host.calls == std::vector<std::string>{"begin_step"});
}

TEST_CASE("with a host before ABI 1.3, time_of_impact finds nothing") {
  FakeHost host;
  host.table.struct_size = offsetof(springnet_host, time_of_impact);
  CHECK(run(host, [](Host& h, springnet_step_report&) -> springnet_status {
          const auto state_at = [](double, const springnet_vectors&, const springnet_vectors&) {};
          CHECK_FALSE(h.time_of_impact({1.0, 3.0}, {1.0, 3.0}, 0.1, state_at).has_value());
          return SPRINGNET_OK;
        }) == SPRINGNET_OK);
  CHECK(host.calls.empty());
}

TEST_CASE("with a host before ABI 1.4, an eigenvalue search fails and names the version") {
  FakeHost host;
  host.table.struct_size = offsetof(springnet_host, linear_sweep);
  CHECK(run(host, [](Host& h, springnet_step_report&) -> springnet_status {
          std::vector<double> start{1.0};
          static_cast<void>(h.dominant_eigenvalue(start, {}, [](double*) {}));
          return SPRINGNET_OK;
        }) == SPRINGNET_FAILED);
  CHECK(std::string(host.text.text).find("older than ABI 1.4") != std::string::npos);
  CHECK(host.calls.empty());
}

namespace {

// Reports limits, or fails.
class Limited : public Integrator {
 public:
  static constexpr const char* id = "limited";
  static constexpr const char* summary = "reports limits";
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

}  // namespace

TEST_CASE("an integrator class with limits() reports them; one without has no such function") {
  const bool has_limits = functions.limits != nullptr;
  CHECK_FALSE(has_limits);
  const auto& limited = *static_cast<const springnet_integrator*>(ComponentEntry<Limited>::value.implementation);
  const bool reports = limited.limits != nullptr;
  REQUIRE(reports);
  FakeHost host;
  void* integrator = nullptr;
  REQUIRE(limited.create(&host.table, nullptr, &integrator) == SPRINGNET_OK);
  std::vector<std::string> reported;
  springnet_limits sink{sizeof sink, 0, &reported, [](void* context, const springnet_limit* limit) {
                          static_cast<std::vector<std::string>*>(context)->push_back(
                              std::string(limit->rule) + " " + std::to_string(limit->kind) + " " +
                              (limit->reason == nullptr ? std::to_string(limit->node) : limit->reason));
                        }};
  CHECK(limited.limits(integrator, &sink) == SPRINGNET_OK);
  CHECK(reported == std::vector<std::string>{"leap 1 3", " 2 4294967295", "hop 3 it is dark"});
  Limited::fails = true;
  CHECK(limited.limits(integrator, &sink) == SPRINGNET_FAILED);
  Limited::fails = false;
  CHECK(std::string(host.text.text) == "no derivatives");
  limited.destroy(integrator);
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
  CHECK(functions.create(&host.table, options.data(), &integrator) == SPRINGNET_FAILED);
  Scripted::read_undeclared = false;
  CHECK(integrator == nullptr);
  CHECK(host.states == 0);
  CHECK(std::string(host.text.text) == "the integrator reads an option that it does not declare: colour");

  host.out_of_memory = true;
  CHECK(functions.create(&host.table, options.data(), &integrator) == SPRINGNET_FAILED);
  host.out_of_memory = false;

  host.table.struct_size = 64;
  CHECK(functions.create(&host.table, options.data(), &integrator) == SPRINGNET_FAILED);
  CHECK(integrator == nullptr);
}

TEST_CASE("metadata of an integrator come from its class") {
  CHECK(scripted.kind == SPRINGNET_INTEGRATOR);
  CHECK(scripted.parameter_count == 4);
  CHECK(functions.struct_size == sizeof(springnet_integrator));
}
