#include "misdeeds.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace springnet::testing {
namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

springnet_state* another(const StepContext& h) {
  springnet_state* state = h.create_state();
  for (std::uint32_t k = 0; k < h.nodes(); ++k) {
    for (auto [to, from] :
         {std::pair{state->position, h.state->position}, std::pair{state->velocity, h.state->velocity}}) {
      to.x[k] = from.x[k];
      to.y[k] = from.y[k];
      to.z[k] = from.z[k];
    }
  }
  return state;
}

springnet_status commit(const StepContext& h, double time) { return h.commit(time, h.state); }

springnet_status solves_for_nothing(const StepContext& h) {
  const auto system = sdk::sized<springnet_solve>();
  return h.host->solve(h.context, &system);
}
springnet_status wants_blocks_nowhere(const StepContext& h) {
  auto blocks = sdk::sized<springnet_diagonal_blocks>();
  blocks.velocity_weight = blocks.position_weight = 1.0;
  return h.host->diagonal_blocks(h.context, &blocks);
}

// Commits a state that a change has spoilt.
Misdeed commits(std::function<void(springnet_state&)> change) {
  return [change = std::move(change)](const StepContext& h) {
    change(*h.state);
    return commit(h, h.until);
  };
}

// Evaluates a request that a change has spoilt, in all functions that take one.
std::vector<Case> requests(const char* name, std::function<void(springnet_evaluation&)> change) {
  std::vector<Case> cases;
  const auto add = [&](auto function) {
    cases.push_back({name, [=](const StepContext& h) {
                       springnet_evaluation at = h.at();
                       change(at);
                       return function(h, at);
                     }});
  };
  add([](const StepContext& h, const springnet_evaluation& at) { return h.host->evaluate(h.context, &at); });
  add([](const StepContext& h, const springnet_evaluation& at) { return h.linearise(&at); });
  add([](const StepContext& h, const springnet_evaluation& at) {
    const std::uint32_t node = 0;
    return h.evaluate_nodes(at, &node, 1);
  });
  add([](const StepContext& h, const springnet_evaluation& at) {
    std::vector<double> values(h.network().event_count + 1);
    return h.event_values(&at, values.data());
  });
  return cases;
}

