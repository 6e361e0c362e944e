// The linear systems that the host prepares and solves, through its table, next to the same systems as dense matrices.
#pragma once

#include <limits>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include <springnet/sdk/host.hpp>

#include "nets.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"

namespace springnet::testing {

class PreparedSystem {
 public:
  // The state is the network's at its start, moved by up to `stir` m at random.
  explicit PreparedSystem(const Network& net, unsigned threads = 1, InstructionSet set = InstructionSet::best,
                          double stir = 0.0)
      : engine(net, *plugins(), options(threads, set)), table(make_host_table(engine)) {
    auto interval = sdk::sized<springnet_interval>();
    interval.until = 1e-3;
    REQUIRE(table.begin(table.context, &interval) == SPRINGNET_OK);
    auto committed = sdk::sized<springnet_committed>();
    REQUIRE(table.committed(table.context, &committed) == SPRINGNET_OK);
    const springnet_state* state = committed.state;
    time = committed.time;
    const std::size_t n = node_count();
    const double* position[3] = {state->position.x, state->position.y, state->position.z};
    const double* velocity[3] = {state->velocity.x, state->velocity.y, state->velocity.z};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (std::size_t c = 0; c < 3; ++c) {
      p[c].assign(position[c], position[c] + n);
      v[c].assign(velocity[c], velocity[c] + n);
      for (std::size_t k = 0; k < n; ++k)
        if (!constrained(k)) p[c][k] += stir * unit(random);
    }
  }

  [[nodiscard]] std::size_t node_count() const { return engine.model().node_count(); }
  [[nodiscard]] bool constrained(std::size_t node) const { return engine.model().contact.constrained()[node] != 0; }
  [[nodiscard]] springnet_evaluation evaluation() const {
    springnet_evaluation at{};
    at.struct_size = sizeof at;
    at.time = time;
    at.position = {p[0].data(), p[1].data(), p[2].data()};
    at.velocity = {v[0].data(), v[1].data(), v[2].data()};
    return at;
  }

  springnet_status linearise(const springnet_evaluation& at, double elimination = 0.0) {
    auto request = sdk::sized<springnet_linearisation>();
    request.at = &at;
    request.elimination = elimination;
    return table.linearise(table.context, &request);
  }
  springnet_status factorise(double velocity_weight, double position_weight) {
    auto request = sdk::sized<springnet_factorisation>();
    request.velocity_weight = velocity_weight;
    request.position_weight = position_weight;
    return table.factorise(table.context, &request);
  }
  // With the factors of the integrator's own.
  springnet_status solve_factorised(const double* right_side, double* solution) {
    auto request = sdk::sized<springnet_solve>();
    request.right_side = right_side;
    request.x = solution;
    return table.solve(table.context, &request);
  }
  springnet_status prepare(double velocity_weight, double position_weight, double shift = 0.0, bool exact = true,
                           bool at_state = true) {
    const springnet_evaluation at = evaluation();
    springnet_linear_system system{};
    system.struct_size = sizeof system;
    system.exact = exact ? 1 : 0;
    system.velocity_weight = velocity_weight;
    system.position_weight = position_weight;
    system.shift = shift;
    system.at = at_state ? &at : nullptr;
    weights = {velocity_weight, position_weight, shift};
    return table.prepare_system(table.context, &system);
  }
  // b: [3 node], x of all nodes first.
  springnet_status solve(const Eigen::VectorXd& b, double accuracy) {
    x = Eigen::VectorXd::Constant(b.size(), std::numeric_limits<double>::quiet_NaN());
    answer = {};
    answer.struct_size = sizeof answer;
    answer.right_side = b.data();
    answer.x = x.data();
    answer.accuracy = accuracy;
    return table.solve_system(table.context, &answer);
  }
  [[nodiscard]] std::string message() const { return engine.model().journal.message.text; }

  [[nodiscard]] Eigen::VectorXd right_side(unsigned seed = 1) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    Eigen::VectorXd b(static_cast<Eigen::Index>(3 * node_count()));
    for (double& value : b) value = unit(random);
    return b;
  }

