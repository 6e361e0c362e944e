// Sensitivities of the reference against difference quotients of the motion itself, and those of the recurrent
// network's steps against both as the time constant goes to 0.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/sensitivities.hpp>

#include "difference_quotients.hpp"
#include "smooth_nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// Scalars, and how values of the network follow them: those that go together keep their ratios.
struct Scalars {
  std::vector<Learnable> of;
  std::vector<LearnedValues> values;
  MatrixXd changes;
  std::vector<double> sizes;
  Scalars(const Network& net, const std::vector<std::string>& texts, const std::vector<LearnedValues>& more = {}) {
    for (const std::string& each : texts) of.push_back(select_learnable(net, *plugins(), each));
    for (const LearnedValues& each : more) of.push_back({each});
    for (const Learnable& each : of) values.push_back(each.values);
    const VectorXd start = MotionDerivatives(std::make_shared<const Network>(net), plugins(),
                                             recurrent_with(1.0, newton, 0.1), 0.1, values)
                               .values_of_network();
    std::vector<VectorXd> columns;
    Eigen::Index i = 0;
    for (const Learnable& each : of) {
      const auto count =
          static_cast<Eigen::Index>((each.values.kind == Kind::initial_velocity ? 3 : 1) * each.values.members.size());
      for (Eigen::Index j = i; j < i + count; ++j) {
        if (!each.together || j == i) columns.push_back(VectorXd::Zero(start.size()));
        if (!each.together || j == i) sizes.push_back(start[j] != 0.0 ? std::abs(start[j]) : 1.0);
        columns.back()[j] = each.together && start[i] != 0.0 ? start[j] / start[i] : 1.0;
      }
      i += count;
    }
    changes.resize(start.size(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t j = 0; j < columns.size(); ++j) changes.col(static_cast<Eigen::Index>(j)) = columns[j];
  }
  // Steps that have settled to rounding.
  static SimulationOptions recurrent_with(double theta, double rule, double step) {
    SimulationOptions options;
    options.integrator = recurrent(rule, rule == newton ? 1e-12 : 1e-11, {{"theta", theta}, {"max_sweeps", 100000}});
    options.time_step = step;
    options.threads = 1;
    return options;
  }
  // Columns by the sizes of their scalars: what a change of each by its own size does, m and m/s.
  [[nodiscard]] MatrixXd sized(MatrixXd columns) const {
    for (std::size_t j = 0; j < sizes.size(); ++j) columns.col(static_cast<Eigen::Index>(j)) *= sizes[j];
    return columns;
  }
};

MatrixXd by_quotients(const Network& net, const Scalars& scalars, double until) {
  const MatrixXd all = DifferenceQuotients(net, scalars.values, scalars.changes, scalars.sizes).at(until);
  return scalars.sized(all.rightCols(all.cols() - 1));
}

SimulationOptions reference_with(double tolerance, ParameterValues more = {}) {
  SimulationOptions options;
  options.integrator = cvode(tolerance, std::move(more));
  options.time_step = 0.05;
  options.threads = 1;
  return options;
}

MatrixXd columns_of(const ReferenceSensitivities& motion) {
  MatrixXd result(2 * motion.positions().size(), static_cast<Eigen::Index>(motion.columns().size()));
  for (std::size_t j = 0; j < motion.columns().size(); ++j)
    result.col(static_cast<Eigen::Index>(j)) = stacked(motion.position_changes(j), motion.velocity_changes(j));
  return result;
}

MatrixXd by_reference(const Network& net, const Scalars& scalars, double until, const SimulationOptions& options) {
  ReferenceSensitivities motion(std::make_shared<const Network>(net), plugins(), options, scalars.of);
  for (int i = 1; i <= 4; ++i) motion.advance_to(0.25 * i * until);
  REQUIRE(motion.columns().size() == scalars.sizes.size());
  return scalars.sized(columns_of(motion));
}

// Of the steps of the recurrent network; the adjoint's gradient of a loss of the last state is that of the columns.
MatrixXd by_steps(const Network& net, const Scalars& scalars, double until, const SimulationOptions& options) {
  MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), options, until, scalars.values);
  motion.run(motion.values_of_network());
  MatrixXd columns;
  motion.tangent(scalars.changes, [&](std::size_t state, const MatrixXd& positions, const MatrixXd& velocities) {
    if (state != motion.step_count()) return;
    columns.resize(2 * positions.rows(), positions.cols());
    columns << positions, velocities;
  });
  Dice dice(17);
  VectorXd weights(columns.rows());
  for (double& each : weights) each = dice.between(-1.0, 1.0);
  const Eigen::Index half = weights.size() / 2;
  const VectorXd gradient = motion.adjoint([&](std::size_t state, MotionDerivatives::StateChange& add) {
    if (state != motion.step_count()) return;
    add.positions += weights.head(half).reshaped(3, half / 3);
    add.velocities += weights.tail(half).reshaped(3, half / 3);
  });
  const VectorXd own = scalars.changes.transpose() * gradient, forwards = columns.transpose() * weights;
  CHECK((own - forwards).norm() <= 1e-8 * forwards.norm());  // systems are solved to 1e-10
  return scalars.sized(columns);
}

