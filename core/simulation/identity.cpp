#include "simulation/identity.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "plugin_host/law_use.hpp"
#include "text/digest.hpp"

namespace springnet {
namespace {

// Longer values are told by their number and digest.
constexpr std::size_t longest_text = 300;
constexpr std::size_t most_told = 12;

// Functions of the fields of a description. A field that is added to one of these does not compile until it is here.
void add(Digest& digest, const Motion& motion) {
  const auto& [interpolation, times, displacements, amplitude, frequency, phase, from, until] = motion;
  digest.add(interpolation);
  digest.add(times);
  digest.add(displacements);
  digest.add(amplitude);
  for (const double each : {frequency, phase, from, until}) digest.add(each);
}
void add(Digest& digest, const Turn& turn) {
  const auto& [axis, through, rate, from, until, times, angles, interpolation] = turn;
  digest.add(axis);
  digest.add(through);
  for (const double each : {rate, from, until}) digest.add(each);
  digest.add(times);
  digest.add(angles);
  digest.add(interpolation);
}
void add(Digest& digest, const Course& course) {
  const auto& [times, factors, interpolation, frequency, phase, amplitude, mean, ramp] = course;
  digest.add(times);
  digest.add(factors);
  digest.add(interpolation);
  for (const double each : {frequency, phase, amplitude, mean, ramp}) digest.add(each);
}
void add(Digest& digest, const Signal& signal) {
  const auto& [interpolation, times, values, mean, amplitude, frequency, phase] = signal;
  digest.add(interpolation);
  digest.add(times);
  digest.add(values);
  for (const double each : {mean, amplitude, frequency, phase}) digest.add(each);
}
void add(Digest& digest, const Friction& friction) {
  const auto& [kind, coefficient] = friction;
  digest.add(kind);
  digest.add(coefficient);
}
void add(Digest& digest, const BoxShape& box) {
  const auto& [size, axes, radius] = box;
  digest.add(size);
  for (Eigen::Index k = 0; k < axes.size(); ++k) digest.add(axes.data()[k]);
  digest.add(radius);
}
template <class Value>
void add(Digest& digest, const std::optional<Value>& value) {
  digest.add(value.has_value());
  if (value) add(digest, *value);
}
void add(Digest& digest, const Plane& plane) {
  const auto& [name, point, normal, friction, motion, turn, restitution] = plane;
  digest.add(point);
  digest.add(normal);
  add(digest, friction);
  digest.add(restitution);
}
void add(Digest& digest, const Instrument& instrument) {
  const auto& [name, first, second, radius, friction, motion, turn, restitution, box] = instrument;
  digest.add(first);
  digest.add(second);
  digest.add(radius);
  add(digest, friction);
  digest.add(restitution);
  add(digest, box);
}
void add(Digest& digest, const BodyContact& contact) {
  const auto& [name, first, second, friction, restitution] = contact;
  digest.add(first);
  digest.add(second);
  add(digest, friction);
  digest.add(restitution);
}
void add(Digest& digest, const Load& load) {
  const auto& [nodes, force, from, until, faces, traction, pressure, follow, course, areas] = load;
  digest.add(nodes);
  digest.add(force);
  digest.add(from);
  digest.add(until);
  digest.add(faces);
  digest.add(traction);
  digest.add(pressure);
  digest.add(follow);
  add(digest, course);
  digest.add(areas);
}
void add(Digest& digest, const Move& move) {
  const auto& [nodes, motion] = move;
  digest.add(nodes);
  add(digest, motion);
}
void add(Digest& digest, const Rigid& rigid) {
  const auto& [first, second, length] = rigid;
  digest.add(first);
  digest.add(second);
  digest.add(length);
}
void add(Digest& digest, const Cut& cut) {
  const auto& [time, springs, polygon] = cut;
  digest.add(time);
  digest.add(springs);
  digest.add(polygon);
}
void add(Digest& digest, const ParameterValues& values) {
  digest.add(static_cast<std::uint64_t>(values.size()));
  for (const auto& [name, value] : values) {
    digest.add(std::string_view(name));
    digest.add(value);
  }
}
void add(Digest& digest, const Change& change) {
  digest.add(change.time);
  digest.add(change.springs);
  digest.add(change.elements);
  digest.add(change.nodes);
  for (const ParameterValues* each :
       {&change.spring, &change.viscosity, &change.spring_inputs, &change.viscosity_inputs, &change.neuron})
    add(digest, *each);
  for (const std::optional<double>& each : {change.reference, change.reference_scale, change.mass}) digest.add(each);
  digest.add(change.remove);
  digest.add(change.integrator.has_value());
  if (!change.integrator) return;
  digest.add(std::string_view(change.integrator->id));
  add(digest, change.integrator->parameters);
}
void add(Digest& digest, const Input& input) {
  const auto& [reads, name, springs, elements, signal] = input;
  digest.add(std::string_view(reads));
  digest.add(springs);
  digest.add(elements);
  add(digest, signal);
}

std::string counted(std::size_t count, Digest& digest) { return fmt::format("{} ({:08x})", count, digest.value()); }

class Parts {
 public:
  void add(std::string name, std::string value) { result.emplace_back(std::move(name), std::move(value)); }
  // of(digest, each) adds what counts of each.
  template <class List, class Of>
  void list(std::string name, const List& list, const Of& of) {
    Digest digest;
    for (const auto& each : list) of(digest, each);
    add(std::move(name), counted(list.size(), digest));
  }
  template <class List>
  void list(std::string name, const List& list) {
    this->list(std::move(name), list, [](Digest& digest, const auto& each) { springnet::add(digest, each); });
  }

