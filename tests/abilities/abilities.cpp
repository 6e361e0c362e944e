// Runs a small body of every law under every constraint in every integrator and update rule: each run works, or is
// refused with a reason that is known here. Compares the tables of what works with those of core/docs/abilities.md.
//   test_abilities PAGE            fails where the page has other tables, and prints the new ones
//   test_abilities --write PAGE    writes them
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/error.hpp>

#include "nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

constexpr double time_step = 0.005;  // s
constexpr int step_count = 6;

struct Law {
  std::string name;
  Material springs;
  std::function<void(Network&)> add;  // elements, loads
  LawUse neuron{"point_mass", {}};
  bool conserves = true;  // nothing feeds energy in
};

struct Constraint {
  std::string name;
  std::function<void(Network&)> add;
  // The gap between a point and the obstacle, m.
  std::function<double(const Vector3& point, double time)> gap;
  bool rests = true;  // does no work
};

struct Method {
  std::string name;
  LawUse integrator;
};

// The law of linear springs as an author may write it without derivatives.
const springnet_plugin& plain_plugin() {
  static const springnet_component component = [] {
    springnet_component linear = *plugins()->require(ComponentKind::spring_function, "linear")->description;
    linear.id = "plain";
    linear.capabilities &= ~(SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_PARAMETER_DERIVATIVES);
    return linear;
  }();
  static const springnet_component* const components[] = {&component};
  static const springnet_plugin plugin = [] {
    springnet_plugin own = *plugins()->require(ComponentKind::spring_function, "linear")->plugin;
    own.id = "test.plain";
    own.component_count = 1;
    own.components = components;
    return own;
  }();
  return plugin;
}
std::shared_ptr<const PluginHost> all_plugins() {
  static const auto host = [] {
    PluginHost all = PluginHost::with_default_search();
    all.add(plain_plugin());
    return std::make_shared<const PluginHost>(std::move(all));
  }();
  return host;
}

const Material basic = damped(50.0, 1.0);

// An element of the body, or the one of its surface, that is stretched by 5 %.
std::function<void(Network&)> element(Invariant invariant, const Material& material) {
  return [=](Network& net) {
    std::vector<NodeIndex> nodes{0, 1, 2, 4};
    if (invariant == Invariant::angle || invariant == Invariant::area) nodes = {1, 0, 2};
    if (invariant == Invariant::enclosed_volume) {
      nodes.clear();
      for (const Face& face : net.faces()) nodes.insert(nodes.end(), face.begin(), face.end());
    }
    const ElementIndex e = net.add_element(invariant, nodes, net.add_material(material));
    net.set_reference(e, 0.95 * net.elements()[e].reference);
  };
}

