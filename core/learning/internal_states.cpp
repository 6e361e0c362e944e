#include "learning/internal_states.hpp"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "layers/internal_members.hpp"
#include "layers/internal_queries.hpp"
#include "simulation/event_derivatives.hpp"

namespace springnet::learning {

using Eigen::MatrixXd;
using Eigen::VectorXd;

InternalStates::InternalStates(Engine& engine, double theta)
    : engine_(engine),
      order_(theta < 1.0 ? 2 : 1),
      count_(static_cast<Eigen::Index>(engine.model().layout.internal().count())),
      step_(engine.model().layout, engine.model().evaluator.instruction_set()) {
  const layers::Layout& layout = engine.model().layout;
  const auto list = [&](std::vector<Place>& places) {
    return [&](std::uint32_t member, std::size_t group, std::uint32_t place) {
      const layers::InternalLayout::OfGroup& own = layout.internal().group(group);
      places.push_back({member, own.first + place, own.count, layout.laws().groups[group].state_count()});
    };
  };
  layers::for_each_spring_with_states(layout, list(springs_));
  layers::for_each_element_with_states(layout, list(elements_));
}

VectorXd InternalStates::at_start() {
  VectorXd z = VectorXd::Zero(count_);
  Model& model = engine_.model();
  if (any() && layers::start_states(model.layout, model.evaluator.instruction_set(), model.time, model.state.nodes(),
                                    z.data(), model.journal.message) != SPRINGNET_OK)
    throw Error(ErrorKind::simulation, std::string("learning: ") + model.journal.message.text);
  return z;
}

std::string InternalStates::difference(const VectorXd& one, const VectorXd& other) const {
  const auto find = [&](const std::vector<Place>& places, const char* what) -> std::string {
    for (const Place& each : places)
      for (std::uint64_t j = 0; j < each.count; ++j)
        if (const auto at = static_cast<Eigen::Index>(each.first + j * each.pitch); one[at] != other[at])
          return fmt::format("{} {}", what, each.member);
    return {};
  };
  const std::string spring = find(springs_, "spring");
  return spring.empty() ? find(elements_, "element") : spring;
}

void InternalStates::check_start(const LearnedSets& learned, const VectorXd& values) {
  if (!any()) return;
  const VectorXd before = at_start();
  for (const double factor : {1.01, 0.99}) {
    try {
      learned.set(engine_, factor * values);
    } catch (const Error&) {
      continue;  // beyond a bound
    }
    const std::string differs = difference(before, at_start());
    learned.set(engine_, values);
    if (differs.empty()) return;
    throw Error(ErrorKind::input,
                fmt::format("learning: internal states of {} start at values that follow from what is learned "
                            "(starts_relaxed), which is not differentiated: leave its rest length as it is known, or "
                            "let its states start at given values",
                            differs));
  }
}

void InternalStates::record(const Simulation& simulation, VectorXd& z) const {
  z.setZero(count_);
  const auto put = [&](const Place& place, const std::vector<double>& states) {
    for (std::size_t j = 0; j < states.size(); ++j)
      z[static_cast<Eigen::Index>(place.first + j * place.pitch)] = states[j];
  };
  for (const Place& each : springs_) put(each, simulation.internal_states(each.member));
  for (const Place& each : elements_) put(each, simulation.element_internal_states(each.member));
}

void InternalStates::start_at(const springnet_evaluation& start, const VectorXd& z) {
  if (!any()) return;
  Model& model = engine_.model();
  const std::uint32_t n = model.node_count();
  const springnet_state& state = model.state.view;
  const double* const from[] = {start.position.x, start.position.y, start.position.z,
                                start.velocity.x, start.velocity.y, start.velocity.z};
  double* const to[] = {state.position.x, state.position.y, state.position.z,
                        state.velocity.x, state.velocity.y, state.velocity.z};
  for (std::size_t i = 0; i < 6; ++i) std::copy_n(from[i], n, to[i]);
  std::copy_n(z.data(), z.size(), state.internal);
  model.begin_internal_steps();
}

const springnet_internal* InternalStates::stepped(double time_step) {
  if (!any()) return nullptr;
  stepped_ = {sizeof stepped_, order_, time_step, nullptr, nullptr, nullptr};
  return &stepped_;
}

const springnet_internal* InternalStates::as_they_are(const VectorXd& z) {
  if (!any()) return nullptr;
  as_they_are_ = {sizeof as_they_are_, order_, 0.0, z.data(), nullptr, nullptr};
  return &as_they_are_;
}

VectorXd InternalStates::at_end(const sdk::Host& host, springnet_evaluation end, double time_step) {
  VectorXd next(count_);
  if (!any()) return next;
  acceleration_.resize(3 * static_cast<Eigen::Index>(host.network().node_count));
  double* const a = acceleration_.data();
  const std::size_t n = host.network().node_count;
  const springnet_internal asked{sizeof asked, order_, time_step, nullptr, next.data(), nullptr};
  end.internal = &asked;
  end.acceleration = {a, a + n, a + 2 * n};
  host.evaluate(end);
  return next;
}

// Two one-sided differences, of which the second order is left: states may follow nodes at once, and then have no rate
// of their own.
VectorXd InternalStates::rates(const sdk::Host& host, const springnet_evaluation& start, const VectorXd& accelerations,
                               double short_time) {
  if (!any()) return {};
  const auto n = static_cast<Eigen::Index>(host.network().node_count);
  const auto all = [n](const springnet_const_vectors& of) {
    VectorXd result(3 * n);
    result << Eigen::Map<const VectorXd>(of.x, n), Eigen::Map<const VectorXd>(of.y, n),
        Eigen::Map<const VectorXd>(of.z, n);
    return result;
  };
  const VectorXd p = all(start.position), v = all(start.velocity);
  const Eigen::Map<const VectorXd> z(start.internal->values, count_);
  const auto difference = [&](double time) {
    const VectorXd later_p = p + time * v + 0.5 * time * time * accelerations, later_v = v + time * accelerations;
    springnet_evaluation end = start;
    end.time += time;
    end.position = {later_p.data(), later_p.data() + n, later_p.data() + 2 * n};
    end.velocity = {later_v.data(), later_v.data() + n, later_v.data() + 2 * n};
    return VectorXd((at_end(host, end, time) - z) / time);
  };
  return 2.0 * difference(0.5 * short_time) - difference(short_time);
}

layers::NodeArrays InternalStates::nodes_of(const springnet_evaluation& at) const noexcept {
  return {at.position.x, at.position.y, at.position.z, at.velocity.x, at.velocity.y, at.velocity.z};
}

void InternalStates::find(const springnet_evaluation& at) {
  Model& model = engine_.model();
  const layers::InternalView view = model.internal_for(at.internal);
  layers::NodeArrays nodes = nodes_of(at);
  nodes.internal = &view;
  if (step_.find(at.time, nodes, model.journal.message) != SPRINGNET_OK)
    throw Error(ErrorKind::simulation, std::string("learning: ") + model.journal.message.text);
  for (VectorXd* each : {&force_, &acceleration_}) each->resize(3 * static_cast<Eigen::Index>(model.node_count()));
  for (VectorXd* each : {&q_, &u_, &next_}) each->resize(count_);
}

void InternalStates::accelerations_of_force() {
  engine_.linear().matrices().accelerations(force_.data(), acceleration_.data());
  engine_.linear().project_accelerations(false, acceleration_.data());
}

void InternalStates::force_of(const VectorXd& accelerations) {
  acceleration_ = accelerations;
  engine_.linear().project_accelerations(true, acceleration_.data());
  const Eigen::Index n = acceleration_.size() / 3;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Vector3 own(acceleration_[k], acceleration_[n + k], acceleration_[2 * n + k]);
    const Vector3 force = engine_.linear().matrices().by_force(static_cast<std::uint32_t>(k)).transpose() * own;
    for (Eigen::Index c = 0; c < 3; ++c) force_[c * n + k] = force[c];
  }
}

