#include "inspection/start.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <springnet/error.hpp>

#include "layers/elements/invariant.hpp"
#include "layers/elements/queries.hpp"
#include "layers/kernels.hpp"
#include "layers/springs/blocks.hpp"
#include "layers/springs/queries.hpp"

namespace springnet {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr InstructionSet set = InstructionSet::generic;

// The network without velocities and obstacles; nodes moved by the scene are fixed. Obstacles are left out because
// bodies may separate from them, and contact hardly lowers a limit: it takes motions away.
Network at_rest(const Network& network, const std::vector<std::uint8_t>& free) {
  Network result;
  for (const LawUse& neuron : network.neurons()) result.add_neuron(neuron);
  for (const Material& material : network.materials()) result.add_material(material);
  for (NodeIndex k = 0; k < network.nodes().size(); ++k) {
    Node node = network.nodes()[k];
    node.velocity.setZero();
    node.fixed = free[k] == 0;
    result.add_node(node);
  }
  for (const Spring& s : network.springs()) result.add_spring(s.first, s.second, s.material, s.rest_length);
  for (const Element& e : network.elements()) {
    if (reads_several(e.invariant))
      result.add_element(e.invariant, e.nodes, e.material, e.rest, e.direction);
    else
      result.add_element(e.invariant, e.nodes, e.material, e.reference);
  }
  for (const Rigid& rigid : network.rigids()) result.add_rigid(rigid.first, rigid.second, rigid.length);
  for (const Load& load : network.loads()) result.add_load(load);
  for (const Input& input : network.inputs()) result.add_input(input);
  for (const Cut& cut : network.cuts())
    if (cut.time <= 0.0) result.add_cut(cut);
  for (Change change : network.changes()) {
    if (change.time > 0.0) continue;
    change.integrator.reset();
    const bool any = change.remove || !change.springs.empty() || !change.elements.empty() || !change.nodes.empty();
    if (any) result.add_change(change);
  }
  result.set_gravity(network.gravity());
  return result;
}

bool has_derivatives(const layers::Law& law) { return !law || law.can(SPRINGNET_HAS_DERIVATIVES); }

}  // namespace

StartingNetwork::StartingNetwork(const Network& network, const PluginHost& plugins)
    : network_(network), free_(network.nodes().size()) {
  for (std::size_t k = 0; k < free_.size(); ++k) free_[k] = network.nodes()[k].fixed ? 0 : 1;
  for (const Move& move : network.moves())
    for (const NodeIndex node : move.nodes) free_[node] = 0;
  const Network resting = at_rest(network, free_);
  try {
    survey_ = std::make_unique<LimitSurvey>(resting, plugins);
    layout_ = &survey_->engine().model().layout;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::simulation) throw;
    failure_ = error.what();
    own_layout_ = std::make_unique<layers::Layout>(resting, plugins, false);
    layout_ = own_layout_.get();
  }
  const std::size_t count = free_.size();
  for (auto& c : coordinates_) c.resize(count);
  zero_.resize(count);
  for (NodeIndex k = 0; k < count; ++k)
    for (Eigen::Index c = 0; c < 3; ++c) coordinates_[c][engine_node(k)] = network.nodes()[k].position[c];
  nodes_ = {coordinates_[0].data(), coordinates_[1].data(), coordinates_[2].data(),
            zero_.data(),           zero_.data(),           zero_.data()};
  if (survey_) nodes_.internal = survey_->engine().model().state.nodes().internal;  // else as laws declare
  linearise_springs();
  linearise_elements();
}

bool StartingNetwork::has_neighbours(NodeIndex user) const {
  const std::uint32_t k = engine_node(user);
  return layout_->neighbour_start()[k] < layout_->neighbour_start()[k + 1];
}