Misdeed sweeps(std::function<void(springnet_sweep&)> change) {
  return [change = std::move(change)](const StepContext& h) {
    springnet_sweep sweep = h.sweep(*another(h));
    change(sweep);
    return h.host->sweep(h.context, &sweep);
  };
}
Misdeed sweeps_in(std::vector<std::uint32_t> order) {
  return [order = std::move(order)](const StepContext& h) {
    const springnet_sweep sweep = h.sweep_in(order);
    return h.host->sweep(h.context, &sweep);
  };
}
Misdeed sweeps_in_sets(std::vector<std::uint32_t> order, std::vector<std::uint32_t> set_start) {
  return [order = std::move(order), set_start = std::move(set_start)](const StepContext& h) {
    springnet_sweep sweep = h.sweep_in(order);
    sweep.set_start = set_start.data();
    sweep.set_count = static_cast<std::uint32_t>(set_start.size() - 1);
    return h.host->sweep(h.context, &sweep);
  };
}
// A sweep of the linearised network that a change has spoilt.
Misdeed sweeps_linearly(std::function<void(springnet_sweep&)> change) {
  return [change = std::move(change)](const StepContext& h) {
    const springnet_evaluation at = h.at();
    if (const springnet_status status = h.linearise(&at); status != SPRINGNET_OK) return status;
    std::vector<std::uint32_t> order(h.nodes());
    for (std::uint32_t k = 0; k < order.size(); ++k) order[k] = k;
    springnet_sweep sweep = h.sweep_in(order);
    change(sweep);
    return h.host->linear_sweep(h.context, &sweep);
  };
}
// A search for an eigenvalue that a change has spoilt.
Misdeed seeks_eigenvalue(std::function<void(springnet_eigenvalue_search&)> change) {
  return [change = std::move(change)](const StepContext& h) {
    double start[3] = {1.0, 2.0, 3.0};
    auto search = sdk::sized<springnet_eigenvalue_search>();
    search.size = 3;
    search.map = [](void*, const springnet_linear_image*) -> springnet_status { return SPRINGNET_OK; };
    search.start = start;
    search.tolerance = 1e-3;
    search.most_applications = 10;
    search.most_vectors = 3;
    change(search);
    return h.host->dominant_eigenvalue(h.context, &search);
  };
}
// Products by parameters with a request, or its only set, that a change has spoilt.
std::vector<Case> parameter_products(
    const char* name, std::function<void(springnet_parameter_product&, springnet_parameter_set&)> change) {
  using Function = springnet_status (*springnet_host::*)(void*, const springnet_parameter_product*);
  std::vector<Case> cases;
  for (const Function function : {&springnet_host::parameter_tangent, &springnet_host::parameter_cotangent})
    cases.push_back({name, [=](const StepContext& h) {
                       const springnet_evaluation at = h.at();
                       std::vector<double> forces(3 * h.nodes()), masses(h.nodes());
                       auto set = sdk::sized<springnet_parameter_set>();
                       set.kind = SPRINGNET_BY_MASS;
                       set.values = masses.data();
                       const springnet_parameter_set* const sets[] = {&set};
                       auto product = sdk::sized<springnet_parameter_product>();
                       product.at = &at;
                       product.sets = sets;
                       product.set_count = 1;
                       product.force = forces.data();
                       change(product, set);
                       return (h.host->*function)(h.context, &product);
                     }});
  return cases;
}
std::vector<Case> all_parameter_products() {
  using P = springnet_parameter_product;
  using S = springnet_parameter_set;
  std::vector<Case> cases;
  for (const std::vector<Case>&some :
       {parameter_products("differentiates at no state", [](P&p, S&) { p.at = nullptr; }),
        parameter_products("differentiates nothing", [](P&p, S&) { p.force = nullptr; }),
        parameter_products("differentiates by no sets", [](P&p, S&) { p.sets = nullptr; }),
        parameter_products("differentiates by a short set", [](P&, S&s) { s.struct_size = 24; }),
        parameter_products("differentiates by kind 0", [](P&, S&s) { s.kind = 0; }),
        parameter_products("differentiates by kind 99", [](P&, S&s) { s.kind = 99; }),
        parameter_products("differentiates by values nowhere", [](P&, S&s) { s.values = nullptr; }),
        parameter_products("differentiates by a signal that is not there",
                           [](P&, S&s) {
                             s.kind = SPRINGNET_BY_INPUT;
                             s.input = 0xffffffffu;
                           }),
        parameter_products("differentiates by a parameter without a name",
                           [](P&, S&s) { s.kind = SPRINGNET_BY_SPRING_PARAMETER; }),
        parameter_products("differentiates by a parameter of nothing", [](P&, S&s) {
          s.kind = SPRINGNET_BY_NEURON_PARAMETER;
          s.parameter = "weight of the soul";
        })})
    cases.insert(cases.end(), some.begin(), some.end());
  return cases;
}
// Every function with a request that is null or ends before its last field.
template <class Request>
void add_short(std::vector<Case>& cases, const char* name,
               springnet_status (*springnet_host::*function)(void*, Request*)) {
  using Value = std::remove_const_t<Request>;
  for (const std::uint32_t size : {0u, 4u, 8u, static_cast<std::uint32_t>(sizeof(Value)) - 8u})
    cases.push_back({name, [=](const StepContext& h) {
                       const springnet_evaluation at = h.at();
                       if (const springnet_status status = h.linearise(&at); status != SPRINGNET_OK) return status;
                       auto request = sdk::sized<Value>();
                       request.struct_size = size;
                       return (h.host->*function)(h.context, size == 0 ? nullptr : &request);
                     }});
}
std::vector<Case> short_requests() {
  std::vector<Case> cases;
  using H = springnet_host;
  add_short(cases, "a short network", &H::network);
  add_short(cases, "a short create_state", &H::create_state);
  add_short(cases, "a short committed", &H::committed);
  add_short(cases, "a short begin", &H::begin);
  add_short(cases, "a short evaluate", &H::evaluate);
  add_short(cases, "a short sweep", &H::sweep);
  add_short(cases, "a short linearise", &H::linearise);
  add_short(cases, "a short jacobian_times", &H::jacobian_times);
  add_short(cases, "a short change_internal", &H::change_internal);
  add_short(cases, "a short diagonal_blocks", &H::diagonal_blocks);
  add_short(cases, "a short factorise", &H::factorise);
  add_short(cases, "a short solve", &H::solve);
  add_short(cases, "a short prepare_system", &H::prepare_system);
  add_short(cases, "a short solve_system", &H::solve_system);
  add_short(cases, "a short linear_sweep", &H::linear_sweep);
  add_short(cases, "a short dominant_eigenvalue", &H::dominant_eigenvalue);
  add_short(cases, "a short event_values", &H::event_values);
  add_short(cases, "a short fire_events", &H::fire_events);
  add_short(cases, "a short next_discontinuity", &H::next_discontinuity);
  add_short(cases, "a short time_of_impact", &H::time_of_impact);
  add_short(cases, "a short commit", &H::commit);
  add_short(cases, "a short constrain", &H::constrain);
  add_short(cases, "a short project", &H::project);
  add_short(cases, "a short project_state", &H::project_state);
  add_short(cases, "a short report", &H::report);
  add_short(cases, "a short note", &H::note);
  add_short(cases, "a short deadline", &H::deadline);
  add_short(cases, "a short jacobian_transposed_times", &H::jacobian_transposed_times);
  add_short(cases, "a short parameter_tangent", &H::parameter_tangent);
  add_short(cases, "a short parameter_cotangent", &H::parameter_cotangent);
  add_short(cases, "a short event_derivative", &H::event_derivative);
  return cases;
}

