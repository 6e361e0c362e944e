// Units of formulas.
#include <optional>
#include <string>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/formula.hpp>

#include "facts.hpp"

using namespace springnet;

namespace {

std::string refusal(const std::string& force, std::vector<FormulaSymbol> parameters, const std::string& energy = "") {
  LawFormula law;
  law.force = force;
  law.energy = energy;
  law.parameters = std::move(parameters);
  try {
    static_cast<void>(component_of(law));
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}
void units_refused(const std::string& message, const std::string& facts) {
  INFO(message);
  CHECK(testing::has_facts(message, facts));
}

}  // namespace

TEST_CASE("units that fit are taken") {
  CHECK(refusal("stiffness*e/(1 - (e/limit)^2)", {{"stiffness", "N/m"}, {"limit", "m"}}) == "");
  CHECK(refusal("stiffness*e + damping*rate", {{"stiffness", "N/m"}, {"damping", "N s/m"}}) == "");
  CHECK(refusal("modulus*area_0*strain^1.5", {{"modulus", "Pa"}, {"area_0", "m^2"}}) == "");
  CHECK(refusal("sqrt(a)*e*cbrt(b)", {{"a", "N^2/m^2"}, {"b", "1"}}) == "");
  CHECK(refusal("f*exp(-e/l)*if(e > 0, 1, 0)", {{"f", "N"}, {"l", "m"}}, "f*l*(1 - exp(-e/l))") == "");
  CHECK(refusal("mass*e*frequency^2", {{"mass", "kg"}, {"frequency", "1/s"}}) == "");
  CHECK(refusal("a*max(e, 0) + b*min(rate, 0)", {{"a", "N/m"}, {"b"}}) == "");  // b: not said
  CHECK(refusal("a*(e - 0.1)", {{"a"}}) == "");                                 // nothing is said
}

TEST_CASE("all units of the SI are known, and a formula of elements may have theirs") {
  CHECK(refusal("k*temperature*e/l^2", {{"k", "J/K"}, {"temperature", "K"}, {"l", "m"}}) == "");
  CHECK(refusal("gas*temperature*amount/length", {{"gas", "J/(mol K)"}, {"temperature", "K"}, {"amount", "mol"}}) ==
        "");
  CHECK(refusal("c*u*u/length", {{"c", "F"}, {"u", "V"}}) == "");
  CHECK(refusal("q*q/(eps*e^2)", {{"q", "C"}, {"eps", "F/m"}}) == "");
  units_refused(refusal("k*temperature*e", {{"k", "N/m"}, {"temperature", "K"}}), "is in kg m s^-2 K | must be in N");
  CHECK(refusal("k*e", {{"k", "N m"}}) == "");
  CHECK(refusal("k*e", {{"k", "Pa/m^3"}}) == "");
  CHECK(refusal("k*(angle - 2)", {{"k", "N m"}}) == "");
  units_refused(refusal("k*angle", {{"k", "N/m"}}), "must be in J");
  units_refused(refusal("k*length", {{"k", "N m"}}), "must be in N");
}

TEST_CASE("the units of a law that goes with every invariant are checked for its use") {
  LawFormula law;
  law.force = "k*e";
  const auto wrong = [&](const std::string& unit, std::optional<Invariant> elements) -> std::string {
    law.parameters = {{"k", unit}};
    try {
      check_units(law, elements);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  CHECK(wrong("N/m", std::nullopt) == "");
  CHECK(wrong("N m", Invariant::angle) == "");
  CHECK(wrong("J", Invariant::dihedral) == "");
  CHECK(wrong("N/m^3", Invariant::area) == "");
  CHECK(wrong("Pa/m^3", Invariant::volume) == "");
  CHECK(wrong("Pa/m^3", Invariant::enclosed_volume) == "");
  CHECK(wrong("", Invariant::angle) == "");
  units_refused(wrong("N m", std::nullopt), "must be in N");
  units_refused(wrong("N/m", Invariant::angle), "is in N/m | must be in J");
  units_refused(wrong("N m", Invariant::area), "must be in N/m");
  units_refused(wrong("N/m", Invariant::volume), "must be in Pa");
}

TEST_CASE("units that do not fit are told with their place") {
  units_refused(refusal("stiffness*e/(1 - (e/limit)^2)", {{"stiffness", "N/m"}, {"limit", "1"}}),
                "column 27 | in m^2 | goes with what is in 1");
  units_refused(refusal("stiffness*e", {{"stiffness", "N"}}), "force | is in J | must be in N");
  units_refused(refusal("stiffness*(e - 0.1)", {{"stiffness", "N/m"}}), "column 16 | in 1 | in m");
  units_refused(refusal("force*exp(e)", {{"force", "N"}}), "column 11 | exp takes a number without unit | in m");
  units_refused(refusal("force*e^power", {{"force", "N"}, {"power", "1"}}), "column 8 | a power that is not written");
  units_refused(refusal("force*2^limit", {{"force", "N"}, {"limit", "m"}}), "column 9 | exponent is in m");
  units_refused(refusal("stiffness*e", {{"stiffness", "N/m"}}, "stiffness*e"), "energy | is in N | must be in J");
  units_refused(refusal("stiffness*e", {{"stiffness", "lb/ft"}}), "'lb/ft' of 'stiffness' is not known");
}
