#include "inspection/linearised.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "network/load_course.hpp"
#include "plugin_host/call.hpp"

namespace springnet {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct LawAnswer {
  double force = unknown, by_q = unknown, by_rate = unknown;
};

// A law of one material, asked for one spring after the other.
class LawAtRest {
 public:
  LawAtRest(const Component& component, const LawUse& use)
      : component_(component),
        law_(component.law()),
        values_(complete_parameters(*component.description, use.parameters, "law '" + use.id + "'")),
        parameters_(pointers(values_)),
        parameter_strides_(values_.size(), 0),
        state_values_(defaults(law_.states, law_.state_count)),
        states_(pointers(state_values_)),
        state_rates_(law_.state_count),
        state_rate_pointers_(law_.state_count),
        input_values_(defaults(law_.inputs, law_.input_count)),
        inputs_(pointers(input_values_)),
        input_strides_(input_values_.size(), 0) {
    for (std::size_t k = 0; k < state_rates_.size(); ++k) state_rate_pointers_[k] = &state_rates_[k];
  }

  [[nodiscard]] bool reads_speed() const { return law_.invariant == SPRINGNET_RELATIVE_SPEED; }

  LawAnswer answer(double length, double rest_length) {
    const std::uint32_t capabilities = component_.description->capabilities;
    // A table comes from a scene's arrays, which a network does not keep.
    if ((capabilities & SPRINGNET_HAS_DERIVATIVES) == 0 || law_.prepare != nullptr) return {};
    const double q = reads_speed() ? 0.0 : length;
    const double rate = 0.0;
    LawAnswer result{0.0, 0.0, 0.0};
    springnet_message message{};
    springnet_law_batch batch{};
    batch.struct_size = sizeof batch;
    batch.count = 1;
    batch.instruction_set = SPRINGNET_GENERIC;
    batch.q = &q;
    batch.rate = (capabilities & SPRINGNET_READS_RATE) != 0 ? &rate : nullptr;
    batch.reference = &rest_length;
    batch.parameters = parameters_.data();
    batch.parameter_strides = parameter_strides_.data();
    batch.states = states_.data();
    batch.inputs = inputs_.data();
    batch.input_strides = input_strides_.data();
    batch.force = &result.force;
    batch.force_by_q = &result.by_q;
    batch.force_by_rate = batch.rate == nullptr ? nullptr : &result.by_rate;
    batch.state_rates = state_rate_pointers_.data();
    const springnet_status status = call_component(component_, message, [&](springnet_message& own) {
      batch.message = &own;
      return law_.evaluate(&batch);
    });
    return status == SPRINGNET_OK ? result : LawAnswer{};
  }

 private:
  static std::vector<const double*> pointers(const std::vector<double>& values) {
    std::vector<const double*> result;
    for (const double& value : values) result.push_back(&value);
    return result;
  }
  static std::vector<double> defaults(const springnet_parameter* const* parameters, std::uint32_t count) {
    std::vector<double> result;
    for (std::uint32_t k = 0; k < count; ++k) result.push_back(parameters[k]->default_value);
    return result;
  }

  const Component& component_;
  const springnet_law& law_;
  std::vector<double> values_;
  std::vector<const double*> parameters_;
  std::vector<std::uint32_t> parameter_strides_;
  std::vector<double> state_values_;
  std::vector<const double*> states_;
  std::vector<double> state_rates_;
  std::vector<double*> state_rate_pointers_;
  std::vector<double> input_values_;
  std::vector<const double*> inputs_;
  std::vector<std::uint32_t> input_strides_;
};

// The laws of one material. A component outlives the host's pointer to it here: `plugins` keeps it.
struct MaterialAtRest {
  MaterialAtRest(const Material& material, const PluginHost& plugins) {
    if (material.spring) {
      spring.emplace(*plugins.require(ComponentKind::spring_function, material.spring->id), *material.spring);
    }
    if (material.viscosity) {
      viscosity.emplace(*plugins.require(ComponentKind::viscosity_function, material.viscosity->id),
                        *material.viscosity);
    }
  }
  std::optional<LawAtRest> spring, viscosity;
};

// The linear system of a node in its neuron: derivative blocks where it starts, at rest.
class NeuronAtRest {
 public:
  NeuronAtRest(const Component& component, const LawUse& use)
      : component_(component),
        values_(complete_parameters(*component.description, use.parameters, "neuron '" + use.id + "'")),
        strides_(values_.size(), 0) {
    for (const double& value : values_) parameters_.push_back(&value);
  }