std::vector<Law> laws() {
  const auto of = [](LawUse spring) { return Material{std::move(spring), basic.viscosity}; };
  const auto with = [](LawUse viscosity) { return Material{basic.spring, std::move(viscosity)}; };
  const auto none = [](Network&) {};
  const auto pulling = [](Network& net) {
    Input input;
    input.input = "activation";
    for (SpringIndex k = 0; k < net.springs().size(); ++k) input.springs.push_back(k);
    input.signal.times = {0.0, 0.01, 0.03};
    input.signal.values = {0.0, 0.5, 0.2};
    net.add_input(input);
  };
  std::vector<Law> all{
      {"spring `linear`", basic, none},
      {"spring `nonlinear`", of({"nonlinear", {{"stiffness", 50}, {"cubic", 100}}}), none},
      {"spring `exponential`", of({"exponential", {{"stiffness", 50}, {"exponent", 3}}}), none},
      {"spring `rupturing`", of({"rupturing", {{"stiffness", 50}, {"strength", 1}}}), none},
      {"spring `maxwell`", of({"maxwell", {{"stiffness", 50}, {"relaxation_time", 0.1}}}), none},
      {"spring `standard_linear_solid`",
       of({"standard_linear_solid", {{"stiffness", 40}, {"fast_stiffness", 20}, {"relaxation_time", 0.1}}}), none},
      {"spring `plastic`",
       of({"plastic", {{"stiffness", 50}, {"yield_tension", 0.5}, {"hardening", 5}, {"relaxation_time", 0.05}}}), none},
      {"spring `damaging`",
       of({"damaging",
           {{"stiffness", 50}, {"threshold_strain", 0.01}, {"softening_strain", 0.2}, {"relaxation_time", 0.05}}}),
       none},
      {"spring `table`", of({"table", {}, {{"elongations", {-0.5, 0, 1}}, {"forces", {-30, 0, 50}}}}), none},
      {"spring `muscle`", of({"muscle", {{"strength", 5}}}), pulling, {"point_mass", {}}, false},
      {"spring in plain C, without derivatives", of({"plain", {{"stiffness", 50}}}), none},
      {"viscosity `power`", with({"power", {{"damping", 1}, {"exponent", 1.7}}}), none},
      {"viscosity `relative`", with({"relative", {{"damping", 1}}}), none},
      {"viscosity alone", {std::nullopt, basic.viscosity}, none},
      {"neuron `dragged`", basic, none, {"dragged", {{"drag", 0.5}}}}};
  const Material weak = damped(5.0, 0.1);
  for (const Invariant invariant :
       {Invariant::angle, Invariant::dihedral, Invariant::area, Invariant::volume, Invariant::enclosed_volume})
    all.push_back({fmt::format("element `{}`", name_of(invariant)), basic, element(invariant, weak)});
  all.push_back({"element `area` that ruptures", basic,
                 element(Invariant::area, {LawUse{"rupturing", {{"stiffness", 5}, {"strength", 0.1}}}, std::nullopt})});
  all.push_back({"element `volume`, viscosity `relative`", basic,
                 element(Invariant::volume, {std::nullopt, LawUse{"relative", {{"damping", 1}}}})});
  const auto press = [](Network& net) {
    Load load;
    load.faces = net.faces();
    load.pressure = -2.0;
    load.follow = true;
    net.add_load(load);
  };
  all.push_back({"pressure that follows faces", basic, press, {"point_mass", {}}, false});
  return all;
}

Motion swing() {
  Motion motion;
  motion.amplitude = {0.0, 0.01, 0.02};
  motion.frequency = 5.0;
  return motion;
}
Vector3 swung(double time) { return swing().amplitude * std::sin(2.0 * std::numbers::pi * 5.0 * time); }

std::function<void(Network&)> floor_of(const Friction& friction, double restitution = 0.0,
                                       const std::optional<Motion>& motion = std::nullopt) {
  return [=](Network& net) {
    Plane plane;
    plane.name = "floor";
    plane.friction = friction;
    plane.restitution = restitution;
    plane.motion = motion;
    net.add_plane(plane);
  };
}

// Under the body a fixed sheet of another one, at whose thickness its nodes come to 0 m.
constexpr double thickness = 0.02, sheet_side = 8.0;  // m
std::function<void(Network&)> sheet_of(const Friction& friction, double restitution = 0.0) {
  return [=](Network& net) {
    net.set_extent(0, thickness, 0.0);
    net.begin_body("sheet");
    const auto first = static_cast<NodeIndex>(net.nodes().size());
    for (int k = 0; k < 4; ++k)
      net.fix(net.add_node(point({sheet_side * (k % 2 - 0.5), sheet_side * (k / 2 - 0.5), -thickness})));
    net.add_face({first, first + 1, first + 3});
    net.add_face({first, first + 3, first + 2});
    net.end_body();
    net.set_extent(1, thickness, 0.0);
    BodyContact contact;
    for (NodeIndex k = 0; k < first; ++k) contact.first.push_back(k);
    for (NodeIndex k = first; k < first + 4; ++k) contact.second.push_back(k);
    contact.friction = friction;
    contact.restitution = restitution;
    net.add_contact(contact);
  };
}
double above_sheet(const Vector3& x, double) { return std::abs(x.x()) < 0.4 * sheet_side ? x.z() : 1.0; }

