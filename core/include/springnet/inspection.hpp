// Properties of a network before it is simulated: counts, ranges, parts, limits of the time step, likely input
// mistakes. Springs, elements and neurons are linearised at the start, at rest. core/docs/inspect.md explains the
// numbers.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet {

struct Range {
  double smallest;
  double largest;
};

// What sets a limit: the node that moves most in the mode that grows first, and the spring or element with the greatest
// share of w^2 K / m and w D / m on it at the limit (w: the time constant times theta).
struct Bottleneck {
  NodeIndex node;
  double mass;  // kg
  // The node's spring with the greatest share, or an element with a greater one; neither: the neuron itself. An
  // element's stiffness is that of the node's motion along dq/dp with the other nodes fixed.
  std::optional<SpringIndex> spring;
  std::optional<ElementIndex> element;
  double stiffness;      // N/m
  double damping;        // N s/m
  double elastic_share;  // w^2 k / m
  double viscous_share;  // w d / m
};

// The time step above which an integrator, or one of its update rules, no longer settles or is no longer stable, as
// reported by the integrator.
struct TimeConstantLimit {
  enum class Kind {
    known,     // to about a per cent
    estimate,  // the iteration ended before it was that accurate, as in nets of a million nodes
    none,      // there is no such time step, or only one thousands of times that of other rules
    unknown    // a law or neuron cannot be linearised
  };
  std::string integrator;  // id
  std::string rule;        // as the integrator names it; empty if it has no rules to choose from
  Kind kind = Kind::unknown;
  double time_constant = 0.0;  // s; 0 if there is none or it is unknown
  std::string reason;          // why there is none, or why it is unknown; may be empty
  std::optional<Bottleneck> set_by;

  // The rule, or the integrator if it has no rules.
  [[nodiscard]] const std::string& name() const noexcept { return rule.empty() ? integrator : rule; }
};

// A connected part of the network: nodes joined by springs, elements and rigid connections.
struct Part {
  NodeIndex first_node;  // the lowest
  std::size_t nodes = 0;
  std::size_t springs = 0;
  std::size_t fixed_nodes = 0;  // moved ones count as fixed
};

// A spring with an unusual value.
struct UnusualSpring {
  SpringIndex spring;
  NodeIndex first, second;
  double value;
};
// Springs above a bound: their number, and the worst of them, at most `listed_at_most`, worst first.
struct UnusualSprings {
  double median = 0.0;  // of all springs that have such a value
  double bound = 0.0;
  std::size_t count = 0;
  std::vector<UnusualSpring> worst;
};
inline constexpr std::size_t listed_at_most = 5;
// Parts listed in the JSON and on the terminal.
inline constexpr std::size_t parts_listed_at_most = 10;
// Springs count as unusual above this many times the median,
inline constexpr double unusual_factor = 100.0;
// or if their length differs from the rest length by more than this part of it.
inline constexpr double unusual_strain = 0.2;
// Masses count as unusual if the greatest is more than this many times the smallest.
inline constexpr double unusual_mass_ratio = 1e4;

struct Suspicions {
  UnusualSprings stiffness;                      // N/m
  UnusualSprings damping;                        // N s/m
  UnusualSprings elastic_rate;                   // k (1/m1 + 1/m2), 1/s^2; a fixed end adds nothing
  UnusualSprings viscous_rate;                   // d (1/m1 + 1/m2), 1/s
  UnusualSprings strain;                         // |l - l0| / l0, of spring functions with a rest length above 0
  std::size_t springs_without_direction = 0;     // their ends coincide, so that they exert no force
  std::size_t springs_that_soften = 0;           // the tension falls with the length
  std::vector<NodeIndex> nodes_without_springs;  // the first of them, at most listed_at_most
  std::optional<NodeIndex> lightest, heaviest;   // free nodes, where masses are unusual
};

// Motions that, to first order, no spring function (of springs or elements) and no rigid connection resists: the null
// space of the matrix of directions (of elements dq/dp). Springs under tension may still resist them.
struct Mobility {
  bool known = false;                  // false: not computed, the net is too large
  std::size_t mechanisms = 0;          // besides motions as a rigid body
  std::size_t rigid_body_motions = 0;  // 6 for a part without fixed nodes, 3 for a single node, …
  std::size_t redundant_rigids = 0;    // rigid connections implied by others
  std::size_t springs_under_tension = 0;
  std::size_t springs_under_compression = 0;
};

