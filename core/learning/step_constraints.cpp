#include "learning/step_constraints.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "constraints/acceleration_gradients.hpp"
#include "learning/contact_output.hpp"
#include "learning/node_vectors.hpp"
#include "learning/rigid_output.hpp"
#include "learning/touching_cluster.hpp"
#include "simulation/host_table.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Matrices of a cluster are dense.
constexpr std::size_t most_of_cluster = 100;
// In contact they are found by 40 sweeps for each node and more: 1 s for a step of 16 nodes that are all joined.
constexpr std::size_t most_of_touching_cluster = 40;

}  // namespace

void StepConstraints::check_touching_cluster(std::uint32_t node, std::int32_t surface, double time) const {
  const Model& model = engine_.model();
  const std::size_t count = model.rigid.nodes_of(model.rigid.cluster_of()[node]).size();
  if (count <= most_of_touching_cluster) return;
  throw Error(ErrorKind::simulation,
              fmt::format("learning: rigid connections join {} nodes, of which node {} touches {} at {:g} s; up to {} "
                          "are differentiated while they touch; use springs for some of them, or learn from the time "
                          "before it",
                          count, model.user_number(node), model.contact.name_of(static_cast<std::size_t>(surface)),
                          time, most_of_touching_cluster));
}

StepConstraints::StepConstraints(const Network& network, const PluginHost& plugins, const SimulationOptions& options)
    : engine_(network, plugins, options), table_(make_host_table(engine_)), host_(table_) {
  const RigidConnections& rigid = engine_.model().rigid;
  for (std::size_t c = 0; c < rigid.cluster_count(); ++c)
    if (rigid.nodes_of(c).size() > most_of_cluster)
      throw Error(ErrorKind::input,
                  fmt::format("learning: rigid connections join {} nodes (with node {}); up to {} are differentiated",
                              rigid.nodes_of(c).size(), engine_.model().user_number(rigid.nodes_of(c).front()),
                              most_of_cluster));
}

StepConstraints::~StepConstraints() = default;

bool StepConstraints::is_rigid(std::uint32_t node) const {
  const std::uint32_t* const cluster_of = engine_.model().rigid.cluster_of();
  return cluster_of != nullptr && cluster_of[node] != 0xffffffffu;
}

void StepConstraints::check_starts(const LearnedSets& learned, const Simulation& simulation) const {
  for (const NodeIndex node : learned.with_start_velocities())
    if (simulation.touching(node) || is_rigid(simulation.columns()[node]))
      throw Error(ErrorKind::input,
                  fmt::format("learning: node {} is in contact or rigidly connected at the start; its velocity there "
                              "cannot be learned",
                              node));
}

bool StepConstraints::any_at(std::size_t state) { return engine_.model().rigid.any() || !history_.at(state).empty(); }

bool StepConstraints::any_within(std::size_t step) {
  return engine_.model().rigid.any() || !history_.within(step).empty();
}

const sdk::Host& StepConstraints::begin_step(std::size_t state, double from, double until) {
  host_.begin_step(from, until);
  state_time_ = from;
  Contact& contact = engine_.model().contact;
  if (contact.obstacles().empty()) return host_;
  const Touches& touches = history_.at(state);
  for (std::uint32_t node = 0; node < engine_.model().node_count(); ++node) {
    const auto found = touches.find(node);
    const Touch touch = found == touches.end() ? Touch{} : found->second;
    if (!(contact.committed(node) == touch)) contact.touch(node, touch, Vector3::Zero());
    if (touch.slides) contact.set_slip(node, Vector3::Zero());
  }
  for (const Slipping& each : history_.slips_at(state))
    if (contact.committed(each.node).slides) contact.set_slip(each.node, each.direction, each.phase);
  return host_;
}

// use(node, matrix): of each node that a turning surface carries.
template <class Use>
void StepConstraints::for_each_carried(const Use& use) {
  const Contact& contact = engine_.model().contact;
  if (std::none_of(contact.obstacles().begin(), contact.obstacles().end(), [](const Obstacle& o) { return o.turns(); }))
    return;
  const std::shared_ptr<const Placement> at = contact.at(just_after(state_time_));
  for (std::uint32_t k = 0; k < engine_.model().node_count(); ++k)
    if (contact.held()[k] != 0)
      use(k, acceleration_by_position(at->poses[static_cast<std::size_t>(contact.committed(k).surface)]));
}

void StepConstraints::add_carried(const VectorXd& dp, VectorXd& accelerations) {
  for_each_carried([&](std::uint32_t k, const Matrix3& by_position) {
    add_to_node(accelerations, k, by_position * node_of(dp, k));
  });
}

void StepConstraints::add_carried_transposed(const VectorXd& weights, VectorXd& by_position) {
  for_each_carried([&](std::uint32_t k, const Matrix3& matrix) {
    add_to_node(by_position, k, matrix.transpose() * node_of(weights, k));
  });
}

std::vector<Arrival> StepConstraints::arrivals(const Step& step) {
  std::vector<Arrival> result;
  Model& model = engine_.model();
  const double h = step.until_time - step.from_time;
  std::shared_ptr<const Placement> start, end;
  for (StepContact& each : history_.within(step.until)) {
    each.kept = step.kept;
    const std::uint32_t k = each.node;
    if (model.contact.fixed()[k] != 0 || is_rigid(k) || !arrives(model.contact, each)) continue;
    if (!end) {
      start = model.contact.at(just_after(step.from_time));
      end = model.contact.at(just_before(step.until_time, h));
    }
    result.push_back(
        arrival_of(model.contact, {*start, *end, h, step.theta}, each,
                   {node_of(step.p, k), node_of(step.v, k), Vector3::Zero(), node_of(step.P, k), node_of(step.U, k)}));
  }
  return result;
}