// The error is c h^p + O(h^(p + 1)): halving h divides it by 2^p, but for about h over the shortest time of the motion,
// of which backward Euler needs more steps for that.
void check_order(const Network& net, const Scalars& scalars, double until, double step, double theta, double rule,
                 const MatrixXd& exact) {
  CAPTURE(theta);
  CAPTURE(rule);
  double before = 0.0;
  const double first = theta == 0.5 ? step : 0.25 * step;
  for (const double h : {first, 0.5 * first}) {
    const double error =
        (by_steps(net, scalars, until, Scalars::recurrent_with(theta, rule, h)) - exact).norm() / exact.norm();
    if (before > 0.0) {
      const double order = std::log2(before / error);
      CAPTURE(error);
      CAPTURE(order);
      CHECK(std::abs(order - (theta == 0.5 ? 2.0 : 1.0)) < 0.12);
      CHECK(error > 1e-5);  // ten times what both references agree to, at least
      CHECK(error < (theta == 0.5 ? 0.01 : 0.05));
    }
    before = error;
  }
}

// Difference quotients, with which the reference agrees: they are good to about 1e-8 (their increments are 3e-5) in
// each of some hundred steps, the reference to 1e-11.
MatrixXd exact_columns(const Network& net, const Scalars& scalars, double until) {
  MatrixXd exact = by_quotients(net, scalars, until);
  const MatrixXd reference = by_reference(net, scalars, until, reference_with(1e-11));
  for (Eigen::Index j = 0; j < exact.cols(); ++j) {
    CAPTURE(j);
    CHECK(exact.col(j).norm() > 1e-6);
    CHECK((reference.col(j) - exact.col(j)).norm() <= 1e-6 * exact.norm());
  }
  return exact;
}

struct LawCase {
  std::string law;
  bool is_viscosity;
  Network net;
};

