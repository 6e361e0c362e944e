// Laws given as formulas, in text: no compiler, no plugin. A formula is read once, differentiated, and run over many
// springs at a time with the mathematics of the SDK; results have the bits of the same formula in a compiled plugin.
//
//   springnet::LawFormula fene;
//   fene.force = "stiffness * e / (1 - (e / limit)^2)";
//   fene.parameters = {{"stiffness", "N/m"}, {"limit", "m"}};
//   net.add_material({springnet::law_of(fene, {{"stiffness", 3.0}, {"limit", 0.5}}), std::nullopt});
//
// core/docs/formulas.md has the language.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet {

// A parameter or an input signal of a formula. Bounds and scale are in its unit.
struct FormulaSymbol {
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  std::string name;                                 // lower-case letters, digits and '_', a letter first
  std::string unit = "";                            // SI, as "N/m", "1" for none; empty: not said, and not checked
  double preset = none;                             // nan: a use has to give it; of an input: 0
  std::string summary = "";                         // one line
  double smallest = -infinity, largest = infinity;  // values beyond are refused
  bool excludes_smallest = false;                   // values must be above `smallest`
  double scale = none;                              // typical magnitude, above 0; nan: that of the preset, or 1
  bool learnable = true;                            // of a parameter: identification may change it
};
// A function given by points, which formulas call by its name: the monotone cubic of Fritsch and Carlson through them,
// straight beyond the first and the last.
struct FormulaCurve {
  std::string name;
  std::vector<double> x, y;
};
// An internal state of a law: it starts at `start` and changes by `rate`, a formula that may read it. Steps are those
// of the SDK (backward Euler, and its extrapolation of second order); one that would leave the bounds is tried again
// with smaller steps, as with a law in C++.
struct FormulaState {
  std::string name;
  std::string rate;  // per second
  double start = 0.0;
  std::string unit = "";
  std::string summary = "";  // one line
  double smallest = -FormulaSymbol::infinity, largest = FormulaSymbol::infinity;
  double scale = FormulaSymbol::none;  // typical magnitude, above 0, for tolerances; nan: that of the start, or 1
};
// One of the scalars that a law over several of them reads: "length(0, 1)", "angle(0, 1, 2)", "area(0, 1, 2)",
// "volume(0, 1, 2, 3)", "dihedral(0, 1, 2, 3)" of the nodes of an element.
struct FormulaScalar {
  std::string name, of;
};

struct LawFormula {
  ComponentKind kind = ComponentKind::spring_function;  // or viscosity_function
  std::string force;                                    // N, N m, …; empty: the derivative of the energy
  std::string energy;                                   // J; empty: none
  std::string margin;                                   // to rupture, 1 when unloaded; empty: none
  std::vector<FormulaSymbol> parameters, inputs;
  std::vector<FormulaCurve> curves;
  std::vector<FormulaState> states;  // at most 2, of a law over one invariant
  // Of a law over several scalars: which, of which elements; `forces` in their order, or empty with an energy.
  Invariant shape = Invariant::triangle;
  std::vector<FormulaScalar> scalars;
  std::vector<std::string> forces;
  // Where the formulas hold: value / reference, of a law over one invariant. As with laws in C++, the formulas
  // themselves have to be nan beyond.
  double smallest_stretch = 0.0, largest_stretch = FormulaSymbol::infinity;
  // What the law promises: the constants of these names of laws in C++ (sdk/README.md); pulls_only is the opposite of
  // acts_in_compression.
  bool pulls_only = false, monotone = false, not_zero_at_rest = false, adds_power = false;
  bool smooth_rates = false;  // of a law with states
  std::string summary;        // one line; empty: the formula
};

// Names in the formulas that are none of the language's, of `inputs` and of `curves`, in the order in which they
// appear: the parameters. Throws Error(input) for a formula that cannot be read.
[[nodiscard]] SPRINGNET_API std::vector<std::string> parameters_of(const LawFormula& formula);

// The elements that scalars are of, by the nodes that they read: hinges if one is a dihedral angle, tetrahedra if one
// has node 3, chains if all there is of three nodes is the angle at node 1, else triangles. Throws Error(input) for a
// scalar that cannot be read.
[[nodiscard]] SPRINGNET_API Invariant shape_of(const std::vector<FormulaScalar>& scalars);

// The law as a component. Throws Error(input) that says what is wrong, with its column and a caret: a name that is not
// known, a parameter that no formula reads, units that fit neither springs nor elements of one kind, a formula that is
// too long.
[[nodiscard]] SPRINGNET_API std::shared_ptr<const Component> component_of(const LawFormula& formula);

// Checks the units of a law over one invariant for a use: on elements, or on springs. Throws Error(input) for those
// that do not fit: with `e` in rad a stiffness is in N m, in m it is in N/m. Does nothing if no parameter has a unit.
SPRINGNET_API void check_units(const LawFormula& formula, std::optional<Invariant> elements);

// The formula that a component was made of by component_of(), as long as the component lives; null for all others.
[[nodiscard]] SPRINGNET_API const LawFormula* formula_of(const Component& component);

// A use of it in a material, with values of its parameters.
[[nodiscard]] SPRINGNET_API LawUse law_of(const LawFormula& formula, const ParameterValues& parameters);

}  // namespace springnet
