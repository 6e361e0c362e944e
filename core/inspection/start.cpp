#include "inspection/start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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
  for (const Element& e : network.elements()) result.add_element(e.invariant, e.nodes, e.material, e.reference);
  for (const Rigid& rigid : network.rigids()) result.add_rigid(rigid.first, rigid.second, rigid.length);
  for (const Load& load : network.loads()) result.add_load(load);
  for (const Input& input : network.inputs()) result.add_input(input);
  for (const Cut& cut : network.cuts())
    if (cut.time <= 0.0) result.add_cut(cut);
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
  }
}

}  // namespace springnet