std::vector<LawCase> law_cases() {
  using Net = ExpandingNet;
  const LawUse plain{"linear", {{"stiffness", 20.0}}};
  const auto viscous = [](double damping) { return LawUse{"linear", {{"damping", damping}}}; };
  std::vector<LawCase> cases;
  const auto of_springs = [&](const Material& material, bool is_viscosity) {
    Net own(cases.size() + 1);
    own.join(material);
    cases.push_back({(is_viscosity ? material.viscosity : material.spring)->id, is_viscosity, own.net});
  };
  for (const LawUse& law : {plain, LawUse{"nonlinear", {{"stiffness", 20.0}, {"cubic", 30.0}, {"quintic", -10.0}}},
                            LawUse{"exponential", {{"stiffness", 10.0}, {"exponent", 3.0}}},
                            LawUse{"rupturing", {{"stiffness", 20.0}, {"strength", 1e3}}},
                            LawUse{"table", {}, {{"elongations", {-1.0, 0.0, 1.0}}, {"forces", {-15.0, 0.0, 30.0}}}},
                            LawUse{"muscle", {{"strength", 1.0}, {"maximum_speed", 4.0}}}})
    of_springs({law, viscous(0.3)}, false);
  Input activation;
  activation.input = "activation";
  for (SpringIndex s = 0; s < cases.back().net.springs().size(); ++s) activation.springs.push_back(s);
  activation.signal.mean = 0.6;
  cases.back().net.add_input(activation);
  for (const LawUse& law :
       {viscous(0.5), LawUse{"power", {{"damping", 0.5}, {"exponent", 1.7}}}, LawUse{"relative", {{"damping", 0.3}}}})
    of_springs({LawUse{"linear", {{"stiffness", 5.0}}}, law}, true);
  const auto over_several = [&](Invariant shape, const std::vector<std::vector<NodeIndex>>& all,
                                const Material& material, const Vector3& direction = Vector3::Zero()) {
    Net own(cases.size() + 1);
    own.join({LawUse{"linear", {{"stiffness", 5.0}}}, viscous(0.2)});
    own.add_at_rest(shape, all, material, direction);
    const bool is_viscosity = material.viscosity.has_value();
    cases.push_back({(is_viscosity ? material.viscosity : material.spring)->id, is_viscosity, own.net});
  };
  const LawUse membrane{"membrane", {{"youngs_modulus", 60.0}, {"poisson_ratio", 0.3}, {"thickness", 0.2}}};
  const LawUse solid{"solid", {{"youngs_modulus", 40.0}, {"poisson_ratio", 0.25}}};
  over_several(Invariant::triangle, Net::triangles(), {membrane, {}});
  over_several(Invariant::hinge, Net::hinges(),
               {LawUse{"shell", {{"youngs_modulus", 100.0}, {"poisson_ratio", 0.3}, {"thickness", 0.4}}}, {}});
  over_several(Invariant::tetrahedron, Net::tetrahedra(), {solid, {}});
  over_several(Invariant::tetrahedron, Net::tetrahedra(),
               {LawUse{"fibre_solid",
                       {{"youngs_modulus", 40.0},
                        {"poisson_ratio", 0.25},
                        {"fibre_modulus", 30.0},
                        {"fibre_stiffening", 0.5},
                        {"fibres_push", 1.0}}},
                {}},
               Vector3(1, 2, -1).normalized());
  over_several(Invariant::triangle, Net::triangles(),
               {membrane, LawUse{"viscous_membrane", {{"shear_viscosity", 1.0}, {"area_viscosity", 0.7}}}});
  over_several(Invariant::tetrahedron, Net::tetrahedra(),
               {solid, LawUse{"viscous_solid", {{"shear_viscosity", 2.0}, {"bulk_viscosity", 1.5}}}});
  return cases;
}

// What its law declares learnable, one for all; a rest length, a mass and a start velocity.
Scalars scalars_of(const LawCase& one) {
  const auto component = plugins()->require(
      one.is_viscosity ? ComponentKind::viscosity_function : ComponentKind::spring_function, one.law);
  const bool of_elements = !one.net.elements().empty();
  std::vector<std::string> texts;
  for (std::uint32_t k = 0; k < component->description->parameter_count; ++k) {
    const springnet_parameter& each = *component->description->parameters[k];
    if ((each.flags & SPRINGNET_LEARNABLE) == 0 || std::string(each.name) == "strength") continue;
    texts.push_back(std::string(of_elements ? "element." : "") + (one.is_viscosity ? "viscosity." : "spring.") +
                    each.name + ":together");
  }
  return {
      one.net,
      texts,
      {{Kind::rest_length, false, "", {1}}, {Kind::mass, false, "", {3}}, {Kind::initial_velocity, false, "", {6}}}};
}

}  // namespace