  Identity result;
};

void add_nodes(Parts& parts, const NodeList& nodes) {
  Digest positions, velocities, masses, neurons, fixed;
  static_assert(sizeof(Vector3) == 3 * sizeof(double));
  positions.bytes(nodes.positions().data(), nodes.size() * sizeof(Vector3));
  for (const Node& node : nodes) {
    velocities.add(node.velocity);
    masses.add(node.mass);
    neurons.add(node.neuron);
    fixed.add(node.fixed);
  }
  const std::size_t count = nodes.size();
  parts.add("nodes", fmt::format("{}", count));
  parts.add("positions of nodes at the start", counted(count, positions));
  parts.add("velocities of nodes at the start", counted(count, velocities));
  parts.add("masses of nodes", counted(count, masses));
  parts.add("neurons of nodes", counted(count, neurons));
  parts.add("fixed nodes", counted(count, fixed));
}

void add_springs(Parts& parts, const SpringList& springs) {
  Digest ends, materials, lengths;
  static_assert(sizeof(SpringList::Ends) == 2 * sizeof(NodeIndex));
  ends.bytes(springs.ends().data(), springs.size() * sizeof(SpringList::Ends));
  for (std::size_t s = 0; s < springs.size(); ++s) {
    materials.add(springs.materials()[s]);
    lengths.add(springs.rest_lengths()[s]);
  }
  parts.add("springs", fmt::format("{}", springs.size()));
  parts.add("ends of springs", counted(springs.size(), ends));
  parts.add("materials of springs", counted(springs.size(), materials));
  parts.add("rest lengths of springs", counted(springs.size(), lengths));
}

void add_elements(Parts& parts, const std::vector<Element>& elements) {
  const auto list = [&](std::string name, auto... fields) {
    parts.list(std::move(name), elements,
               [&](Digest& digest, const Element& element) { (digest.add(element.*fields), ...); });
  };
  list("elements", &Element::invariant);
  list("nodes of elements", &Element::nodes);
  list("materials of elements", &Element::material);
  list("references of elements", &Element::reference);
  list("shapes and directions of elements at rest", &Element::rest, &Element::direction);
}

// Components, parameters and tables of the laws of all materials, or of neurons.
class Uses {
 public:
  void add(const LawUse& use, ComponentKind kind, const PluginHost& plugins) {
    const std::shared_ptr<const Component> component = component_of(use, kind, plugins);
    const std::string text = identity_text(*component);
    components_.add(std::string_view(text));
    if (std::find(told_.begin(), told_.end(), text) == told_.end() && told_.size() < most_told) told_.push_back(text);
    const std::vector<double> values = complete_parameters(*component->description, use.parameters, use.id);
    parameters_.add(values);
    if (count_ < most_told && parameter_text_.size() <= longest_text && !values.empty())
      parameter_text_ += fmt::format("{}{}: {}", parameter_text_.empty() ? "" : "; ", component->id(),
                                     parameters_text(*component, values));
    for (const auto& [name, table] : use.tables) {
      tables_.add(std::string_view(name));
      tables_.add(table);
      table_values_ += table.size();
    }
    ++count_;
  }
  void none() { components_.add(std::string_view()); }
  void tell(Parts& parts, const std::string& what, bool with_tables) {
    std::string text;
    for (const std::string& each : told_) text += (text.empty() ? "" : ", ") + each;
    parts.add(what, fmt::format("{} ({:08x}): {}", count_, components_.value(), text));
    const bool short_enough = count_ <= most_told && parameter_text_.size() <= longest_text;
    parts.add("parameters of " + what, short_enough ? parameter_text_ : counted(count_, parameters_));
    if (with_tables) parts.add("tables of " + what, counted(table_values_, tables_));
  }

