#include <springnet/reaction_derivatives.hpp>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <springnet/error.hpp>
#include <springnet/sdk/host.hpp>

#include "learning/learned_values.hpp"
#include "simulation/embedding_changes.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"

namespace springnet {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// An engine with the calls of integrators.
struct Called {
  Called(const Network& network, const PluginHost& plugins, const SimulationOptions& options)
      : engine(network, plugins, options), table(make_host_table(engine)), host(table) {}
  Engine engine;
  springnet_host table;
  sdk::Host host;
};

}  // namespace

// In `free` no node is fixed or moved, and nothing is in its way, so that its accelerations, and all of their
// derivatives, are those of nodes that nothing holds. `given` has the accelerations of motions.
struct ReactionDerivatives::Impl {
  Impl(const Network& network, const PluginHost& plugins, const SimulationOptions& options,
       std::vector<LearnedValues> values)
      : free(network.without_constraints(), plugins, options), count(network.nodes().size()), pinned(count, 0) {
    if (!network.rigids().empty())
      throw Error(ErrorKind::input, "learning: reactions of nets with rigid connections are not differentiated");
    if (free.host.network().internal_count > 0)
      throw Error(ErrorKind::input, "learning: reactions of laws with internal states are not differentiated");
    if (!network.changes().empty())
      throw Error(ErrorKind::input,
                  "learning: reactions of a net that changes while it runs ([[change]]) are not differentiated");
    if (!network.moves().empty()) given.emplace(network, plugins, options);
    for (NodeIndex k = 0; k < count; ++k) pinned[k] = network.nodes()[k].fixed ? 1 : 0;
    for (const Move& move : network.moves())
      for (const NodeIndex node : move.nodes) pinned[node] = 1;
    for (NodeIndex k = 0; k < count; ++k)
      if (pinned[k] != 0) set_fixed(free.engine.model(), number_in(free)[k], false);
    std::size_t next = 0;
    for (const LearnedValues& each : values) {
      const bool is_mass = each.kind == LearnedValues::Kind::mass;
      for (std::size_t i = 0; is_mass && i < each.members.size(); ++i)
        if (each.members[i] < count && pinned[each.members[i]] != 0) masses.push_back({next + i, each.members[i]});
      next += (each.kind == LearnedValues::Kind::initial_velocity ? 3 : 1) * each.members.size();
    }
    learned.emplace(network, std::move(values));
    learned->attach(free.engine);
  }

  [[nodiscard]] Eigen::Index size() const { return 3 * static_cast<Eigen::Index>(count); }
  [[nodiscard]] static const std::vector<std::uint32_t>& number_in(const Called& called) {
    return called.engine.model().layout.ordering().engine;
  }
  // x of all nodes first, in the order of an engine.
  [[nodiscard]] VectorXd in_order_of(const Called& called, const Matrix3Xd& values) const {
    VectorXd result(size());
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        result[static_cast<Eigen::Index>(axis * count + number_in(called)[k])] =
            values(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(k));
    return result;
  }
  [[nodiscard]] Matrix3Xd in_user_order(const Called& called, const VectorXd& values) const {
    Matrix3Xd result(3, static_cast<Eigen::Index>(count));
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        result(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(k)) =
            values[static_cast<Eigen::Index>(axis * count + number_in(called)[k])];
    return result;
  }
  [[nodiscard]] double mass_of(std::size_t node) const { return free.host.network().mass[number_in(free)[node]]; }

  // A state of a motion, as an engine is asked about it.
  struct At {
    VectorXd p, v;
    springnet_evaluation evaluation = sdk::sized<springnet_evaluation>();
  };
  void go_to(const Called& called, const MotionDerivatives& motion, std::size_t state, At& at) const {
    const std::size_t step = std::max<std::size_t>(1, state);  // that ends with it, but for the start
    called.host.begin_step(motion.time(step - 1), motion.time(step));
    at.p = in_order_of(called, motion.positions(state));
    at.v = in_order_of(called, motion.velocities(state));
    at.evaluation.time = motion.time(state);
    at.evaluation.position = {at.p.data(), at.p.data() + count, at.p.data() + 2 * count};
    at.evaluation.velocity = {at.v.data(), at.v.data() + count, at.v.data() + 2 * count};
    const std::vector<Event> events = motion.events();
    if (std::any_of(events.begin(), events.end(), [](const Event& each) {
          return each.kind == Event::Kind::cut || each.kind == Event::Kind::ruptured;
        }))
      throw Error(ErrorKind::simulation,
                  "learning: reactions of motions in which springs break or are cut are not differentiated");
  }
  [[nodiscard]] Matrix3Xd accelerations(const Called& called, const At& at) const {
    VectorXd out(size());
    springnet_evaluation wanted = at.evaluation;
    wanted.acceleration = {out.data(), out.data() + count, out.data() + 2 * count};
    called.host.evaluate(wanted);
    return in_user_order(called, out);
  }
  // a_given - a of nodes that are held or moved; 0 of others.
  [[nodiscard]] Matrix3Xd missing(const MotionDerivatives& motion, std::size_t state, const At& at) const {
    Matrix3Xd result = -accelerations(free, at);
    if (given) {
      At own;
      go_to(*given, motion, state, own);
      result += accelerations(*given, own);
    }
    for (std::size_t k = 0; k < count; ++k)
      if (pinned[k] == 0) result.col(static_cast<Eigen::Index>(k)).setZero();
    return result;
  }
  template <class Function>
  auto with_messages(const Function& function) const {
    try {
      return function();
    } catch (const sdk::Failure& failure) {
      throw Error(ErrorKind::simulation, std::string("learning: reactions: ") + failure.what());
    }
  }