void StartingNetwork::linearise_springs() {
  springs_.resize(network_.springs().size());
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const Spring& spring = network_.springs()[s];
    const Vector3 difference = network_.nodes()[spring.first].position - network_.nodes()[spring.second].position;
    springs_[s] = {difference.norm(), unknown, unknown, unknown, unknown};
  }
  const auto geometry = std::make_unique<layers::SegmentGeometry>();
  const auto answers = std::make_unique<layers::PairAnswers<layers::max_segment>>();
  const layers::PairOutputs out = answers->outputs(true, false);
  for (std::size_t g = 0; g < layout_->laws().groups.size(); ++g) {
    const layers::Group& group = layout_->laws().groups[g];
    if (!has_derivatives(group.spring) || !has_derivatives(group.viscosity)) continue;
    const auto linearise = [&](const std::uint32_t* numbers, std::size_t count) {
      springnet_message message{};
      if (layers::evaluate_springs(*layout_, set, 0.0, nodes_, g, numbers, count, *geometry, out, message) !=
          SPRINGNET_OK)
        return false;
      for (std::size_t i = 0; i < count; ++i) {
        const layers::SpringForces sum = layers::spring_forces(group, *answers, i);
        springs_[numbers[i]] = {springs_[numbers[i]].length, sum.tension, sum.by_length, sum.by_rate, sum.by_speed};
      }
      return true;
    };
    const std::vector<std::uint32_t>& springs = layout_->springs_of(g);
    for (std::size_t begin = 0; begin < springs.size(); begin += layers::max_segment) {
      const std::size_t count = std::min(layers::max_segment, springs.size() - begin);
      if (linearise(springs.data() + begin, count)) continue;
      for (std::size_t i = begin; i < begin + count; ++i) static_cast<void>(linearise(springs.data() + i, 1));
    }
  }
}

void StartingNetwork::linearise_elements() {
  const layers::ElementLayout& elements = layout_->elements();
  const std::vector<std::uint32_t>& user = layout_->ordering().user;
  elements_.resize(network_.elements().size());
  std::size_t enclosure = 0;
  for (std::uint32_t e = 0; e < elements_.size(); ++e) {
    ElementAtStart& element = elements_[e];
    element.force = element.stiffness = element.damping = unknown;
    for (const std::uint32_t node : elements.nodes(e)) element.nodes.push_back(user[node]);
    element.across.assign(element.nodes.size(), Vector3::Zero());
    const Invariant invariant = elements.invariant(e);
    if (reads_several(invariant)) {
      linearise_several(e, element);
      continue;
    }
    double value = 0.0;
    if (invariant == Invariant::enclosed_volume) {
      const layers::Enclosure& closed = elements.enclosures()[enclosure++].shape;
      value = closed.values(nodes_).volume;
      for (std::size_t place = 0; place < closed.size(); ++place)
        element.gradient.push_back(closed.gradient(place, nodes_));
    } else {
      layers::Corners corners;
      layers::gather(elements.nodes(e).data(), element.nodes.size(), nodes_, corners);
      layers::FirstOrder geometry;
      layers::first_order(invariant, corners, geometry);
      value = layers::nearest_turn(invariant, geometry.value, elements.reference(e));
      layers::ElementBlocks blocks;
      layers::linearise(invariant, corners, geometry, {0.0, 1.0, 0.0}, blocks);
      element.gradient.assign(blocks.row[0], blocks.row[0] + element.nodes.size());
      element.across.assign(blocks.row[1], blocks.row[1] + element.nodes.size());
    }
    element.directions = {element.gradient};
    if (invariant != Invariant::enclosed_volume) element.directions.push_back(element.across);
    const bool is_angle = invariant == Invariant::angle || invariant == Invariant::dihedral;
    element.scale = is_angle ? 1.0 : std::abs(value);
    const layers::Group& group = layout_->laws().groups[elements.group(e)];
    if (!has_derivatives(group.spring) || !has_derivatives(group.viscosity)) continue;
    double force[2] = {0.0, 0.0}, by_q[2] = {0.0, 0.0}, by_rate[2] = {0.0, 0.0};
    springnet_message message{};
    const layers::PairOutputs out{layers::LawOutputs{&force[0], &by_q[0], &by_rate[0]},
                                  layers::LawOutputs{&force[1], &by_q[1], &by_rate[1]}};
    if (layers::evaluate_element(*layout_, set, 0.0, nodes_, e, {value, 0.0}, out, message) != SPRINGNET_OK) continue;
    element.force = force[0] + force[1];
    element.stiffness = by_q[0] + by_q[1];
    element.damping = by_rate[0] + by_rate[1];
    for (const Vector3& gradient : element.gradient) {
      element.own_stiffness.push_back(element.stiffness * gradient.squaredNorm());
      element.own_damping.push_back(element.damping * gradient.squaredNorm());
    }
    // Smaller forces, relative to stiffness times size, are rounding.
    constexpr double no_load = 1e-12;
    element.definite = element.stiffness >= 0.0 && element.damping >= 0.0 &&
                       std::abs(element.force) <= no_load * element.stiffness * element.scale;
    if (element.stiffness == 0.0) element.directions.clear();
  }
}