std::vector<Constraint> constraints() {
  const auto above = [](const Vector3& x, double) { return x.z(); };
  const auto free = [](const Vector3&, double) { return 1.0; };
  const Friction held{Friction::Kind::held}, none{Friction::Kind::none}, coulomb{Friction::Kind::coulomb, 0.3};
  const auto rods = [](Network& net) {
    net.add_rigid(0, 1);
    net.add_rigid(1, 3);
    net.add_rigid(4, 5);
  };
  const auto both = [](const std::function<void(Network&)>& a, const std::function<void(Network&)>& b) {
    return [=](Network& net) {
      a(net);
      b(net);
    };
  };
  const auto move = [](Network& net) {
    Move moved;
    moved.nodes = {0};
    moved.motion = swing();
    net.add_move(moved);
  };
  const auto instrument = [](bool box) {
    return [=](Network& net) {
      Instrument each;
      each.name = "tool";
      each.first = each.second = Vector3(0.5, 0.5, -0.5);
      each.radius = 0.5;
      each.friction = {Friction::Kind::coulomb, 0.3};
      if (box) each.box = BoxShape{Vector3(3, 3, 1)};
      net.add_instrument(each);
    };
  };
  return {{"none", [](Network&) {}, free},
          {"fixed node", [](Network& net) { net.fix(0); }, free},
          {"moved node", move, free, false},
          {"rigid connections", rods, free},
          {"rigid connections at a moved node", both(rods, move), free, false},
          {"plane, `held`", floor_of(held), above},
          {"plane, no friction", floor_of(none), above},
          {"plane, Coulomb friction", floor_of(coulomb), above},
          {"plane with restitution", floor_of(none, 0.5), above},
          {"plane that moves", floor_of(coulomb, 0.0, swing()),
           [](const Vector3& x, double time) { return x.z() - swung(time).z(); }, false},
          {"sphere", instrument(false),
           [](const Vector3& x, double) { return (x - Vector3(0.5, 0.5, -0.5)).norm() - 0.5; }},
          {"box", instrument(true), above},
          {"rigid connections on a plane, `held`", both(rods, floor_of(held)), above},
          {"rigid connections on a plane, Coulomb friction", both(rods, floor_of(coulomb)), above},
          {"rigid connections on a plane with restitution", both(rods, floor_of(none, 0.5)), above},
          {"another body, `held`", sheet_of(held), above_sheet},
          {"another body, no friction", sheet_of(none), above_sheet},
          {"another body, Coulomb friction", sheet_of(coulomb), above_sheet},
          {"another body with restitution", sheet_of(none, 0.5), above_sheet},
          {"rigid connections on another body, Coulomb friction", both(rods, sheet_of(coulomb)), above_sheet}};
}

std::vector<Method> methods() {
  std::vector<Method> all;
  const std::pair<const char*, double> rules[] = {
      {"synchronous", synchronous}, {"wavefront", wavefront}, {"block", block},
      {"coloured", coloured},       {"newton", newton},       {"automatic", automatic}};
  for (const auto& [name, rule] : rules) all.push_back({name, recurrent(rule, 1e-8)});
  all.push_back({"`cvode`, `bdf`", cvode(1e-6)});
  all.push_back({"`cvode`, `adams`", cvode(1e-6, {{"method", 1}})});
  all.push_back({"`verlet`", {"verlet", {}}});
  all.push_back({"`generalized_alpha`", {"generalized_alpha", {}}});
  return all;
}

Network body(const Law& law, const Constraint& constraint) {
  Network net;
  Lattice lattice;
  lattice.nodes = {2, 2, 2};
  lattice.diagonals = Diagonals::all;
  lattice.origin = {0, 0, 0.01};
  Node node;
  node.velocity = {0.3, 0.0, -1.0};
  node.neuron = net.add_neuron(law.neuron);
  net.add_lattice("body", lattice, node, net.add_material(law.springs));
  law.add(net);
  net.set_gravity({0, 0, -9.81});
  constraint.add(net);
  return net;
}