void InternalStates::begin_changes(Eigen::Index columns) {
  changes_.setZero(count_, columns);
  by_values_.setZero(count_, columns);
}

void InternalStates::add_accelerations(const springnet_evaluation& at, double weight, MatrixXd& accelerations) {
  if (!any()) return;
  find(at);
  for (Eigen::Index j = 0; j < changes_.cols(); ++j) {
    force_.setZero();
    step_.from_start(nodes_of(at), changes_.col(j).data(), nullptr, nullptr, force_.data(), nullptr);
    accelerations_of_force();
    accelerations.col(j) += weight * acceleration_;
  }
}

void InternalStates::add_by_start(const springnet_evaluation& start, const springnet_evaluation& end, double weight,
                                  const MatrixXd& dp, const MatrixXd& dv, MatrixXd& accelerations) {
  if (!any()) return;
  find(end);
  for (Eigen::Index j = 0; j < changes_.cols(); ++j) {
    step_.invariants(nodes_of(start), dp.col(j).data(), dv.col(j).data(), q_.data(), u_.data());
    force_.setZero();
    step_.from_start(nodes_of(end), changes_.col(j).data(), q_.data(), u_.data(), force_.data(), next_.data());
    changes_.col(j) = next_;
    accelerations_of_force();
    accelerations.col(j) += weight * acceleration_;
  }
}