// From the derivatives of the forces on its nodes: their eigenvectors are the directions in which it resists.
void StartingNetwork::linearise_several(std::uint32_t e, ElementAtStart& element) {
  const layers::Group& group = layout_->laws().groups[layout_->elements().group(e)];
  const std::size_t count = element.nodes.size();
  element.own_stiffness.assign(count, unknown);
  element.own_damping.assign(count, unknown);
  const auto query = std::make_unique<layers::SeveralQuery>();
  springnet_message message{};
  if (layers::evaluate_several_element(*layout_, set, 0.0, nodes_, e, layers::SeveralWanted::tangent, *query,
                                       message) != SPRINGNET_OK)
    return;
  const auto tangent = std::make_unique<layers::SeveralTangent>();
  const auto rate_gradients = std::make_unique<layers::SeveralRateGradients>();
  const auto blocks = std::make_unique<layers::SeveralBlocks>();
  const layers::Kernels& kernels = layers::kernels_for(set);
  if (!layers::tangent_of(kernels, group, query->answers, 1, *tangent)) return;
  layers::several_blocks(kernels, group.scalars, query->geometry, 0, 1, *tangent, *rate_gradients, *blocks);
  const double* q[2][layers::max_scalars];
  layers::forces_of(group, query->answers, q);
  double forces[3][layers::max_corners];
  kernels.several.forces(group.scalars, query->geometry, 1, q, {forces[0], forces[1], forces[2], 1});
  const auto size = static_cast<Eigen::Index>(3 * count);
  Eigen::MatrixXd stiffness(size, size), damping = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j)
      for (std::size_t k = 0; k < 9; ++k) {
        const auto row = static_cast<Eigen::Index>(3 * i + k / 3), column = static_cast<Eigen::Index>(3 * j + k % 3);
        stiffness(row, column) = blocks->stiffness[i][j][k][0];
        if (tangent->has_rates) damping(row, column) = blocks->damping[i][j][k][0];
      }
  const auto largest = [](const Eigen::MatrixXd& block) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (block + block.transpose())).eigenvalues().maxCoeff();
  };
  double extent = 0.0, force = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    element.own_stiffness[i] = largest(stiffness.block(at, at, 3, 3));
    element.own_damping[i] = largest(damping.block(at, at, 3, 3));
    for (std::size_t c = 0; c < 3; ++c) {
      force = std::max(force, std::abs(forces[c][i]));
      extent = std::max(extent, std::abs(query->geometry.position[3 * i + c][0]));
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> elastic(0.5 * (stiffness + stiffness.transpose()));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> viscous(0.5 * (damping + damping.transpose()));
  constexpr double rounding = 1e-10;
  const double greatest = elastic.eigenvalues().cwiseAbs().maxCoeff();
  element.definite = elastic.eigenvalues().minCoeff() >= -rounding * greatest &&
                     force <= rounding * greatest * extent &&
                     viscous.eigenvalues().minCoeff() >= -rounding * viscous.eigenvalues().cwiseAbs().maxCoeff();
  for (Eigen::Index k = 0; k < size; ++k) {
    if (!(std::abs(elastic.eigenvalues()[k]) > rounding * greatest)) continue;
    std::vector<Vector3> direction;
    for (std::size_t i = 0; i < count; ++i)
      direction.emplace_back(elastic.eigenvectors().col(k).segment<3>(static_cast<Eigen::Index>(3 * i)));
    element.directions.push_back(std::move(direction));
  }
}

}  // namespace springnet