// The error of the present state; empty if there is none.
std::string wrong(const Network& net, const Constraint& constraint, const Simulation& s) {
  if (!s.positions().allFinite() || !s.velocities().allFinite()) return "a number is not finite";
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    // The reference keeps the gap to its tolerance; a node that separates from a moving surface may be behind it for
    // some steps, by up to h^2 times its acceleration, 20 m/s^2.
    const double behind = constraint.rests ? 1e-6 : 20.0 * time_step * time_step;
    if (const double gap = constraint.gap(s.position(k), s.time()); gap < -behind)
      return fmt::format("node {} is {:.3g} m behind the surface at {:g} s", k, -gap, s.time());
    if (net.nodes()[k].fixed && net.moves().empty() && s.position(k) != net.nodes()[k].position)
      return fmt::format("fixed node {} moved", k);
  }
  for (const Move& move : net.moves())
    for (const NodeIndex k : move.nodes)
      if ((s.position(k) - net.nodes()[k].position - swung(s.time())).norm() > 1e-9)
        return fmt::format("node {} is not where it is moved to", k);
  for (const Rigid& rigid : net.rigids())
    if (std::abs((s.position(rigid.first) - s.position(rigid.second)).norm() / rigid.length - 1.0) > 1e-7)
      return "a rigid connection has another length";
  return {};
}

struct Outcome {
  std::string refusal;  // empty: it works
  std::string wrong;
};
Outcome run(const Law& law, const Constraint& constraint, const Method& method) {
  try {
    const Network net = body(law, constraint);
    SimulationOptions options;
    options.time_step = time_step;
    options.integrator = method.integrator;
    options.threads = 1;
    Simulation simulation(net, all_plugins(), options);
    const double before = simulation.kinetic_energy() + simulation.potential_energy();
    for (int i = 0; i < step_count; ++i) {
      simulation.step();
      if (std::string what = wrong(net, constraint, simulation); !what.empty()) return {"", what};
    }
    const double after = simulation.kinetic_energy() + simulation.potential_energy();
    // Of 40 J; verlet and the reference conserve it except for their errors, the others lose some.
    if (law.conserves && constraint.rests && after > before + 0.01)
      return {"", fmt::format("the energy rose from {:.6g} J to {:.6g} J", before, after)};
    return {};
  } catch (const Error& error) {
    return {error.what(), ""};
  }
}

// Reasons for refusals, by parts of their messages.
const std::vector<std::pair<std::vector<std::string>, std::string>>& reasons() {
  static const std::vector<std::pair<std::vector<std::string>, std::string>> known{
      {{"offers no derivatives"}, "needs the law's derivatives"},
      {{"does not handle contact of bodies"}, "does not keep bodies apart"},
      {{"rigid", "\"bdf\""}, "keeps rigid connections with `method = \"bdf\"` only"},
      {{"relative"}, "only springs, between two nodes, have a relative velocity"}};
  return known;
}
std::string reason_of(const std::string& message) {
  for (const auto& [parts, reason] : reasons())
    if (std::all_of(parts.begin(), parts.end(),
                    [&](const std::string& part) { return message.find(part) != std::string::npos; }))
      return reason;
  return {};
}

// Cells of a table, with numbers for reasons.
class Notes {
 public:
  std::size_t number(const std::string& reason) {
    const auto found = std::find(reasons_.begin(), reasons_.end(), reason);
    if (found != reasons_.end()) return static_cast<std::size_t>(found - reasons_.begin()) + 1;
    reasons_.push_back(reason);
    return reasons_.size();
  }
  [[nodiscard]] std::string text() const {
    std::string all;
    for (std::size_t i = 0; i < reasons_.size(); ++i) all += fmt::format("{}. {}\n", i + 1, reasons_[i]);
    return all;
  }

 private:
  std::vector<std::string> reasons_;
};

// refusals: reasons by rows of the other table, of which `count` are considered.
std::string cell(const std::map<std::string, std::string>& refusals, std::size_t count, Notes& notes) {
  if (refusals.empty()) return "yes";
  std::set<std::size_t> numbers;
  std::vector<std::string> names;
  for (const auto& [name, reason] : refusals) {
    numbers.insert(notes.number(reason));
    names.push_back(name);
  }
  const std::string note = fmt::format("({})", fmt::join(numbers, ", "));
  return refusals.size() == count ? "no " + note : fmt::format("not with {} {}", fmt::join(names, ", "), note);
}