  [[nodiscard]] bool differentiable() const {
    return (component_.description->capabilities & SPRINGNET_HAS_DERIVATIVES) != 0;
  }

  // False if the neuron fails there.
  bool answer(const Node& node, const Vector3& net_force, LinearNode& out) const {
    const double zero = 0.0;
    Vector3 acceleration;
    springnet_message message{};
    springnet_neuron_batch batch{};
    batch.struct_size = sizeof batch;
    batch.count = 1;
    batch.instruction_set = SPRINGNET_GENERIC;
    batch.force = {&net_force[0], &net_force[1], &net_force[2]};
    batch.position = {&node.position[0], &node.position[1], &node.position[2]};
    batch.velocity = {&zero, &zero, &zero};
    batch.mass = &node.mass;
    batch.parameters = parameters_.data();
    batch.parameter_strides = strides_.data();
    batch.acceleration = {&acceleration[0], &acceleration[1], &acceleration[2]};
    batch.acceleration_by_force = out.by_force.data();
    batch.acceleration_by_position = out.by_position.data();
    batch.acceleration_by_velocity = out.by_velocity.data();
    const springnet_status status = call_component(component_, message, [&](springnet_message& own) {
      batch.message = &own;
      return component_.neuron().evaluate(&batch);
    });
    return status == SPRINGNET_OK && out.by_force.allFinite() && out.by_position.allFinite() &&
           out.by_velocity.allFinite();
  }

 private:
  const Component& component_;
  std::vector<double> values_;
  std::vector<const double*> parameters_;
  std::vector<std::uint32_t> strides_;
};

std::vector<LinearSpring> linear_springs(const Network& network, std::vector<MaterialAtRest>& materials) {
  std::vector<LinearSpring> result;
  result.reserve(network.springs().size());
  for (const Spring& spring : network.springs()) {
    const Vector3 difference = network.nodes()[spring.first].position - network.nodes()[spring.second].position;
    const double length = difference.norm();
    MaterialAtRest& material = materials[spring.material];
    LinearSpring linear{length, length > 0.0 ? Vector3(difference / length) : Vector3(Vector3::Zero()), 0, 0, 0, 0};
    if (material.spring) {
      const LawAnswer answer = material.spring->answer(length, spring.rest_length);
      linear.tension += answer.force;
      linear.stiffness += answer.by_q;
      linear.axial_damping += answer.by_rate;
    }
    if (material.viscosity) {
      const LawAnswer answer = material.viscosity->answer(length, spring.rest_length);
      if (material.viscosity->reads_speed()) {
        linear.general_damping += answer.by_q;
      } else {
        linear.tension += answer.force;
        linear.stiffness += answer.by_q;
        linear.axial_damping += answer.by_rate;
      }
    }
    result.push_back(linear);
  }
  return result;
}

bool acts_at_start(const Load& load) { return load.from <= 0.0 && 0.0 < load.until; }

LinearElements linear_elements(const Network& network, std::vector<MaterialAtRest>& materials) {
  std::vector<LinearElement> result;
  result.reserve(network.elements().size());
  for (const Element& element : network.elements()) {
    double value = 0.0;
    LinearElement linear = element_at_rest(network, element, value);
    MaterialAtRest& material = materials[element.material];
    for (std::optional<LawAtRest>* law : {&material.spring, &material.viscosity}) {
      if (!*law) continue;
      const LawAnswer answer = (*law)->answer(value, element.reference);
      linear.force += answer.force;
      linear.stiffness += answer.by_q;
      linear.damping += answer.by_rate;
    }
    linearise_element(network, element, linear);
    result.push_back(std::move(linear));
  }
  for (const Load& load : network.loads()) {
    if (!load.follow || !acts_at_start(load)) continue;
    const double pressure = LoadCourse(load).at(0.0) * load.pressure;
    for (const Face& face : load.faces) result.push_back(pressed_face(network, face, pressure));
  }
  return {network, std::move(result)};
}

bool known(const LinearElement& element) {
  return std::isfinite(element.force) && std::isfinite(element.stiffness) && std::isfinite(element.damping);
}

bool known(const LinearSpring& spring) {
  return std::isfinite(spring.tension) && std::isfinite(spring.stiffness) && std::isfinite(spring.axial_damping) &&
         std::isfinite(spring.general_damping);
}

// Net forces of springs, elements, gravity and the loads of time 0, N.
std::vector<Vector3> forces_at_start(const Network& network, const std::vector<LinearSpring>& springs,
                                     const LinearElements& elements) {
  std::vector<Vector3> forces;
  forces.reserve(network.nodes().size());
  for (const Node& node : network.nodes()) forces.emplace_back(node.mass * network.gravity());
  for (const Load& load : network.loads()) {
    if (!acts_at_start(load)) continue;
    const double factor = LoadCourse(load).at(0.0);
    for (const auto& [node, force] : forces_of(load)) forces[node] += factor * force;
  }
  for (std::size_t s = 0; s < springs.size(); ++s) {
    if (!(springs[s].length > 0.0) || !std::isfinite(springs[s].tension)) continue;
    const Spring& spring = network.springs()[s];
    const Vector3 force = springs[s].tension * springs[s].direction;
    forces[spring.first] -= force;
    forces[spring.second] += force;
  }
  for (const LinearElement& element : elements.all()) {
    if (!std::isfinite(element.force)) continue;
    for (std::size_t i = 0; i < element.nodes.size(); ++i)
      forces[element.nodes[i]] -= element.force * element.gradient[i];
  }
  return forces;
}

}  // namespace

