// Laws with one internal state z by the formulas in their plugins' heads, and the steps of z, which these laws allow in
// closed form. x: elongation, or the invariant's value less its reference.
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <springnet/network.hpp>

namespace springnet::testing {

inline bool has_memory(const LawUse& law) {
  return law.id == "maxwell" || law.id == "standard_linear_solid" || law.id == "plastic" || law.id == "damaging";
}

// z at the start, where x is the elongation: the dashpot may begin with all of it.
inline double plain_start(const LawUse& law, double x) {
  const auto relaxed = law.parameters.find("starts_relaxed");
  return relaxed != law.parameters.end() && relaxed->second != 0.0 ? x : 0.0;
}

inline double plain_tension_with_memory(const LawUse& law, double x, double z) {
  const auto p = [&](const char* name) { return law.parameters.at(name); };
  if (law.id == "maxwell" || law.id == "plastic") return p("stiffness") * (x - z);
  if (law.id == "standard_linear_solid") return p("stiffness") * x + p("fast_stiffness") * (x - z);
  if (law.id == "damaging") return (1.0 - z) * p("stiffness") * x;
  throw std::logic_error("no formula for " + law.id);
}

// The damage that a strain aims at: none below the threshold, then such that the tension falls in a straight line.
inline double plain_damage(const LawUse& law, double strain) {
  const double from = law.parameters.at("threshold_strain"), until = from + law.parameters.at("softening_strain");
  if (strain <= from) return 0.0;
  return std::min(until / (until - from) * (1.0 - from / strain), 1.0);
}

// z'
inline double plain_rate(const LawUse& law, double x, double reference, double z) {
  const auto p = [&](const char* name) { return law.parameters.at(name); };
  const double tau = p("relaxation_time");
  if (law.id == "damaging") return std::max(plain_damage(law, x / reference) - z, 0.0) / tau;
  if (law.id != "plastic") return (x - z) / tau;
  const double drive = p("stiffness") * (x - z) - p("hardening") * z;
  return std::copysign(std::max(std::abs(drive) - p("yield_tension"), 0.0), drive) / (p("stiffness") * tau);
}

// Z = base + w z'(x, Z). Every rate falls with z and is linear on either side of a kink, which Z does not cross.
inline double plain_stage(const LawUse& law, double w, double x, double reference, double base) {
  const auto p = [&](const char* name) { return law.parameters.at(name); };
  const double rate = plain_rate(law, x, reference, base);
  double slope = -1.0 / p("relaxation_time");  // of the rate, where it is not 0
  if (law.id == "plastic") slope *= 1.0 + p("hardening") / p("stiffness");
  return rate == 0.0 ? base : base + w * rate / (1.0 - w * slope);
}

// Backward Euler. Of second order, with x in a straight line from that at the start: the two stages of Alexander's
// method, or, where the rate has kinks, backward Euler in one step and in two halves, extrapolated.
inline double plain_next(const LawUse& law, int order, double h, double x0, double x1, double reference, double z) {
  if (order == 1) return plain_stage(law, h, x1, reference, z);
  if (law.id == "plastic" || law.id == "damaging") {
    const double half = plain_stage(law, 0.5 * h, 0.5 * (x0 + x1), reference, z);
    const double next = 2.0 * plain_stage(law, 0.5 * h, x1, reference, half) - plain_stage(law, h, x1, reference, z);
    return law.id == "damaging" ? std::clamp(next, 0.0, 1.0) : next;
  }
  const double g = 1.0 - std::sqrt(0.5);
  const double first = plain_stage(law, g * h, x0 + g * (x1 - x0), reference, z);
  return plain_stage(law, g * h, x1, reference, z + (1.0 - g) * (first - z) / g);
}

}  // namespace springnet::testing
