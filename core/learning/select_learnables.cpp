// "spring.stiffness@cube:together": what of a network is learned, as text.
#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/error.hpp>
#include <springnet/learn.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

namespace springnet {

namespace {

using Kind = LearnedValues::Kind;

struct Selection {
  std::string_view text, what, body;
  bool together = false;
};

[[noreturn]] void refuse(std::string_view text, const std::string& why) {
  throw Error(ErrorKind::input, fmt::format("what is learned, '{}': {}", printable(std::string(text)), why));
}

Selection parse(std::string_view text) {
  Selection result{text, text, {}, false};
  if (const std::size_t at = result.what.find(':'); at != std::string_view::npos) {
    if (result.what.substr(at) != ":together")
      refuse(text, "only ':together' may follow a ':', at the end, behind '@BODY'");
    result.together = true;
    result.what = result.what.substr(0, at);
  }
  if (const std::size_t at = result.what.find('@'); at != std::string_view::npos) {
    result.body = result.what.substr(at + 1);
    result.what = result.what.substr(0, at);
    if (result.body.empty()) refuse(text, "the name of a body follows '@'");
  }
  return result;
}

// Components that have the parameter, and declare it learnable.
class Declared {
 public:
  Declared(const PluginHost& plugins, ComponentKind kind, std::string_view name)
      : plugins_(plugins), kind_(kind), name_(name) {}
  [[nodiscard]] bool has(const std::optional<LawUse>& use) {
    if (!use) return false;
    const std::shared_ptr<const Component> component =
        use->component ? use->component : plugins_.require(kind_, use->id);
    for (std::uint32_t k = 0; k < component->description->parameter_count; ++k) {
      const springnet_parameter& each = *component->description->parameters[k];
      const bool learnable = (each.flags & SPRINGNET_LEARNABLE) != 0;
      if (learnable) known_.insert(each.name);
      if (name_ == each.name && !learnable) refuse(name_, fmt::format("'{}' does not declare it learnable", use->id));
      if (name_ == each.name) return true;
    }
    return false;
  }
  [[noreturn]] void none(std::string_view text, std::string_view whose) const {
    const std::vector<std::string> known(known_.begin(), known_.end());
    const std::string nearest = suggestion(name_, known);
    refuse(text, fmt::format("no law of {} has a parameter '{}'{}{}; learnable are: {}", whose, name_,
                             nearest.empty() ? "" : "; ", nearest,
                             known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))));
  }

 private:
  const PluginHost& plugins_;
  ComponentKind kind_;
  std::string name_;
  std::set<std::string> known_;
};

// Which springs, elements and nodes.
struct Range {
  std::size_t first = 0, last = 0;
};

struct Of {
  Range springs, elements, nodes;
};

Of members_of(const Network& network, const Selection& selection) {
  if (selection.body.empty())
    return {{0, network.springs().size()}, {0, network.elements().size()}, {0, network.nodes().size()}};
  std::vector<std::string> names;
  for (const Body& body : network.bodies()) {
    if (body.name == selection.body) {
      const auto range = [](std::size_t first, std::size_t count) { return Range{first, first + count}; };
      return {range(body.first_spring, body.spring_count), range(body.first_element, body.element_count),
              range(body.first_node, body.node_count)};
    }
    names.push_back(body.name);
  }
  const std::string nearest = suggestion(selection.body, names);
  refuse(selection.text, fmt::format("there is no body '{}'{}{}", printable(std::string(selection.body)),
                                     nearest.empty() ? "" : "; ", nearest));
}

template <class Takes>
std::vector<std::uint32_t> list(const Range& range, const Takes& takes) {
  std::vector<std::uint32_t> result;
  for (std::size_t k = range.first; k < range.last; ++k)
    if (takes(static_cast<std::uint32_t>(k))) result.push_back(static_cast<std::uint32_t>(k));
  return result;
}

constexpr std::string_view grammar =
    "write spring.NAME, viscosity.NAME, element.spring.NAME, element.viscosity.NAME, neuron.NAME, rest_length, "
    "reference, "
    "mass or velocity, then @BODY for one body alone, and :together for one value of all";

}  // namespace

Learnable select_learnable(const Network& network, const PluginHost& plugins, std::string_view text) {
  const Selection selection = parse(text);
  const Of of = members_of(network, selection);
  Learnable result;
  result.together = selection.together;
  LearnedValues& values = result.values;
  const auto moves = [&](std::uint32_t node) { return !network.nodes()[node].fixed; };
  std::string_view rest = selection.what;
  const auto starts = [&](std::string_view with) {
    if (!rest.starts_with(with)) return false;
    rest.remove_prefix(with.size());
    return true;
  };
  if (rest == "mass" || rest == "velocity") {
    values.kind = rest == "mass" ? Kind::mass : Kind::initial_velocity;
    values.members = list(of.nodes, moves);
  } else if (rest == "rest_length" || rest == "reference") {
    values.kind = Kind::rest_length;
    values.of_elements = rest == "reference";
    values.members = list(values.of_elements ? of.elements : of.springs, [](std::uint32_t) { return true; });
  } else if (starts("neuron.")) {
    values.kind = Kind::neuron_parameter;
    values.parameter = rest;
    Declared declared(plugins, ComponentKind::neuron, rest);
    values.members = list(of.nodes, [&](std::uint32_t node) {
      return moves(node) && declared.has(network.neurons()[network.nodes()[node].neuron]);
    });
    if (values.members.empty()) declared.none(text, "these neurons");
  } else {
    values.of_elements = starts("element.");
    const bool is_spring = starts("spring.");
    if (!is_spring && !starts("viscosity.")) refuse(text, std::string(grammar));
    values.kind = is_spring ? Kind::spring_parameter : Kind::viscosity_parameter;
    values.parameter = rest;
    Declared declared(plugins, is_spring ? ComponentKind::spring_function : ComponentKind::viscosity_function, rest);
    values.members = list(values.of_elements ? of.elements : of.springs, [&](std::uint32_t member) {
      const MaterialIndex material =
          values.of_elements ? network.elements()[member].material : network.springs()[member].material;
      const Material& both = network.materials()[material];
      return declared.has(is_spring ? both.spring : both.viscosity);
    });
    if (values.members.empty()) declared.none(text, values.of_elements ? "these elements" : "these springs");
  }
  if (values.members.empty()) refuse(text, "there is nothing of this kind");
  return result;
}

}  // namespace springnet