void StepConstraints::find_outputs(const Step& step, const VectorXd& free, ConstrainedOutputs& outputs) {
  Model& model = engine_.model();
  const double h = step.until_time - step.from_time;
  outputs.begin(model.node_count(), (1.0 - step.theta) * h, step.theta * h);
  std::vector<StepContact> contacts = history_.within(step.until);
  const std::shared_ptr<const Placement> start = model.contact.at(just_after(step.from_time));
  const std::shared_ptr<const Placement> end = model.contact.at(just_before(step.until_time, h));
  const StepPlacement placement{*start, *end, h, step.theta};
  for (StepContact& each : contacts) {
    each.kept = step.kept;
    const std::uint32_t k = each.node;
    if (model.contact.fixed()[k] != 0 || is_rigid(k)) continue;
    each.arrives = arrives(model.contact, each);
    const NodeOverStep node{node_of(step.p, k), node_of(step.v, k), node_of(free, k),
                            node_of(step.P, k), node_of(step.U, k), step.unsettled};
    const auto derivative = output_derivative(model.contact, placement, each, node);
    if (!derivative)
      throw Error(
          ErrorKind::simulation,
          fmt::format(
              "learning: the contact of node {} with {} at {:g} s is not differentiated; learn from the time before it",
              model.user_number(k), model.contact.name_of(static_cast<std::size_t>(each.touch.surface)),
              step.until_time));
    Eigen::MatrixXd by_times;
    if (derivative->has_times) by_times = derivative->by_times;
    outputs.add({k}, derivative->by_state, {}, std::move(by_times));
    outputs.set_friction(each.touch.surface, each.touch.second, derivative->by_friction);
  }
  add_clusters(step, free, contacts, {placement, start}, outputs);
}

void StepConstraints::add_clusters(const Step& step, const VectorXd& free, const std::vector<StepContact>& contacts,
                                   const Places& places, ConstrainedOutputs& outputs) {
  Model& model = engine_.model();
  const RigidConnections& rigid = model.rigid;
  if (!rigid.any()) return;
  const double h = step.until_time - step.from_time;
  std::vector<std::size_t> place(model.node_count());
  for (std::size_t c = 0; c < rigid.cluster_count(); ++c) {
    ClusterOverStep cluster;
    cluster.nodes = rigid.nodes_of(c);
    cluster.w = step.theta * h;
    cluster.c = (1.0 - step.theta) * h;
    cluster.theta = step.theta;
    bool moves = false;  // one of its nodes is moved
    const auto size = static_cast<Index>(cluster.nodes.size());
    cluster.mobility.resize(size);
    for (VectorXd* each : {&cluster.p, &cluster.v, &cluster.free, &cluster.P, &cluster.U}) each->resize(3 * size);
    for (Index i = 0; i < size; ++i) {
      const std::uint32_t k = cluster.nodes[static_cast<std::size_t>(i)];
      place[k] = static_cast<std::size_t>(i);
      const bool is_given = model.contact.fixed()[k] != 0;
      moves = moves || model.contact.prescribed().moves(k);
      cluster.mobility[i] = is_given ? 0.0 : 1.0 / model.mass[k];
      cluster.p.segment<3>(3 * i) = node_of(step.p, k);
      cluster.v.segment<3>(3 * i) = node_of(step.v, k);
      cluster.P.segment<3>(3 * i) = node_of(step.P, k);
      cluster.U.segment<3>(3 * i) = node_of(step.U, k);
      cluster.free.segment<3>(3 * i) = is_given ? node_of(step.U, k) : node_of(free, k);
    }
    for (const RigidConnections::Rod& rod : rigid.rods())
      if (rigid.cluster_of()[rod.first] == c)
        cluster.rods.push_back(
            {static_cast<Index>(place[rod.first]), static_cast<Index>(place[rod.second]), rod.length});
    std::vector<StepContact> own;
    for (const StepContact& each : contacts)
      if (rigid.cluster_of()[each.node] == c && model.contact.fixed()[each.node] == 0) own.push_back(each);
    for (const StepContact& each : own)
      for (const std::int32_t surface : each.touch.surfaces())
        if (surface >= 0 && step.learned != nullptr && step.learned->has_friction_of(surface))
          throw Error(
              ErrorKind::simulation,
              fmt::format("learning: node {}, which is rigidly connected, touches {} at {:g} s; the friction of "
                          "a surface is not learned from that",
                          model.user_number(each.node), model.contact.name_of(static_cast<std::size_t>(surface)),
                          step.until_time));
    if (!own.empty()) check_touching_cluster(own.front().node, own.front().touch.surface, step.until_time);
    cluster.timed = step.timed && !moves;
    auto derivative = own.empty()
                          ? output_derivative(cluster)
                          : output_differences(model, c, places.start, places.step, step.until_time, own, cluster);
    if (!derivative)
      throw Error(
          ErrorKind::simulation,
          fmt::format(
              "learning: the step of the rigid connections of node {} to {:g} s is not differentiated{}",
              model.user_number(cluster.nodes.front()), step.until_time,
              own.empty() ? "" : ", with contact of node " + std::to_string(model.user_number(own.front().node))));
    // dW = -dm / m^2.
    for (Index i = 0; i < size; ++i) derivative->by_mobility.col(i) *= -cluster.mobility[i] * cluster.mobility[i];
    if (!cluster.timed) derivative->by_times.resize(0, 0);
    outputs.add(std::move(cluster.nodes), std::move(derivative->by_state), std::move(derivative->by_mobility),
                std::move(derivative->by_times));
  }
}

}  // namespace springnet::learning
