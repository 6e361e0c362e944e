// A network at a state, through the host's table: forces, accelerations and their derivatives, and differences of them.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include <springnet/sdk/host.hpp>

#include "nets.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"

namespace springnet::testing {

using Values = std::vector<double>;

inline Eigen::VectorXd random_vector(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Eigen::VectorXd result(static_cast<Eigen::Index>(size));
  for (double& value : result) value = unit(random);
  return result;
}

// Central differences of sixth order of f at 0: truncation of about h^6 f^(7) / 140, rounding of about 2 eps f / h.
template <class F>
[[nodiscard]] Eigen::VectorXd difference(const F& f, double h = 2e-3) {
  const auto pair = [&](int i) { return Eigen::VectorXd(f(i * h) - f(-i * h)); };
  return (45.0 * pair(1) - 9.0 * pair(2) + pair(3)) / (60.0 * h);
}

// Accuracy of differences of functions of size 1 with derivatives of size 1: rounding, 4e-13 / h, and truncation, with
// h = 2e-3 below that; times some hundred terms and derivatives that are greater.
inline constexpr double of_differences = 2e-8;
// Of sums of some hundred terms in another order, relative to the sum of their sizes.
inline constexpr double of_sums = 1e-12;

// State: that of the network at its start unless changed. Numbers of nodes are the engine's.
class HostAt {
 public:
  explicit HostAt(const Network& net, std::shared_ptr<const PluginHost> laws = plugins(), unsigned threads = 1)
      : engine(net, *laws, options(threads)), table(make_host_table(engine)), host(table) {
    host.begin_interval(0.0, 0.2);
    const sdk::Committed committed = host.committed();
    const springnet_state& state = committed.state;
    position.resize(static_cast<Eigen::Index>(3 * node_count()));
    velocity.resize(position.size());
    const double* const from[] = {state.position.x, state.position.y, state.position.z,
                                  state.velocity.x, state.velocity.y, state.velocity.z};
    for (std::size_t c = 0; c < 3; ++c) {
      std::copy_n(from[c], node_count(), position.data() + c * node_count());
      std::copy_n(from[3 + c], node_count(), velocity.data() + c * node_count());
    }
    internal.assign(state.internal, state.internal + host.network().internal_count);
  }

  [[nodiscard]] std::size_t node_count() const { return engine.model().node_count(); }
  // The same state as that of another host of the same net but for its parameters.
  void take_state(const HostAt& other) {
    position = other.position;
    velocity = other.velocity;
    internal = other.internal;
    // Where steps of internal states start; laws may have begun with others.
    std::copy(internal.begin(), internal.end(), engine.model().state.view.internal);
    time = other.time;
    time_step = other.time_step;
    order = other.order;
  }
  // The evaluation; valid until the next call. `out`: of internal states, or null.
  const springnet_evaluation& evaluation(double* out = nullptr) {
    const std::size_t n = node_count();
    at_ = sdk::sized<springnet_evaluation>();
    at_.time = time;
    at_.position = {position.data(), position.data() + n, position.data() + 2 * n};
    at_.velocity = {velocity.data(), velocity.data() + n, velocity.data() + 2 * n};
    if (!internal.empty()) {
      states_ = sdk::sized<springnet_internal>();
      states_.order = order;
      states_.time_step = time_step;
      if (time_step > 0.0)
        states_.next = out;
      else
        states_.values = internal.data(), states_.rates = out;
      at_.internal = &states_;
    }
    return at_;
  }
  // Forces, accelerations, and rates of internal states or, with a time step, these at its end.
  struct Answer {
    Eigen::VectorXd force, acceleration, internal;
    [[nodiscard]] Eigen::VectorXd all() const {
      Eigen::VectorXd result(force.size() + acceleration.size() + internal.size());
      result << force, acceleration, internal;
      return result;
    }
  };
  [[nodiscard]] Answer zero() const {
    return {Eigen::VectorXd::Zero(position.size()), Eigen::VectorXd::Zero(position.size()),
            Eigen::VectorXd::Zero(static_cast<Eigen::Index>(internal.size()))};
  }
  [[nodiscard]] Answer evaluate() {
    const std::size_t n = node_count();
    Answer answer = zero();
    springnet_evaluation wanted = evaluation(answer.internal.data());
    wanted.force = {answer.force.data(), answer.force.data() + n, answer.force.data() + 2 * n};
    wanted.acceleration = {answer.acceleration.data(), answer.acceleration.data() + n,
                           answer.acceleration.data() + 2 * n};
    host.evaluate(wanted);
    return answer;
  }
  [[nodiscard]] sdk::Host::ParameterArrays arrays(Answer& answer) const {
    return {answer.force.data(), answer.acceleration.data(), internal.empty() ? nullptr : answer.internal.data()};
  }