  // A u, without what constraints do to it; needs derivatives. Zero for nodes that do not move, whose u must be 0.
  [[nodiscard]] Eigen::VectorXd times(const Eigen::VectorXd& u) {
    Eigen::VectorXd dv = weights.velocity * u, dp = weights.position * u, change(u.size());
    engine.linear().matrices().times(dp.data(), dv.data(), change.data());
    change = (1.0 + weights.shift) * u - change;
    zero_constrained(change);
    return change;
  }
  void zero_constrained(Eigen::VectorXd& values) const {
    const std::size_t n = node_count();
    for (std::size_t i = 0; i < 3 * n; ++i)
      if (constrained(i % n)) values[static_cast<Eigen::Index>(i)] = 0.0;
  }
  // A, column by column; rows and columns of nodes that do not move are those of the identity.
  [[nodiscard]] Eigen::MatrixXd dense() {
    const auto size = static_cast<Eigen::Index>(3 * node_count());
    Eigen::MatrixXd a(size, size);
    for (Eigen::Index j = 0; j < size; ++j) {
      const bool fixed = constrained(static_cast<std::size_t>(j) % node_count());
      a.col(j) = fixed ? Eigen::VectorXd(Eigen::VectorXd::Unit(size, j)) : times(Eigen::VectorXd::Unit(size, j));
    }
    return a;
  }
  // G, [row][3 node].
  [[nodiscard]] Eigen::MatrixXd rows() const {
    const std::vector<ConstraintRow>& given = engine.model().constraints.rows();
    const auto n = static_cast<Eigen::Index>(node_count());
    Eigen::MatrixXd g = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(given.size()), 3 * n);
    for (std::size_t r = 0; r < given.size(); ++r)
      for (Eigen::Index c = 0; c < 3; ++c) {
        const auto row = static_cast<Eigen::Index>(r);
        if (!constrained(given[r].first)) g(row, c * n + given[r].first) = given[r].direction[c];
        if (given[r].second != ConstraintRow::no_node && !constrained(given[r].second))
          g(row, c * n + given[r].second) = -given[r].direction[c];
      }
    return g;
  }
  [[nodiscard]] Eigen::VectorXd masses() const {
    const auto n = static_cast<Eigen::Index>(node_count());
    return Eigen::Map<const Eigen::VectorXd>(engine.model().mass.data(), n).replicate(3, 1);
  }
  // The x with M A x + G^T (multipliers) = M b and G x = 0.
  [[nodiscard]] Eigen::VectorXd reference(Eigen::VectorXd b) {
    zero_constrained(b);
    const Eigen::MatrixXd a = dense(), g = rows();
    const Eigen::VectorXd m = masses();
    const Eigen::Index n = a.rows(), r = g.rows();
    Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(n + r, n + r);
    whole.topLeftCorner(n, n) = m.asDiagonal() * a;
    whole.topRightCorner(n, r) = g.transpose();
    whole.bottomLeftCorner(r, n) = g;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n + r);
    right.head(n) = m.cwiseProduct(b);
    return Eigen::FullPivLU<Eigen::MatrixXd>(whole).solve(right).head(n);
  }
  // |M^1/2 (b - A x)| / |M^1/2 b|: the norm in which accuracy is asked for, without constraint rows.
  [[nodiscard]] double residual_of(Eigen::VectorXd b, const Eigen::VectorXd& solution) {
    zero_constrained(b);
    const Eigen::VectorXd root = masses().cwiseSqrt();
    return root.cwiseProduct(b - times(solution)).norm() / root.cwiseProduct(b).norm();
  }

  Engine engine;
  springnet_host table;
  double time = 0.0;
  std::vector<double> p[3], v[3];
  layers::SystemWeights weights;
  springnet_linear_solve answer{};
  Eigen::VectorXd x;

 private:
  static SimulationOptions options(unsigned threads, InstructionSet set) {
    SimulationOptions result;
    result.time_step = 1e-3;
    result.threads = threads;
    result.instruction_set = set;
    return result;
  }
};

}  // namespace springnet::testing