TEST_CASE("sensitivities of an oscillator and of a free flight are those of the closed forms, with every solver") {
  constexpr double k = 9.0, m = 1.3, b = 0.4, x0 = 0.25, t = 2.0;
  const Network net = oscillator(damped(k, b), m, x0);
  // x = 1 + x0 exp(-d t) (cos(w t) + d/w sin(w t)), w^2 = k/m - d^2, d = b/(2 m); sixth-order quotients of it.
  const auto x = [](double stiffness, double damping, double mass, double length) {
    const double d = 0.5 * damping / mass, w = std::sqrt(stiffness / mass - d * d), from = 1.0 + x0 - length;
    return length + from * std::exp(-d * t) * (std::cos(w * t) + d / w * std::sin(w * t));
  };
  const auto by = [](const auto& f) {
    constexpr double h = 1e-3;
    return (45.0 * (f(h) - f(-h)) - 9.0 * (f(2 * h) - f(-2 * h)) + f(3 * h) - f(-3 * h)) / (60.0 * h);
  };
  const double exact[] = {
      by([&](double h) { return x(k + h, b, m, 1.0); }), by([&](double h) { return x(k, b + h, m, 1.0); }),
      by([&](double h) { return x(k, b, m + h, 1.0); }), by([&](double h) { return x(k, b, m, 1.0 + h); })};
  const std::vector<Learnable> of = Scalars(net, {"spring.stiffness", "viscosity.damping", "mass", "rest_length"}).of;
  const struct { double method, solver; } settings[] = {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 0}, {1, 1}, {1, 3}};
  for (const auto& each : settings) {
    CAPTURE(each.method);
    CAPTURE(each.solver);
    double before = 0.0;
    for (const double tolerance : {1e-6, 1e-9}) {
      ReferenceSensitivities motion(
          std::make_shared<const Network>(net), plugins(),
          reference_with(tolerance, {{"method", each.method}, {"linear_solver", each.solver}}), of);
      CHECK(motion.columns()[2].name == "mass");
      CHECK(motion.columns()[2].member == 1);
      CHECK(motion.columns()[2].value == m);
      motion.advance_to(0.7);
      motion.advance_to(t);
      double error = std::abs(motion.positions()(0, 1) - x(k, b, m, 1.0));
      for (std::size_t j = 0; j < 4; ++j)
        error = std::max(error, std::abs(motion.position_changes(j)(0, 1) - exact[j]) * motion.columns()[j].value);
      CHECK(error < 500.0 * tolerance);  // that many steps at the most, each with an error of the tolerance
      if (before > 0.0) CHECK(error < 0.01 * before);
      before = error;
    }
  }
  Network flight;
  flight.add_node(point({0, 0, 0}, 2.0, {1, 2, 3}));
  flight.add_load({{0}, {0, 0, 4.0}, 0.5, 1.0});
  ReferenceSensitivities thrown(std::make_shared<const Network>(flight), plugins(), reference_with(1e-10),
                                Scalars(flight, {"mass", "velocity"}).of);
  thrown.advance_to(1.5);
  // The load is there for 0.5 s, 0.75 s on the average before the end.
  CHECK(thrown.positions()(2, 0) == doctest::Approx(3.0 * 1.5 + 2.0 * 0.5 * 0.75).epsilon(1e-9));
  CHECK(thrown.position_changes(0)(2, 0) == doctest::Approx(-0.5 * 0.75).epsilon(1e-9));
  CHECK(thrown.velocity_changes(0)(2, 0) == doctest::Approx(-0.5).epsilon(1e-9));
  CHECK(thrown.columns()[2].name == "velocity.y");
  CHECK(thrown.position_changes(2).isApprox(Vector3(0, 1.5, 0), 1e-9));
}