struct InspectionOptions {
  LawUse integrator{"recurrent", {}};  // of the scene; its limits come first, the others' follow with their defaults
  std::optional<double> time_step{};   // s: that of the scene
  std::optional<double> duration{};    // s: likewise
  bool adaptive_steps = false;         // the integrator divides time steps by an error test, as cvode does

  // The integrator's parameter theta; 1 if it is not given.
  [[nodiscard]] SPRINGNET_API double theta() const;
};

// The slowest motion that springs resist, linearised at the start.
struct Vibration {
  double period;         // s, undamped
  double damping_ratio;  // 1: critical; above 1 there is no oscillation
};
// Vibrations with a damping ratio below this should be resolved by time steps,
inline constexpr double damped_out = 0.5;
// and this many a period at least.
inline constexpr double steps_a_period = 10.0;

// A likely input mistake, most often a wrong unit.
struct Hint {
  enum class Kind { size, mass, density, gravity, start, fall, time_step, kinks };
  Kind kind;
  std::string text;  // sentences: the finding, with its numbers, and what to do
};
[[nodiscard]] SPRINGNET_API std::string_view name_of(Hint::Kind kind) noexcept;  // "size", …, "time step", "kinks"

struct Inspection {
  std::size_t nodes = 0, springs = 0, bodies = 0, fixed_nodes = 0, planes = 0, loads = 0, cuts = 0;
  std::size_t rigids = 0, instruments = 0;
  std::size_t moved_nodes = 0;                             // by a motion of the scene; counted in fixed_nodes as well
  std::map<std::string, std::size_t> spring_functions;     // springs by id; "none": viscous connections
  std::map<std::string, std::size_t> viscosity_functions;  // springs by id; "none": undamped springs
  std::map<std::string, std::size_t> neurons;              // nodes by id
  std::map<std::string, std::size_t> elements;             // by the name of their invariant
  // Elements by id, as those of springs.
  std::map<std::string, std::size_t> element_spring_functions, element_viscosity_functions;

  double total_mass = 0.0;             // kg
  std::optional<Range> mass;           // kg, one node
  std::optional<Range> length;         // m, at the start
  std::optional<Range> rest_length;    // m
  std::optional<Range> stiffness;      // N/m: dQ/dq at the start, of laws that have derivatives
  std::optional<Range> damping;        // N s/m at rest, likewise
  std::size_t springs_under_load = 0;  // length differs from rest length by more than 1e-9 of it
  Vector3 lower = Vector3::Zero();     // m, corners of the box around all nodes
  Vector3 upper = Vector3::Zero();

  std::vector<Part> parts;                // by falling number of nodes, then rising first node
  std::size_t nodes_without_springs = 0;  // nor elements nor rigid connections; each is a part
  double memory_bytes = 0.0;              // estimate for a run of explicit steps

  InspectionOptions options;
  std::vector<TimeConstantLimit> limits;  // of every installed integrator that reports any, rule by rule
  std::string unknown_because;            // why limits are unknown; else empty
  // s: up to this time constant the equation of a step, linearised at the start, has a unique solution; beyond, springs
  // that push or soften give several (buckling). Empty: unique for every time step, or unknown.
  std::optional<double> unique_time_constant;

  Mobility mobility;
  // Empty if a law cannot be linearised, nothing vibrates, the net is too large, or there are rigid connections,
  // enclosed volumes, many mechanisms or compressed springs that buckle.
  std::optional<Vibration> slowest;
  Suspicions suspicions;
  std::vector<Hint> hints;

  // The limit with this name(). Throws Error(input) if there is none.
  [[nodiscard]] SPRINGNET_API const TimeConstantLimit& limit(std::string_view name) const;
};

// Throws Error(plugin) for a component that `plugins` does not have, Error(input) for parameters it does not take.
[[nodiscard]] SPRINGNET_API Inspection inspect(const Network& network, const PluginHost& plugins,
                                               const InspectionOptions& options = {});

// As JSON.
[[nodiscard]] SPRINGNET_API std::string to_json(const Inspection& inspection);

}  // namespace springnet