 private:
  Digest components_, parameters_, tables_;
  std::vector<std::string> told_;
  std::string parameter_text_;
  std::size_t count_ = 0, table_values_ = 0;
};

void add_laws(Parts& parts, const Network& network, const PluginHost& plugins) {
  Uses laws;
  for (const Material& material : network.materials())
    for (const ComponentKind kind : {ComponentKind::spring_function, ComponentKind::viscosity_function}) {
      const std::optional<LawUse>& use = kind == ComponentKind::spring_function ? material.spring : material.viscosity;
      if (use)
        laws.add(*use, kind, plugins);
      else
        laws.none();
    }
  laws.tell(parts, "the laws", true);
  // Those that nodes have, alone: nobody asks whether the others exist.
  std::vector<std::uint8_t> used(network.neurons().size(), 0);
  for (const Node& node : network.nodes()) used[node.neuron] = 1;
  Uses neurons;
  for (std::size_t k = 0; k < used.size(); ++k) {
    if (used[k] != 0)
      neurons.add(network.neurons()[k], ComponentKind::neuron, plugins);
    else
      neurons.none();
  }
  neurons.tell(parts, "the neurons", false);
}

void add_surfaces(Parts& parts, const Network& network) {
  parts.list("planes", network.planes());
  parts.list("instruments", network.instruments());
  parts.list("contacts of bodies", network.contacts());
  if (!network.contacts().empty())
    parts.list("thickness and radius of bodies", network.bodies(), [](Digest& digest, const Body& body) {
      digest.add(body.thickness);
      digest.add(body.radius);
    });
  Digest motions;
  for (const Plane& plane : network.planes()) {
    add(motions, plane.motion);
    add(motions, plane.turn);
  }
  for (const Instrument& instrument : network.instruments()) {
    add(motions, instrument.motion);
    add(motions, instrument.turn);
  }
  parts.add("motions of planes and instruments",
            counted(network.planes().size() + network.instruments().size(), motions));
}

}  // namespace

std::string identity_text(const Component& component) {
  return fmt::format("{}@{} {}", component.id(), component.plugin->id, component.plugin->version);
}

std::string parameters_text(const Component& component, const std::vector<double>& values) {
  std::string text;
  for (std::size_t k = 0; k < values.size(); ++k)
    text += fmt::format("{}{} {}", k == 0 ? "" : ", ", component.description->parameters[k]->name, values[k]);
  return text;
}

Identity identity_of(const Network& network, const PluginHost& plugins) {
  Parts parts;
  add_laws(parts, network, plugins);
  add_nodes(parts, network.nodes());
  add_springs(parts, network.springs());
  add_elements(parts, network.elements());
  parts.list("rigid connections", network.rigids());
  add_surfaces(parts, network);
  parts.list("prescribed motions of nodes", network.moves());
  parts.list("loads", network.loads());
  const Vector3& g = network.gravity();
  parts.add("gravity", fmt::format("({}, {}, {}) m/s^2", g[0], g[1], g[2]));
  parts.list("input signals", network.inputs());
  parts.list("cuts", network.cuts());
  parts.list("changes", network.changes());
  return std::move(parts.result);
}

}  // namespace springnet