  Called free;
  std::optional<Called> given;  // none: nothing moves
  std::size_t count;
  std::vector<std::uint8_t> pinned;  // [node]
  std::optional<learning::LearnedSets> learned;
  struct Mass {
    std::size_t value;
    NodeIndex node;
  };
  std::vector<Mass> masses;  // learned, of nodes with reactions
};

ReactionDerivatives::ReactionDerivatives(const std::shared_ptr<const Network>& network,
                                         const std::shared_ptr<const PluginHost>& plugins,
                                         const SimulationOptions& options, std::vector<LearnedValues> learned) {
  if (!network) throw Error(ErrorKind::input, "learning: there is no network");
  if (!plugins) throw Error(ErrorKind::input, "learning: there is no plugin host");
  impl_ = std::make_unique<Impl>(*network, *plugins, options, std::move(learned));
}
ReactionDerivatives::~ReactionDerivatives() = default;
ReactionDerivatives::ReactionDerivatives(ReactionDerivatives&&) noexcept = default;
ReactionDerivatives& ReactionDerivatives::operator=(ReactionDerivatives&&) noexcept = default;

bool ReactionDerivatives::has_reaction(NodeIndex node) const { return node < impl_->count && impl_->pinned[node] != 0; }

void ReactionDerivatives::set_values(const VectorXd& values) {
  impl_->learned->check(values);
  impl_->learned->set(impl_->free.engine, values);
}

Matrix3Xd ReactionDerivatives::at(const MotionDerivatives& motion, std::size_t state) {
  return impl_->with_messages([&] {
    Impl::At at;
    impl_->go_to(impl_->free, motion, state, at);
    Matrix3Xd result = impl_->missing(motion, state, at);
    for (std::size_t k = 0; k < impl_->count; ++k) result.col(static_cast<Eigen::Index>(k)) *= impl_->mass_of(k);
    return result;
  });
}

MatrixXd ReactionDerivatives::tangent(const MotionDerivatives& motion, std::size_t state, const MatrixXd& changes,
                                      const MatrixXd& positions, const MatrixXd& velocities) {
  Impl& own = *impl_;
  return own.with_messages([&] {
    Impl::At at;
    own.go_to(own.free, motion, state, at);
    own.free.host.linearise(at.evaluation);
    MatrixXd result(own.size(), changes.cols());
    VectorXd by_state(own.size());
    MatrixXd by_values;
    own.learned->tangents(own.free.engine, own.free.host, at.evaluation, changes, by_values);
    const auto nodes = static_cast<Eigen::Index>(own.count);
    for (Eigen::Index j = 0; j < changes.cols(); ++j) {
      const VectorXd dp = own.in_order_of(own.free, positions.col(j).reshaped(3, nodes));
      const VectorXd dv = own.in_order_of(own.free, velocities.col(j).reshaped(3, nodes));
      own.free.host.jacobian_times(dp.data(), dv.data(), by_state.data());
      Matrix3Xd change = own.in_user_order(own.free, by_state + by_values.col(j));
      for (std::size_t k = 0; k < own.count; ++k)
        change.col(static_cast<Eigen::Index>(k)) *= own.pinned[k] != 0 ? -own.mass_of(k) : 0.0;
      result.col(j) = change.reshaped();
    }
    if (own.masses.empty()) return result;
    const Matrix3Xd missing = own.missing(motion, state, at);
    for (const Impl::Mass& each : own.masses)
      result.middleRows<3>(3 * Eigen::Index{each.node}) +=
          missing.col(each.node) * changes.row(static_cast<Eigen::Index>(each.value));
    return result;
  });
}

void ReactionDerivatives::add_adjoint(const MotionDerivatives& motion, std::size_t state, const Matrix3Xd& by_reaction,
                                      MotionDerivatives::StateChange& to, VectorXd& by_values) {
  Impl& own = *impl_;
  own.with_messages([&] {
    Impl::At at;
    own.go_to(own.free, motion, state, at);
    own.free.host.linearise(at.evaluation);
    Matrix3Xd weighted = by_reaction;
    for (std::size_t k = 0; k < own.count; ++k)
      weighted.col(static_cast<Eigen::Index>(k)) *= own.pinned[k] != 0 ? -own.mass_of(k) : 0.0;
    VectorXd weights = own.in_order_of(own.free, weighted), by_position(own.size()), by_velocity(own.size());
    own.free.host.jacobian_transposed_times(weights.data(), by_position.data(), by_velocity.data());
    to.positions += own.in_user_order(own.free, by_position);
    to.velocities += own.in_user_order(own.free, by_velocity);
    own.learned->begin_cotangent();
    own.learned->add_cotangent(own.free.engine, own.free.host, at.evaluation, weights.data());
    by_values += own.learned->cotangent(VectorXd::Zero(own.size()));
    if (own.masses.empty()) return;
    const Matrix3Xd missing = own.missing(motion, state, at);
    for (const Impl::Mass& each : own.masses)
      by_values[static_cast<Eigen::Index>(each.value)] += by_reaction.col(each.node).dot(missing.col(each.node));
  });
}

}  // namespace springnet