// Calls something from the update of the nodes, and fails if that was let through.
Misdeed updates(std::function<springnet_status(const StepContext&)> call, bool ordered) {
  return [call = std::move(call), ordered](const StepContext& h) {
    struct User {
      const StepContext& hands;
      const std::function<springnet_status(const StepContext&)>& call;
      springnet_status status;
    } user{h, call, SPRINGNET_OK};
    std::vector<std::uint32_t> order(h.nodes());
    for (std::uint32_t k = 0; k < order.size(); ++k) order[k] = k;
    springnet_sweep sweep = ordered ? h.sweep_in(order) : h.sweep(*another(h));
    sweep.user = &user;
    sweep.update = [](void* data, const springnet_node_batch*) -> springnet_status {
      auto& self = *static_cast<User*>(data);
      self.status = std::max(self.status, self.call(self.hands));
      return SPRINGNET_OK;
    };
    const springnet_status status = h.host->sweep(h.context, &sweep);
    return status != SPRINGNET_OK ? status : user.status;
  };
}

}  // namespace

std::vector<Case> all_cases() {
  using sdk::sized;
  const auto nothing = springnet_vectors{nullptr, nullptr, nullptr};
  std::vector<Case> cases{
      {"commits nothing", [](const StepContext&) -> springnet_status { return SPRINGNET_OK; }, true, true},
      {"commits the past", [](const StepContext& h) { return commit(h, h.from - 1.0); }},
      {"commits the present", [](const StepContext& h) { return commit(h, h.from); }, true, true},
      {"commits a little", [](const StepContext& h) { return commit(h, h.from + 1e-3 * (h.until - h.from)); }, true,
       true},
      {"commits half", [](const StepContext& h) { return commit(h, 0.5 * (h.from + h.until)); }, true, true},
      {"commits a time beyond the end", [](const StepContext& h) { return commit(h, h.until + 1e-3); }},
      {"commits a time far beyond", [](const StepContext& h) { return commit(h, 1e300); }},
      {"commits nan s", [](const StepContext& h) { return commit(h, nan_value); }},
      {"commits inf s", [](const StepContext& h) { return commit(h, infinite); }},
      {"commits -inf s", [](const StepContext& h) { return commit(h, -infinite); }},
      {"commits a position of nan", commits([](springnet_state& s) { s.position.y[3] = nan_value; })},
      {"commits an infinite position", commits([](springnet_state& s) { s.position.x[5] = infinite; })},
      {"commits a velocity of nan", commits([](springnet_state& s) { s.velocity.z[1] = nan_value; })},
      {"commits an infinite velocity", commits([](springnet_state& s) { s.velocity.x[0] = -infinite; })},
      {"commits no state", [](const StepContext& h) { return h.commit(h.until, nullptr); }},
      {"commits a state of its own",
       [](const StepContext& h) {
         springnet_state own = *h.state;
         return h.commit(h.until, &own);
       }},
      {"commits what is committed",
       [](const StepContext& h) {
         double time = 0.0;
         return h.commit(h.until, const_cast<springnet_state*>(h.committed(&time)));
       }},
      {"commits a state that was destroyed",
       [](const StepContext& h) {
         springnet_state* state = another(h);
         h.destroy_state(state);
         return h.commit(h.until, state);
       }},
      {"destroys states twice, and others",
       [](const StepContext& h) {
         springnet_state* state = another(h);
         springnet_state own{};
         for (springnet_state* each : {state, state, &own, static_cast<springnet_state*>(nullptr)})
           h.destroy_state(each);
         double time = 0.0;
         h.destroy_state(const_cast<springnet_state*>(h.committed(&time)));
         return commit(h, h.until);
       },
       false},
      {"moves the arrays of a state", commits([](springnet_state& s) {
         s.position = s.velocity = {nullptr, nullptr, nullptr};
         s.force = s.position;
         s.struct_size = 3;
       }),
       false},
      {"claims forces that are none", commits([](springnet_state& s) {
         s.force_is_current = 1;
         s.force.x[2] = nan_value;
       }),
       false},
      {"commits twice",
       [](const StepContext& h) {
         static_cast<void>(commit(h, 0.5 * (h.from + h.until)));
         return commit(h, h.from);
       }},
      {"begins no step", [](const StepContext& h) { return h.begin(h.from, h.from); }},
      {"begins a step backwards", [](const StepContext& h) { return h.begin(h.until, h.from); }},
      {"begins at nan s", [](const StepContext& h) { return h.begin(nan_value, h.until); }},
      {"ends at nan s", [](const StepContext& h) { return h.begin(h.from, nan_value); }},
      {"evaluates nothing", [](const StepContext& h) { return h.host->evaluate(h.context, nullptr); }},
      {"linearises nothing", [](const StepContext& h) { return h.host->linearise(h.context, nullptr); }},
      {"linearises at no state", [](const StepContext& h) { return h.linearise(nullptr); }},
      {"eliminates over nan s",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         return h.linearise(&at, nan_value);
       }},
      {"eliminates over a negative time",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         return h.linearise(&at, -1.0);
       }},
      {"commits without a request", [](const StepContext& h) { return h.host->commit(h.context, nullptr); }},
      {"sweeps nothing", [](const StepContext& h) { return h.host->sweep(h.context, nullptr); }},
      {"constrains nothing", [](const StepContext& h) { return h.host->constrain(h.context, nullptr); }},
      {"evaluates a node that is not there",
       [](const StepContext& h) {
         const std::uint32_t nodes[] = {0, h.nodes()};
         const springnet_evaluation at = h.at();
         return h.evaluate_nodes(at, nodes, 2);
       }},
      {"evaluates node 4294967295",
       [](const StepContext& h) {
         const std::uint32_t node = 0xffffffffu;
         const springnet_evaluation at = h.at();
         return h.evaluate_nodes(at, &node, 1);
       }},
      {"evaluates 4294967295 nodes",
       [](const StepContext& h) {
         const std::uint32_t node = 0;
         const springnet_evaluation at = h.at();
         return h.evaluate_nodes(at, &node, 0xffffffffu);
       }},
      {"sweeps without an update", sweeps([](springnet_sweep& s) { s.update = nullptr; })},
      {"sweeps without positions", sweeps([](springnet_sweep& s) {
         s.position = {nullptr, nullptr, nullptr};
       })},
      {"sweeps without velocities", sweeps([](springnet_sweep& s) { s.velocity.z = nullptr; })},
      {"sweeps without a start", sweeps([](springnet_sweep& s) { s.start_position.y = nullptr; })},
      {"sweeps without start velocities", sweeps([](springnet_sweep& s) { s.start_velocity.y = nullptr; })},
      {"sweeps into nothing", sweeps([=](springnet_sweep& s) { s.next_position = nothing; })},
      {"sweeps velocities into nothing", sweeps([=](springnet_sweep& s) { s.next_velocity = nothing; })},
      {"sweeps with a part of the forces", sweeps([](springnet_sweep& s) { s.force.y = nullptr; })},
      {"sweeps half of the constraint forces", sweeps([](springnet_sweep& s) {
         s.constraint_force = {s.force.x, nullptr, s.force.z};
       })},
      {"sweeps at nan s", sweeps([](springnet_sweep& s) { s.time = nan_value; })},
      {"sweeps over inf s", sweeps([](springnet_sweep& s) { s.time_constant = infinite; })},
      {"sweeps with theta nan", sweeps([](springnet_sweep& s) { s.theta = nan_value; })},
      {"sweeps a short struct", sweeps([](springnet_sweep& s) { s.struct_size = 8; })},
      {"sweeps in place without an order",
       [](const StepContext& h) {
         const springnet_sweep sweep = h.sweep(*h.state);
         return h.host->sweep(h.context, &sweep);
       }},
      {"sweeps in an order into other arrays",
       [](const StepContext& h) {
         const std::vector<std::uint32_t> order{0, 1, 2};
         springnet_sweep sweep = h.sweep_in(order);
         springnet_state* next = another(h);
         sweep.next_position = next->position;
         sweep.next_velocity = next->velocity;
         return h.host->sweep(h.context, &sweep);
       }},
      {"sweeps node 6 of 6", sweeps_in({0, 1, 6})},
      {"sweeps node 4294967295", sweeps_in({0xffffffffu})},
      {"sweeps a node twice", sweeps_in({0, 1, 2, 1})},
      {"sweeps an order of 4294967295",
       [](const StepContext& h) {
         const std::vector<std::uint32_t> order{0};
         springnet_sweep sweep = h.sweep_in(order);
         sweep.order_count = 0xffffffffu;
         return h.host->sweep(h.context, &sweep);
       }},
      {"sweeps sets that fall", sweeps_in_sets({0, 2, 4, 1}, {0, 3, 1, 4})},
      {"sweeps sets beyond the order", sweeps_in_sets({0, 2, 4, 1}, {0, 9, 4})},
      {"sweeps sets that leave nodes out", sweeps_in_sets({0, 2, 4, 1}, {0, 3})},
      {"sweeps sets that begin late", sweeps_in_sets({0, 2, 4, 1}, {1, 4})},
      {"sweeps sets of nodes that are joined", sweeps_in_sets({0, 1, 2, 3, 4, 5}, {0, 6})},
      {"sweeps sets of nodes that do not rise", sweeps_in_sets({4, 2, 0}, {0, 3})},
      {"sweeps a set whose first nodes do not rise", sweeps_in_sets({2, 0, 4}, {0, 3})},
      {"sweeps 4294967295 sets",
       [](const StepContext& h) {
         const std::vector<std::uint32_t> order{0};
         const std::uint32_t start[] = {0, 1};
         springnet_sweep sweep = h.sweep_in(order);
         sweep.set_start = start;
         sweep.set_count = 0xffffffffu;
         return h.host->sweep(h.context, &sweep);
       }},
      {"multiplies before it linearises",
       [](const StepContext& h) {
         std::vector<double> x(3 * h.nodes());
         return h.jacobian_times(x.data(), x.data(), x.data());
       }},
      {"multiplies transposed before it linearises",
       [](const StepContext& h) {
         std::vector<double> x(9 * h.nodes());
         auto product = sdk::sized<springnet_transposed_product>();
         product.weights = x.data();
         product.by_position = x.data() + 3 * h.nodes();
         product.by_velocity = x.data() + 6 * h.nodes();
         return h.host->jacobian_transposed_times(h.context, &product);
       }},
      {"projects in an unknown way",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         static_cast<void>(h.linearise(&at));
         std::vector<double> x(3 * h.nodes());
         auto projection = sdk::sized<springnet_projection>();
         projection.values = x.data();
         projection.kind = 4;
         return h.host->project(h.context, &projection);
       }},
      {"differentiates event 4294967295",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         auto derivative = sdk::sized<springnet_event_derivative>();
         derivative.at = &at;
         derivative.event = 0xffffffffu;
         return h.host->event_derivative(h.context, &derivative);
       }},
      {"projects before it linearises",
       [](const StepContext& h) {
         std::vector<double> x(3 * h.nodes());
         return h.project(x.data());
       }},
      {"factorises nan",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         static_cast<void>(h.linearise(&at));
         return h.factorise(nan_value, 1.0);
       }},
      {"solves for nothing",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         static_cast<void>(h.linearise(&at));
         static_cast<void>(h.factorise(0.1, 0.01));
         return solves_for_nothing(h);
       }},
      {"multiplies nothing",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         static_cast<void>(h.linearise(&at));
         return h.jacobian_times(nullptr, nullptr, nullptr);
       }},
      {"wants blocks nowhere",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         static_cast<void>(h.linearise(&at));
         return wants_blocks_nowhere(h);
       }},
      {"projects nothing",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         static_cast<void>(h.linearise(&at));
         return h.project(nullptr);
       }},
      {"projects no state", [=](const StepContext& h) { return h.project_state(h.until, nothing, h.state->velocity); }},
      {"projects at nan s",
       [](const StepContext& h) { return h.project_state(nan_value, h.state->position, h.state->velocity); }},
      {"asks for events nowhere",
       [](const StepContext& h) {
         const springnet_evaluation at = h.at();
         return h.event_values(&at, nullptr);
       }},
      {"fires nothing", [](const StepContext& h) { return h.fire_events(h.until, h.state, nullptr); }},
      {"fires on no state",
       [](const StepContext& h) {
         const std::vector<std::int32_t> fired(h.network().event_count);
         return h.fire_events(h.until, nullptr, fired.data());
       }},
      {"fires at nan s",
       [](const StepContext& h) {
         const std::vector<std::int32_t> fired(h.network().event_count);
         return h.fire_events(nan_value, h.state, fired.data());
       }},
      {"fires all events there are",
       [](const StepContext& h) {
         const std::vector<std::int32_t> fired(h.network().event_count, 1);
         const springnet_status status = h.fire_events(h.until, h.state, fired.data());
         return status == SPRINGNET_OK ? commit(h, h.until) : status;
       },
       false},
      {"searches nothing for touches", [](const StepContext& h) { return h.host->time_of_impact(h.context, nullptr); }},
      {"searches a step that goes back",
       [](const StepContext& h) {
         springnet_impact_search search = h.search();
         std::swap(search.step_from, search.step_until);
         return h.host->time_of_impact(h.context, &search);
       }},
      {"searches a part that is none",
       [](const StepContext& h) {
         springnet_impact_search search = h.search();
         search.until = nan_value;
         return h.host->time_of_impact(h.context, &search);
       }},
      {"searches in front of surfaces",
       [](const StepContext& h) {
         springnet_impact_search search = h.search();
         search.depth = -1.0;
         return h.host->time_of_impact(h.context, &search);
       }},
      {"searches and knows no states",
       [](const StepContext& h) {
         springnet_impact_search search = h.search();
         search.state_at = nullptr;
         return h.host->time_of_impact(h.context, &search);
       }},
      {"searches among states that are no numbers",
       [](const StepContext& h) {
         springnet_impact_search search = h.search();
         const springnet_status status = h.host->time_of_impact(h.context, &search);
         return status == SPRINGNET_OK && std::isnan(search.time) ? commit(h, h.until) : status;
       },
       false},
      {"sweeps linearly before it linearised",
       [](const StepContext& h) {
         const std::vector<std::uint32_t> order{0};
         const springnet_sweep sweep = h.sweep_in(order);
         return h.host->linear_sweep(h.context, &sweep);
       }},
      {"sweeps linearly in no order", sweeps_linearly([](springnet_sweep& s) { s.order = nullptr; })},
      {"sweeps linearly without an update", sweeps_linearly([](springnet_sweep& s) { s.update = nullptr; })},
      {"sweeps linearly in a step of nothing", sweeps_linearly([](springnet_sweep& s) { s.time_constant = 0.0; })},
      {"sweeps linearly in a step of nan s", sweeps_linearly([](springnet_sweep& s) { s.time_constant = nan_value; })},
      {"sweeps linearly a short struct", sweeps_linearly([](springnet_sweep& s) { s.struct_size = 288; })},
      {"sweeps linearly without velocities", sweeps_linearly([](springnet_sweep& s) { s.velocity.y = nullptr; })},
      {"sweeps linearly to somewhere else",
       sweeps_linearly([](springnet_sweep& s) { s.next_velocity = s.next_position; })},
      {"sweeps linearly a node that is none",
       sweeps_linearly([](springnet_sweep& s) { const_cast<std::uint32_t*>(s.order)[0] = 0xffffffffu; })},
      {"seeks no eigenvalue", [](const StepContext& h) { return h.host->dominant_eigenvalue(h.context, nullptr); }},
      {"seeks the eigenvalue of no map", seeks_eigenvalue([](auto& s) { s.map = nullptr; })},
      {"seeks an eigenvalue of another kind", seeks_eigenvalue([](auto& s) { s.wanted = 7; })},
      {"seeks an eigenvalue from nowhere", seeks_eigenvalue([](auto& s) { s.start = nullptr; })},
      {"seeks an eigenvalue from 0", seeks_eigenvalue([](auto& s) { std::fill_n(s.start, 3, 0.0); })},
      {"seeks an eigenvalue from nan", seeks_eigenvalue([](auto& s) { s.start[1] = nan_value; })},
      {"seeks an eigenvalue to a tolerance of 0", seeks_eigenvalue([](auto& s) { s.tolerance = 0.0; })},
      {"seeks an eigenvalue without memory", seeks_eigenvalue([](auto& s) { s.most_vectors = 0; })},
      {"reports and notes nothing",
       [](const StepContext& h) {
         h.report_number(nullptr, nan_value);
         h.note(nullptr);
         auto next = sized<springnet_discontinuity>();
         next.after = nan_value;
         static_cast<void>(h.host->next_discontinuity(h.context, &next));
         return commit(h, h.until);
       },
       false},
      {"reports and notes nonsense",
       [](const StepContext& h) {
         for (int k = 0; k < 3000; ++k) {
           const std::string name = "\x1b[31m\xff" + std::to_string(k) + std::string(5000, '\n');
           h.report_number(name.c_str(), infinite);
           h.note(name.c_str());
         }
         return commit(h, h.until);
       },
       false},
      {"calls without a context",
       [](const StepContext& h) -> springnet_status {
         const springnet_evaluation at = h.at();
         const springnet_host& t = *h.host;
         auto query = sized<springnet_network_query>();
         auto creation = sized<springnet_state_creation>();
         auto committed = sized<springnet_committed>();
         auto commitment = sized<springnet_commitment>();
         commitment.time = h.until;
         commitment.state = h.state;
         auto interval = sized<springnet_interval>();
         interval.until = 1.0;
         auto number = sized<springnet_number_report>();
         number.name = "a";
         auto text = sized<springnet_user_note>();
         text.text = "a";
         auto next = sized<springnet_discontinuity>();
         auto left = sized<springnet_deadline>();
         const springnet_status all[] = {
             t.network(nullptr, &query),  t.create_state(nullptr, &creation), t.committed(nullptr, &committed),
             t.evaluate(nullptr, &at),    t.commit(nullptr, &commitment),     t.sweep(nullptr, nullptr),
             t.begin(nullptr, &interval), t.destroy_state(nullptr, h.state),  t.report(nullptr, &number),
             t.note(nullptr, &text),      t.deadline(nullptr, &left),         t.next_discontinuity(nullptr, &next)};
         const bool harmless =
             std::all_of(std::begin(all), std::end(all), [](springnet_status s) { return s == SPRINGNET_FAILED; });
         return harmless ? commit(h, h.until) : SPRINGNET_FAILED;
       },
       false},
      {"fails silently", [](const StepContext&) -> springnet_status { return SPRINGNET_FAILED; }},
      {"returns 77", [](const StepContext&) -> springnet_status { return 77; }},
      {"returns that nothing settled", [](const StepContext&) -> springnet_status { return SPRINGNET_UNSETTLED; }},
      {"fills the message",
       [](const StepContext& h) -> springnet_status {
         springnet_message& message = *h.host->message;
         std::fill_n(message.text, sizeof message.text, '\x1b');
         return SPRINGNET_FAILED;
       },
       false},
      {"spoils the report",
       [](const StepContext& h) {
         *h.report = {};
         h.report->outcome = -5;
         h.report->steps = h.report->sweeps = h.report->substeps = h.report->stages = ~std::uint64_t{0};
         h.report->force_difference = h.report->residual = nan_value;
         h.report->node = h.report->start_node = 0xfffffff0u;
         return commit(h, h.until);
       },
       false},
      {"throws", [](const StepContext&) -> springnet_status { throw std::runtime_error("\x1b[5mthrown"); }},
      {"throws nothing", [](const StepContext&) -> springnet_status { throw std::runtime_error(""); }},
      {"throws a number", [](const StepContext&) -> springnet_status { throw 7; }},
      {"throws in an update",
       updates([](const StepContext&) -> springnet_status { throw std::runtime_error("thrown"); }, false), false},
      {"throws in an ordered update",
       updates([](const StepContext&) -> springnet_status { throw std::runtime_error("thrown"); }, true), false},
      {"throws a number in an update", updates([](const StepContext&) -> springnet_status { throw 7; }, false), false},
      {"updates that fail",
       [](const StepContext& h) {
         springnet_sweep sweep = h.sweep(*another(h));
         sweep.update = [](void*, const springnet_node_batch*) -> springnet_status { return SPRINGNET_FAILED; };
         const springnet_status status = h.host->sweep(h.context, &sweep);
         return status == SPRINGNET_OK ? commit(h, h.until) : status;
       },
       false},
      {"updates that note and report",
       updates(
           [](const StepContext& h) -> springnet_status {
             h.note("from an update");
             h.report_number("updates", 1.0);
             return SPRINGNET_OK;
           },
           false),
       false},
  };
  // What changes the host may not be called from within a sweep.
  for (const bool ordered : {false, true}) {
    const auto add = [&](const char* name, Misdeed call) {
      cases.push_back({name, updates(std::move(call), ordered)});
    };
    add("commits in an update", [](const StepContext& h) { return commit(h, h.until); });
    add("sweeps in an update", [](const StepContext& h) {
      const std::vector<std::uint32_t> order{0};
      const springnet_sweep sweep = h.sweep_in(order);
      return h.host->sweep(h.context, &sweep);
    });
    add("evaluates in an update", [](const StepContext& h) {
      const springnet_evaluation at = h.at();
      return h.host->evaluate(h.context, &at);
    });
    add("linearises in an update", [](const StepContext& h) {
      const springnet_evaluation at = h.at();
      return h.linearise(&at);
    });
    add("begins a step in an update", [](const StepContext& h) { return h.begin(h.from, h.until); });
    add("makes a state in an update", [](const StepContext& h) -> springnet_status {
      return h.create_state() == nullptr ? SPRINGNET_FAILED : SPRINGNET_OK;
    });
  }
  const auto spoil = [&](const char* name, std::function<void(springnet_evaluation&)> change) {
    for (Case& each : requests(name, std::move(change))) cases.push_back(std::move(each));
  };
  spoil("asks at nan s", [](springnet_evaluation& at) { at.time = nan_value; });
  spoil("asks at inf s", [](springnet_evaluation& at) { at.time = infinite; });
  spoil("asks without positions", [](springnet_evaluation& at) { at.position.z = nullptr; });
  spoil("asks without velocities", [](springnet_evaluation& at) { at.velocity = {nullptr, nullptr, nullptr}; });
  spoil("asks for a part of the forces", [=](springnet_evaluation& at) {
    at.force = {nullptr, const_cast<double*>(at.position.x), nullptr};
  });
  spoil("asks for a part of the accelerations",
        [](springnet_evaluation& at) { at.acceleration.x = const_cast<double*>(at.position.x); });
  spoil("asks with a short struct", [](springnet_evaluation& at) { at.struct_size = 16; });
  spoil("asks with a short struct of internal state", [](springnet_evaluation& at) {
    static constexpr springnet_internal little{8, 0, 0.0, nullptr, nullptr, nullptr};
    at.internal = &little;
  });
  for (Case& each : short_requests()) cases.push_back(std::move(each));
  for (Case& each : all_parameter_products()) cases.push_back(std::move(each));
  for (Case& each : cases_2_1()) cases.push_back(std::move(each));
  return cases;
}

}  // namespace springnet::testing