std::string tables(bool& good) {
  const std::vector<Law> law = laws();
  const std::vector<Constraint> constraint = constraints();
  const std::vector<Method> method = methods();
  // [law][constraint][method] reason, empty: it works
  std::vector<std::vector<std::vector<std::string>>> refused(
      law.size(), std::vector(constraint.size(), std::vector<std::string>(method.size())));
  for (std::size_t l = 0; l < law.size(); ++l) {
    for (std::size_t c = 0; c < constraint.size(); ++c) {
      for (std::size_t w = 0; w < method.size(); ++w) {
        const Outcome outcome = run(law[l], constraint[c], method[w]);
        std::string& reason = refused[l][c][w];
        if (!outcome.refusal.empty()) reason = reason_of(outcome.refusal);
        const bool unknown = !outcome.refusal.empty() && reason.empty();
        if (outcome.wrong.empty() && !unknown) continue;
        good = false;
        fmt::print("{}; {}; {}: {}\n", law[l].name, constraint[c].name, method[w].name,
                   unknown ? "refused for an unknown reason: " + outcome.refusal : outcome.wrong);
      }
    }
  }
  std::string header = "|", line = "|---|";
  for (const Method& each : method) {
    header += " | " + each.name;
    line += "---|";
  }
  header += " |\n" + line + "\n";
  Notes notes;
  std::string by_law = "| law" + header.substr(1), by_constraint = "| constraint" + header.substr(1);
  // Refusals without a constraint belong to the law, refusals with linear springs to the constraint.
  for (std::size_t l = 0; l < law.size(); ++l) {
    by_law += "| " + law[l].name;
    for (std::size_t w = 0; w < method.size(); ++w) {
      std::map<std::string, std::string> refusals;
      std::size_t count = 0;
      for (std::size_t c = 0; c < constraint.size(); ++c) {
        if (!refused[0][c][w].empty()) continue;
        ++count;
        if (!refused[l][c][w].empty()) refusals[constraint[c].name] = refused[l][c][w];
      }
      by_law += " | " + cell(refusals, count, notes);
    }
    by_law += " |\n";
  }
  for (std::size_t c = 0; c < constraint.size(); ++c) {
    by_constraint += "| " + constraint[c].name;
    for (std::size_t w = 0; w < method.size(); ++w) {
      std::map<std::string, std::string> refusals;
      std::size_t count = 0;
      for (std::size_t l = 0; l < law.size(); ++l) {
        if (!refused[l][0][w].empty()) continue;
        ++count;
        if (!refused[l][c][w].empty()) refusals[law[l].name] = refused[l][c][w];
      }
      by_constraint += " | " + cell(refusals, count, notes);
    }
    by_constraint += " |\n";
  }
  return fmt::format(
      "# What works with what\n\n"
      "Nearly everything works with everything. The exceptions are the cells that do not say \"yes\": there the "
      "program "
      "refuses, with\nan error that gives the reason; the numbers in them refer to the reasons below.\n\n"
      "This page is written by a test, which runs a body of eight nodes with every law under every constraint in every "
      "integrator\n({} runs). \"yes\": it ran, numbers stayed finite, constraints held, and the energy did not rise. "
      "The "
      "first six columns are update\nrules of `recurrent`; `automatic`, the default, chooses one of the first five. "
      "`cvode` has two methods, `bdf` (the default) and\n`adams`. What was not tried here has tests of its own: "
      "several "
      "obstacles at once and turning ones, capsules, cuts, `theta = 0.5`,\nlocated events.\n\n"
      "## Laws\n\nEach with all constraints that the integrator of the column supports. A law that is not named is "
      "the default: springs and\nviscosity `linear`, neuron `point_mass`.\n\n{}\n"
      "## Constraints\n\nEach with all laws that the integrator of the column supports.\n\n{}\n## Reasons\n\n{}\n"
      "After a change, `build/ci/bin/test_abilities --write core/docs/abilities.md` writes this page again.\n",
      law.size() * constraint.size() * method.size(), by_law, by_constraint, notes.text());
}

std::string read(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const bool writes = argc == 3 && std::string(argv[1]) == "--write";
    if (argc != 2 && !writes) throw std::runtime_error("test_abilities [--write] PAGE");
    const std::string page = argv[argc - 1];
    bool good = true;
    const std::string now = tables(good);
    if (writes) {
      std::ofstream(page) << now;
    } else if (read(page) != now) {
      fmt::print("{} differs from these tables; if they are right: test_abilities --write {}\n\n{}", page, page, now);
      good = false;
    }
    return good ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "test_abilities: {}\n", error.what());
    return 1;
  }
}
