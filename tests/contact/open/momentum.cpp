// What changes momentum: gravity, reactions, and the impulses of touching. Nothing else does.

#include <doctest/doctest.h>

#include <algorithm>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct Example {
  std::string name;
  Network net;
  double until;     // s
  bool is_located;  // the reaction jumps at events only
};

std::vector<Example> examples() {
  const Friction rough{Friction::Kind::coulomb, 0.2};
  return {{"sphere", on_sphere(), 3.0, true},
          {"landing on a sphere", thrown_on_sphere(frictionless), 1.2, true},
          {"landing on a rough sphere", thrown_on_sphere(rough), 1.2, true},
          {"landing on a capsule", thrown_on_capsule(frictionless), 1.2, false},  // its curvature jumps
          {"landing on a rough capsule", thrown_on_capsule(rough), 1.2, false},
          {"pair", thrown_pair(), 0.6, true},
          {"box", thrown_box(), 0.6, true},
          {"shaken plane", on_shaken_plane(), 0.9, true},
          {"shaken oscillator", shaken_oscillator(), 3.0, true}};
}

// What gravity does to fixed nodes their reactions undo.
double total_mass(const Network& net) {
  double mass = 0.0;
  for (const Node& node : net.nodes()) mass += node.mass;
  return mass;
}

}  // namespace

TEST_CASE("in the reference momentum is that of gravity, the integral of reactions, and impulses") {
  // Gauss and Legendre's rule of five points between events. What is left is the reference's own error of a step.
  constexpr double x[] = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr double w[] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                          0.2369268850561891};
  for (const Example& example : examples()) {
    if (!example.is_located) continue;
    INFO(example.name);
    const Network& net = example.net;
    const LawUse integrator = cvode(1e-13);
    Simulation first = simulate(net, integrator, example.until);
    first.advance_to(example.until);
    std::vector<double> ends;
    for (int i = 1; i <= 40; ++i) ends.push_back(example.until * i / 40);
    for (const Event& event : first.events())
      if (event.time > 0.0 && event.time < example.until) ends.push_back(event.time);
    std::sort(ends.begin(), ends.end());
    Simulation s = simulate(net, integrator, example.until);
    const Vector3 start = s.momentum();
    Vector3 given = Vector3::Zero();
    double time = 0.0, worst = 0.0, scale = 1.0;
    for (const double end : ends) {
      for (std::size_t i = 0; i < 5 && end > time; ++i) {
        s.advance_to(time + 0.5 * (end - time) * (1.0 + x[i]));
        for (NodeIndex k = 0; k < s.node_count(); ++k) given += 0.5 * (end - time) * w[i] * s.reaction(k);
      }
      if (end > time) s.advance_to(end);
      time = end;
      Vector3 missing = s.momentum() - start - time * total_mass(net) * net.gravity() - given;
      for (NodeIndex k = 0; k < s.node_count(); ++k) {
        missing -= s.contact_impulse(k);
        scale = std::max(scale, s.contact_impulse(k).norm());
      }
      worst = std::max(worst, missing.norm());
      scale = std::max(scale, s.momentum().norm());
    }
    CHECK(worst <= 1.5e-10 * scale);
  }
}

TEST_CASE("in a step of the network momentum is that of gravity, reactions over the step, and impulses") {
  constexpr double threshold = 1e-9, h = 0.002;
  for (const Example& example : examples()) {
    const Network& net = example.net;
    for (const Way& way : stepping_ways(threshold)) {
      if (way.name == "verlet") continue;  // its reactions are those of a time, not of a step
      INFO(example.name << ": " << way.name);
      const double theta = way.order == 1.0 ? 1.0 : 0.5;
      Simulation s = simulate(net, way.integrator, h);
      double worst = 0.0, at = 0.0;
      while (s.time() < example.until - 0.5 * h) {
        const Vector3 before = s.momentum();
        Vector3 given = h * total_mass(net) * net.gravity();
        for (NodeIndex k = 0; k < s.node_count(); ++k)
          given += h * (1.0 - theta) * s.reaction(k) - s.contact_impulse(k);
        s.step();
        for (NodeIndex k = 0; k < s.node_count(); ++k) given += h * theta * s.reaction(k) + s.contact_impulse(k);
        const double missing = (s.momentum() - before - given).norm();
        if (missing > worst) at = s.time();
        worst = std::max(worst, missing);
      }
      CAPTURE(at);
      CHECK(worst <= h * threshold * static_cast<double>(s.node_count()) + 1e-13);
    }
  }
}
