// Formulas as components, which all that uses laws takes as it takes those of plugins.
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <deque>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/formula.hpp>
#include <springnet/printable.hpp>

#include "formula/law.hpp"
#include "formula/units.hpp"
#include "plugin_host/check_plugin.hpp"
#include "plugin_host/message.hpp"
#include "text/digest.hpp"

namespace springnet {
namespace {

using formula::Law;

// Tells a formula from others as a plugin's version tells it from earlier ones: of all that its values depend on.
std::string version_of(const LawFormula& formula) {
  const auto& [kind, force, energy, margin, parameters, inputs, curves, states, shape, scalars, forces,
               smallest_stretch, largest_stretch, pulls_only, monotone, not_zero_at_rest, adds_power, smooth_rates,
               summary] = formula;
  Digest digest;
  const auto text = [&](const std::string& each) { digest.add(std::string_view(each)); };
  digest.add(kind);
  for (const std::string* each : {&force, &energy, &margin}) text(*each);
  for (const std::vector<FormulaSymbol>* list : {&parameters, &inputs})
    for (const FormulaSymbol& each : *list) {
      text(each.name);
      digest.add(each.preset);
    }
  for (const FormulaCurve& each : curves) {
    text(each.name);
    digest.add(each.x);
    digest.add(each.y);
  }
  for (const FormulaState& each : states) {
    text(each.name);
    text(each.rate);
    for (const double value : {each.start, each.smallest, each.largest, each.scale}) digest.add(value);
  }
  digest.add(shape);
  for (const FormulaScalar& each : scalars) {
    text(each.name);
    text(each.of);
  }
  for (const std::string& each : forces) text(each);
  for (const double value : {smallest_stretch, largest_stretch}) digest.add(value);
  for (const bool promise : {pulls_only, monotone, not_zero_at_rest, adds_power, smooth_rates}) digest.add(promise);
  return fmt::format("{:08x}", digest.value());
}

// "length(0, 1)" and so on.
springnet_invariant scalar_of(const FormulaScalar& scalar) {
  struct Kind {
    std::string_view name;
    std::uint32_t kind, corners;
  };
  constexpr Kind kinds[] = {{"length", SPRINGNET_LENGTH, 2},
                            {"angle", SPRINGNET_ANGLE, 3},
                            {"area", SPRINGNET_AREA, 3},
                            {"volume", SPRINGNET_VOLUME, 4},
                            {"dihedral", SPRINGNET_DIHEDRAL, 4}};
  const auto refuse = [&](std::string_view what) {
    throw Error(ErrorKind::input, fmt::format("scalar '{}': '{}' {}", scalar.name, printable(scalar.of), what));
  };
  const formula::Expression written = formula::parse_scalar(scalar.of);
  const formula::Term& call = written[written.root];
  for (const Kind& each : kinds) {
    if (call.name != each.name) continue;
    if (call.arguments.size() != each.corners)
      refuse(fmt::format("has {} nodes; {} takes {}", call.arguments.size(), each.name, each.corners));
    springnet_invariant result{sizeof(springnet_invariant), each.kind, {}, 0, 0};
    for (std::size_t c = 0; c < call.arguments.size(); ++c) {
      const double corner = written[call.arguments[c]].number;
      if (!(corner == std::floor(corner)) || !(corner <= 3.0)) refuse("takes numbers of nodes, 0 to 3");
      result.corners[c] = static_cast<std::uint32_t>(corner);
    }
    return result;
  }
  refuse("is none; write length(0, 1), angle(0, 1, 2), area(0, 1, 2), volume(0, 1, 2, 3) or dihedral(0, 1, 2, 3)");
  return {};
}

std::uint32_t number_of(Invariant shape) {
  switch (shape) {
    case Invariant::chain:
      return SPRINGNET_CHAIN;
    case Invariant::triangle:
      return SPRINGNET_TRIANGLE;
    case Invariant::hinge:
      return SPRINGNET_HINGE;
    case Invariant::tetrahedron:
      return SPRINGNET_TETRAHEDRON;
    default:
      throw Error(ErrorKind::input,
                  fmt::format("a law over several scalars is for elements of the shape chain, triangle, hinge or "
                              "tetrahedron, not {}",
                              name_of(shape)));
  }
}

// The component and all that it points to. Does not move.
struct FormulaComponent {
  explicit FormulaComponent(const LawFormula& given) : source(given), law(given), version(version_of(given)) {
    formula::check_units_of_some_use(given);
    describe(source.parameters, true, parameters, parameter_list);
    describe(source.inputs, false, inputs, input_list);
    for (std::size_t k = 0; k < given.scalars.size(); ++k) {
      springnet_invariant& one = invariants.emplace_back(scalar_of(given.scalars[k]));
      if (!law.reads().value[k]) one.flags = SPRINGNET_REFERENCE_ONLY;
      invariant_list.push_back(&one);
    }
    const formula::Reads& reads = law.reads();
    const bool several = !given.scalars.empty();
    implementation.struct_size = sizeof implementation;
    implementation.invariant = several ? std::uint32_t{SPRINGNET_SEVERAL} : reads.invariant;
    implementation.input_count = static_cast<std::uint32_t>(inputs.size());
    implementation.update_order = 1;
    implementation.inputs = input_list.data();
    implementation.smallest_stretch = given.smallest_stretch;
    implementation.largest_stretch = given.largest_stretch;
    implementation.context = &law;
    for (const FormulaState& each : source.states) {
      springnet_parameter& state = states.emplace_back(number(each));
      state.default_value = each.start;
      state.scale = formula::scale_of(each);
      state_list.push_back(&state);
    }
    implementation.state_count = static_cast<std::uint32_t>(states.size());
    implementation.states = state_list.data();
    if (!states.empty()) {
      implementation.update_order = 2;
      implementation.update = [](void* context, const springnet_law_update* update) noexcept -> springnet_status {
        springnet_message* const message = update->batch->message;
        try {
          if (static_cast<const Law*>(context)->update(*update)) return SPRINGNET_OK;
          if (message != nullptr)
            set_message(*message,
                        "no internal state satisfies the equation of its step within the bounds "
                        "that the law declares");
          return SPRINGNET_RECOVERABLE;
        } catch (const std::exception& error) {
          if (message != nullptr) set_message(*message, error.what());
          return SPRINGNET_FAILED;
        }
      };
    }
    implementation.evaluate = evaluate;
    if (several) {
      implementation.shape = number_of(given.shape);
      implementation.invariant_count = static_cast<std::uint32_t>(invariants.size());
      implementation.invariants = invariant_list.data();
      implementation.reads_direction = reads.direction ? 1 : 0;
    }
    component.struct_size = sizeof component;
    component.kind = static_cast<std::uint32_t>(given.kind);
    component.id = "formula";
    component.reference = "";
    summary = given.summary;
    if (summary.empty()) {
      summary = !given.force.empty() ? given.force : !given.energy.empty() ? "energy " + given.energy : "forces";
      if (summary.size() > 100) summary = "a formula";
    }
    std::replace_if(
        summary.begin(), summary.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    component.summary = summary.c_str();
    component.capabilities =
        SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_ALL_DERIVATIVES | SPRINGNET_HAS_PARAMETER_DERIVATIVES;
    const auto declare = [&](bool has, std::uint64_t capability) {
      if (has) component.capabilities |= capability;
    };
    declare(!given.pulls_only, SPRINGNET_ACTS_IN_COMPRESSION);
    declare(given.monotone, SPRINGNET_MONOTONE);
    declare(given.not_zero_at_rest, SPRINGNET_NOT_ZERO_AT_REST);
    declare(given.adds_power, SPRINGNET_ADDS_POWER);
    declare(law.has_energy(), SPRINGNET_HAS_ENERGY);
    declare(law.has_margin(), SPRINGNET_HAS_RUPTURE);
    declare(reads.rate, SPRINGNET_READS_RATE);
    declare(reads.time, SPRINGNET_READS_TIME);
    declare(!several && reads.invariant == SPRINGNET_LENGTH && reads.fits_elements, SPRINGNET_FITS_ELEMENTS);
    declare(reads.divides_by_reference, SPRINGNET_DIVIDES_BY_REFERENCE);
    if (!inputs.empty()) component.needs |= SPRINGNET_NEEDS_INPUTS;
    if (several) component.needs |= SPRINGNET_NEEDS_SEVERAL;
    if (!states.empty()) component.needs |= SPRINGNET_NEEDS_STATES;
    component.parameter_count = static_cast<std::uint32_t>(parameters.size());
    component.parameters = parameter_list.data();
    component.implementation = &implementation;
    plugin = {SPRINGNET_MAGIC,
              sizeof plugin,
              SPRINGNET_ABI_MAJOR,
              SPRINGNET_ABI_MINOR,
              0,
              1,
              0,
              "formula",
              version.c_str(),
              "",
              "",
              list};
    if (const PluginCheck check = check_plugin(plugin); !check.wrong.empty())
      throw Error(ErrorKind::input, check.wrong);
  }
  FormulaComponent(const FormulaComponent&) = delete;
  FormulaComponent& operator=(const FormulaComponent&) = delete;

  static springnet_status evaluate(void* context, const springnet_law_batch* batch) noexcept {
    try {
      static_cast<const Law*>(context)->evaluate(*batch);
      return SPRINGNET_OK;
    } catch (const std::exception& error) {
      if (batch->message != nullptr) set_message(*batch->message, error.what());
      return SPRINGNET_FAILED;
    }
  }

  LawFormula source;
  Law law;
  std::string version, summary;
  std::deque<springnet_parameter> parameters, inputs, states;
  std::deque<springnet_invariant> invariants;
  std::vector<const springnet_parameter*> parameter_list, input_list, state_list;
  std::vector<const springnet_invariant*> invariant_list;
  springnet_law implementation{};
  springnet_component component{};
  const springnet_component* list[1] = {&component};
  springnet_plugin plugin{};

 private:
  // Of a parameter, an input or a state.
  template <class Symbol>
  static springnet_parameter number(const Symbol& symbol) {
    springnet_parameter result{};
    result.struct_size = sizeof result;
    result.type = SPRINGNET_NUMBER;
    result.name = symbol.name.c_str();
    result.unit = symbol.unit.empty() ? "1" : symbol.unit.c_str();
    result.summary = symbol.summary.c_str();
    result.smallest = symbol.smallest;
    result.largest = symbol.largest;
    return result;
  }
  static void describe(const std::vector<FormulaSymbol>& symbols, bool are_parameters,
                       std::deque<springnet_parameter>& to, std::vector<const springnet_parameter*>& addresses) {
    for (const FormulaSymbol& each : symbols) {
      springnet_parameter& parameter = to.emplace_back(number(each));
      const bool has_preset = !std::isnan(each.preset);
      if (are_parameters && each.learnable) parameter.flags |= SPRINGNET_LEARNABLE;
      if (are_parameters && !has_preset) parameter.flags |= SPRINGNET_REQUIRED;
      if (each.excludes_smallest) parameter.flags |= SPRINGNET_EXCLUDES_SMALLEST;
      if (has_preset) parameter.default_value = each.preset;
      parameter.scale = formula::scale_of(each);
      addresses.push_back(&parameter);
    }
  }
};

}  // namespace

std::vector<std::string> parameters_of(const LawFormula& formula) { return formula::free_names(formula); }

Invariant shape_of(const std::vector<FormulaScalar>& scalars) {
  bool has_fourth = false, has_angle = false, of_chain = true;
  for (const FormulaScalar& each : scalars) {
    const springnet_invariant scalar = scalar_of(each);
    if (scalar.kind == SPRINGNET_DIHEDRAL) return Invariant::hinge;
    const std::uint32_t(&corners)[4] = scalar.corners;
    has_fourth = has_fourth || std::find(std::begin(corners), std::end(corners), 3u) != std::end(corners);
    if (scalar.kind == SPRINGNET_ANGLE) {
      has_angle = true;
      of_chain = of_chain && corners[1] == 1;
    } else {
      // Not the side that a chain does not have.
      of_chain = of_chain && scalar.kind == SPRINGNET_LENGTH && (corners[0] == 1 || corners[1] == 1);
    }
  }
  if (has_fourth) return Invariant::tetrahedron;
  return has_angle && of_chain ? Invariant::chain : Invariant::triangle;
}

std::shared_ptr<const Component> component_of(const LawFormula& formula) {
  const auto owner = std::make_shared<const FormulaComponent>(formula);
  return std::make_shared<const Component>(Component{&owner->component, &owner->plugin, {}, owner});
}

const LawFormula* formula_of(const Component& component) {
  const ComponentKind kind = component.kind();
  if (kind != ComponentKind::spring_function && kind != ComponentKind::viscosity_function) return nullptr;
  if (component.law().evaluate != FormulaComponent::evaluate) return nullptr;
  return &static_cast<const FormulaComponent*>(component.owner.get())->source;
}

LawUse law_of(const LawFormula& formula, const ParameterValues& parameters) {
  return {"formula", parameters, {}, component_of(formula)};
}

}  // namespace springnet