LinearNetwork linearise(const Network& network, const PluginHost& plugins) {
  LinearNetwork result;
  std::vector<MaterialAtRest> materials;
  materials.reserve(network.materials().size());
  for (const Material& material : network.materials()) materials.emplace_back(material, plugins);
  result.springs = linear_springs(network, materials);
  result.elements = linear_elements(network, materials);
  const auto stranger =
      std::find_if_not(result.springs.begin(), result.springs.end(), [](const LinearSpring& s) { return known(s); });
  if (stranger != result.springs.end()) {
    const auto index = static_cast<std::size_t>(stranger - result.springs.begin());
    result.unknown_because = "a law of spring " + std::to_string(index) +
                             " offers no derivatives where it starts, or none without the tables of a scene";
  }
  const std::vector<LinearElement>& elements = result.elements.all();
  const auto strange = std::find_if_not(elements.begin(), elements.end(), [](const auto& e) { return known(e); });
  if (strange != elements.end() && result.unknown_because.empty()) {
    result.unknown_because = "a law of element " + std::to_string(strange - elements.begin()) +
                             " offers no derivatives where it starts, or none without the tables of a scene";
  }

  std::vector<NeuronAtRest> neurons;
  neurons.reserve(network.neurons().size());
  for (const LawUse& use : network.neurons()) {
    neurons.emplace_back(*plugins.require(ComponentKind::neuron, use.id), use);
  }
  const std::vector<Vector3> forces = forces_at_start(network, result.springs, result.elements);
  result.nodes.resize(network.nodes().size());
  for (std::size_t k = 0; k < result.nodes.size(); ++k) {
    const Node& node = network.nodes()[k];
    LinearNode& linear = result.nodes[k];
    linear.free = !node.fixed;
    linear.force = forces[k];
    const NeuronAtRest& neuron = neurons[node.neuron];
    if (node.fixed || (neuron.differentiable() && neuron.answer(node, forces[k], linear))) continue;
    if (result.unknown_because.empty()) {
      result.unknown_because = "the neuron of node " + std::to_string(k) + ", '" + network.neurons()[node.neuron].id +
                               "', offers no derivatives where it starts";
    }
  }
  for (const Move& move : network.moves()) {
    for (const NodeIndex node : move.nodes) result.nodes[node].free = false;
  }
  return result;
}

}  // namespace springnet