TEST_CASE("the motion is that of a simulation, with the same bits for every number of threads") {
  const Network net = smooth_net(4);
  const Scalars scalars(net, {"spring.stiffness", "mass:together"});
  SimulationOptions options = reference_with(1e-9);
  ReferenceSensitivities one(std::make_shared<const Network>(net), plugins(), options, scalars.of);
  options.threads = 3;
  ReferenceSensitivities three(std::make_shared<const Network>(net), plugins(), options, scalars.of);
  Simulation simulation(net, plugins(), options);
  for (const double time : {0.05, 0.31}) {
    one.advance_to(time);
    three.advance_to(time);
    simulation.advance_to(time);
    CHECK(one.time() == time);
    CHECK(one.positions() == three.positions());
    CHECK(columns_of(one) == columns_of(three));
    for (NodeIndex k = 0; k < net.nodes().size(); ++k)
      CHECK((one.positions().col(k) - simulation.position(k)).norm() < 1e-6);  // 1e-9 in each of some hundred steps
  }
}

TEST_CASE("what the reference does not differentiate is refused with what it is") {
  const auto refused = [](const Network& net, const std::string& what, const std::string& message,
                          std::optional<LawUse> integrator = std::nullopt, double until = 2.0) {
    std::string said;
    try {
      SimulationOptions options = reference_with(1e-8);
      if (integrator) options.integrator = *integrator;
      ReferenceSensitivities motion(std::make_shared<const Network>(net), plugins(), options,
                                    {select_learnable(net, *plugins(), what)});
      for (int i = 1; i <= 20; ++i) motion.advance_to(0.05 * i * until);
    } catch (const Error& error) {
      said = error.what();
    }
    CAPTURE(said);
    CHECK(said.find(message) != std::string::npos);
  };
  const Network net = oscillator(damped(9.0, 0.3), 1.0, 0.25);
  refused(net, "mass", "integrator 'recurrent' has none; use cvode", LawUse{"recurrent", {}});
  refused(net, "mass", "must be", cvode(-1.0));
  refused(net, "velocity:together", "each by itself");
  refused(net, "mass:field=0", "a field has no column");
  refused(net, "mass", "is not later than", std::nullopt, 0.0);
  refused(cube(300.0, 2.0, 2.0, 0.1), "mass:together", "with contact or ruptures, which there is at 0.316");
  refused(cube(300.0, 2.0, 2.0, 0.0), "mass:together", "contact at 0 s is not differentiated");
  refused(oscillator({LawUse{"rupturing", {{"stiffness", 9.0}, {"strength", 1.0}, {"breaks_in_compression", 1.0}}}, {}},
                     1.0, 0.1, 2.0),
          "mass", "with contact or ruptures");
  refused(oscillator({LawUse{"maxwell", {{"stiffness", 9.0}, {"relaxation_time", 1.0}}}, {}}, 1.0, 0.1), "mass",
          "internal states");
  Network rigid = chain(3, Vector3::Zero(), Vector3::UnitX(), damped(9.0, 0.3));
  rigid.add_rigid(0, 1);
  refused(rigid, "mass", "rigid connections");
  Network cut = net;
  cut.add_cut({0.5, {0}, {}});
  refused(cut, "mass", "a net with cuts");
  ReferenceSensitivities motion(std::make_shared<const Network>(net), plugins(), reference_with(1e-8),
                                {select_learnable(net, *plugins(), "mass")});
  CHECK_THROWS_WITH_AS(static_cast<void>(motion.position_changes(1)), doctest::Contains("column 1 does not exist"),
                       Error);
}

TEST_CASE("the table has a line for each time, column and node") {
  const Network net = chain(3, Vector3::Zero(), Vector3(1, 0.1, 0), damped(9.0, 0.3));
  ReferenceSensitivities motion(std::make_shared<const Network>(net), plugins(), reference_with(1e-8),
                                Scalars(net, {"rest_length:together", "mass"}).of);
  const TemporaryFolder folder;
  const auto path = folder.path() / "sensitivity.csv";
  SensitivityTable table(path, {0, 2});
  table.record(motion);
  motion.advance_to(0.5);
  table.record(motion);
  table.close();
  std::ifstream file(path);
  std::string line;
  REQUIRE(std::getline(file, line));
  CHECK(line == "time,parameter,member,node,dx,dy,dz,dvx,dvy,dvz");
  std::vector<std::string> lines;
  while (std::getline(file, line)) lines.push_back(line);
  REQUIRE(lines.size() == 16);
  CHECK(lines[0] == "0,rest_length,,0,0,0,0,0,0,0");
  CHECK(lines[8].starts_with("0.5,rest_length,,0,"));
  CHECK(lines[15].starts_with("0.5,mass,2,2,"));
  double dx = 0.0;
  REQUIRE(std::sscanf(lines[9].c_str(), "0.5,rest_length,,2,%lf", &dx) == 1);
  CHECK(dx == motion.position_changes(0)(0, 2));
  CHECK(dx > 0.0);
}