  Engine engine;
  springnet_host table;
  sdk::Host host;
  Eigen::VectorXd position, velocity;  // [3 node], x of all nodes first
  Values internal;
  double time = 0.0, time_step = 0.0;  // s; time_step: of internal states
  std::uint32_t order = 1;

 private:
  static SimulationOptions options(unsigned threads) {
    SimulationOptions result;
    result.time_step = 1e-3;
    result.threads = threads;
    return result;
  }
  springnet_evaluation at_{};
  springnet_internal states_{};
};

// A network that depends on sets of parameters, and where these are in the host's numbers.
struct Parametrised {
  struct Set {
    sdk::Host::ParameterSet set;  // without its values
    Values values;                // by springs, elements or the user's numbers of nodes, or one
    bool of_nodes = false;
  };
  std::vector<Set> sets;
  std::function<Network(const std::vector<Set>&)> make;
  std::shared_ptr<const PluginHost> laws = plugins();
  bool time_moves = false;  // the time itself is a set, the last one

  [[nodiscard]] Network net() const { return make(sets); }
};

// Tangent against differences along random directions, of each set by itself and of all; cotangent against the tangent.
// `stir` changes the state of the host.
inline void check_parameters(const Parametrised& given, const std::function<void(HostAt&)>& stir = {}) {
  HostAt at(given.net(), given.laws);
  if (stir) stir(at);
  const double scale = std::max(1.0, at.evaluate().all().norm());
  std::vector<Eigen::VectorXd> directions;
  for (std::size_t i = 0; i < given.sets.size(); ++i) {
    directions.push_back(random_vector(given.sets[i].values.size(), static_cast<unsigned>(7 + i)));
    for (std::size_t j = 0; j < given.sets[i].values.size(); ++j)
      directions.back()[static_cast<Eigen::Index>(j)] *= std::max(0.1, std::abs(given.sets[i].values[j]));
  }
  for (std::size_t which = 0; which <= given.sets.size(); ++which) {
    const auto is_in = [&](std::size_t i) { return which == given.sets.size() || which == i; };
    const auto moved = [&](double h) {
      std::vector<Parametrised::Set> sets = given.sets;
      for (std::size_t i = 0; i < sets.size(); ++i)
        for (std::size_t j = 0; is_in(i) && j < sets[i].values.size(); ++j)
          sets[i].values[j] += h * directions[i][static_cast<Eigen::Index>(j)];
      HostAt other(given.make(sets), given.laws);
      other.take_state(at);
      if (given.time_moves) other.time += sets.back().values[0] - given.sets.back().values[0];
      REQUIRE(other.engine.model().layout.ordering().user == at.engine.model().layout.ordering().user);
      return other.evaluate().all();
    };
    // In the engine's numbers.
    std::vector<Values> storage;
    std::vector<sdk::Host::ParameterSet> sets;
    storage.reserve(given.sets.size());
    const std::vector<std::uint32_t>& user = at.engine.model().layout.ordering().user;
    for (std::size_t i = 0; i < given.sets.size(); ++i) {
      if (!is_in(i)) continue;
      Values& values = storage.emplace_back(directions[i].data(), directions[i].data() + directions[i].size());
      for (std::size_t k = 0; given.sets[i].of_nodes && k < user.size(); ++k)
        values[k] = directions[i][static_cast<Eigen::Index>(user[k])];
      sets.push_back(given.sets[i].set);
      sets.back().values = values;
    }
    HostAt::Answer tangent = at.zero();
    at.host.parameter_tangent(at.evaluation(), sets, at.arrays(tangent));
    const Eigen::VectorXd expected = difference(moved);
    CAPTURE(which);
    if (which == given.sets.size()) CHECK(expected.norm() > 1e-4 * scale);  // else nothing is compared
    CHECK((tangent.all() - expected).norm() <= of_differences * (scale + expected.norm()));

    HostAt::Answer weights{random_vector(static_cast<std::size_t>(tangent.force.size()), 100),
                           random_vector(static_cast<std::size_t>(tangent.force.size()), 101),
                           random_vector(at.internal.size(), 102)};
    std::vector<Values> answers;
    answers.reserve(sets.size());
    for (sdk::Host::ParameterSet& set : sets) set.values = answers.emplace_back(set.values.size(), 0.0);
    at.host.parameter_cotangent(at.evaluation(), sets, at.arrays(weights));
    double product = 0.0, size = 0.0;
    for (std::size_t i = 0; i < sets.size(); ++i)
      for (std::size_t j = 0; j < answers[i].size(); ++j) {
        product += answers[i][j] * storage[i][j];
        size += std::abs(answers[i][j] * storage[i][j]);
      }
    size += weights.all().cwiseAbs().dot(tangent.all().cwiseAbs());
    // The other term: where all derivatives are 0 but for the rounding of terms that cancel.
    CHECK(std::abs(product - weights.all().dot(tangent.all())) <= of_sums * size + 1e-15 * scale);
  }
}

}  // namespace springnet::testing