void InternalStates::resize_changes(Eigen::Index columns) {
  const Eigen::Index before = changes_.cols();
  for (MatrixXd* each : {&changes_, &by_values_}) {
    each->conservativeResize(count_, columns);
    if (columns > before) each->rightCols(columns - before).setZero();
  }
}

double* InternalStates::by_values(Eigen::Index column) { return any() ? by_values_.col(column).data() : nullptr; }

void InternalStates::end_step(const springnet_evaluation& end, const MatrixXd& dp, const MatrixXd& dv) {
  if (!any()) return;
  changes_ += by_values_;
  for (Eigen::Index j = 0; j < changes_.cols(); ++j) {
    step_.invariants(nodes_of(end), dp.col(j).data(), dv.col(j).data(), q_.data(), u_.data());
    step_.from_end(q_.data(), u_.data(), changes_.col(j).data());
  }
}

void InternalStates::begin_weights() { weights_.setZero(count_); }

void InternalStates::weigh_end(const springnet_evaluation& end, VectorXd& dp, VectorXd& dv) {
  if (!any()) return;
  find(end);
  step_.weigh_end(weights_.data(), q_.data(), u_.data());
  step_.weigh_invariants(nodes_of(end), q_.data(), u_.data(), dp.data(), dv.data());
}

void InternalStates::weigh_start(const springnet_evaluation& start, const springnet_evaluation& end,
                                 const VectorXd& accelerations, VectorXd& dp, VectorXd& dv) {
  if (!any()) return;
  force_of(accelerations);
  for (VectorXd* each : {&q_, &u_, &next_}) each->setZero();
  step_.weigh_start(nodes_of(end), force_.data(), weights_.data(), next_.data(), q_.data(), u_.data());
  step_.weigh_invariants(nodes_of(start), q_.data(), u_.data(), dp.data(), dv.data());
  weights_ = next_;
}

void InternalStates::weigh_accelerations(const springnet_evaluation& at, const VectorXd& accelerations, VectorXd& to) {
  if (!any()) return;
  find(at);
  force_of(accelerations);
  step_.weigh_start(nodes_of(at), force_.data(), nullptr, to.data(), nullptr, nullptr);
}

void InternalStates::add_margin(const springnet_evaluation& at, std::uint32_t event, VectorXd& to) {
  if (!any()) return;
  auto request = sdk::sized<springnet_event_derivative>();
  request.at = &at;
  request.event = event;
  static_cast<void>(
      find_event_derivative(engine_.model(), engine_.contact_events(), engine_.topology(), request, to.data()));
}

}  // namespace springnet::learning