TEST_CASE("sensitivities of steps go to those of the reference with the order of the method, for every shipped law") {
  std::set<std::string> done;
  for (const LawCase& one : law_cases()) {
    CAPTURE(one.law);
    CAPTURE(one.is_viscosity);
    done.insert((one.is_viscosity ? "viscosity " : "spring ") + one.law);
    const Scalars scalars = scalars_of(one);
    const MatrixXd exact = exact_columns(one.net, scalars, 0.2);
    for (const double theta : {1.0, 0.5}) check_order(one.net, scalars, 0.2, 0.02, theta, newton, exact);
  }
  // Those with memory are not differentiated yet.
  for (const auto& component : plugins()->components()) {
    const bool is_spring = component->kind() == ComponentKind::spring_function;
    if (!is_spring && component->kind() != ComponentKind::viscosity_function) continue;
    CAPTURE(component->id());
    CHECK((component->law().state_count > 0 ||
           done.count((is_spring ? "spring " : "viscosity ") + std::string(component->id())) == 1));
  }
}

TEST_CASE("sensitivities of steps go to those of the reference, for every invariant of elements") {
  using Net = ExpandingNet;
  const struct {
    Invariant invariant;
    std::vector<std::vector<NodeIndex>> nodes;
  } cases[] = {{Invariant::angle, Net::chains()},
               {Invariant::dihedral, Net::hinges()},
               {Invariant::area, Net::triangles()},
               {Invariant::volume, Net::tetrahedra()},
               {Invariant::enclosed_volume, Net::surface()}};
  for (const auto& one : cases) {
    CAPTURE(name_of(one.invariant));
    ExpandingNet own(31);
    own.join({LawUse{"linear", {{"stiffness", 5.0}}}, LawUse{"linear", {{"damping", 0.2}}}});
    own.add(one.invariant, one.nodes,
            {LawUse{"nonlinear", {{"stiffness", 10.0}, {"cubic", 5.0}}}, LawUse{"linear", {{"damping", 0.3}}}});
    const Scalars scalars(own.net, {"element.spring.stiffness", "element.spring.cubic:together",
                                    "element.viscosity.damping:together", "reference", "mass:together"});
    const MatrixXd exact = exact_columns(own.net, scalars, 0.2);
    for (const double theta : {1.0, 0.5}) check_order(own.net, scalars, 0.2, 0.02, theta, newton, exact);
  }
}

TEST_CASE("sensitivities of steps go to those of the reference on random nets, with every update rule") {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    CAPTURE(seed);
    const Network net = smooth_net(seed);
    const auto springs = static_cast<SpringIndex>(net.springs().size());
    const Scalars scalars(
        net, {"spring.exponent:together", "viscosity.damping:together", "rest_length:together", "neuron.drag:together"},
        {{Kind::spring_parameter, false, "stiffness", {0, springs / 2, springs - 1}},
         {Kind::mass, false, "", {3, 4}},
         {Kind::initial_velocity, false, "", {5}}});
    const MatrixXd exact = exact_columns(net, scalars, 0.4);
    for (const double theta : {1.0, 0.5})
      for (const double rule : {synchronous, wavefront, block, coloured, newton})
        check_order(net, scalars, 0.4, 0.02, theta, rule, exact);
  }
}
