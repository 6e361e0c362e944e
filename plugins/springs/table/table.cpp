// A measured spring: the tension T(x) through points of elongation x = l - l0 and force, by a piecewise cubic that does
// not overshoot between them. Its energy is the integral of T from the rest length. Beyond the first and the last point
// the tension goes on with the slope there, or stays as it is.
#include <utility>

#include <springnet/sdk/law.hpp>
#include <springnet/sdk/table.hpp>

namespace {
using namespace springnet::sdk;

struct MeasuredCurve {
  MonotoneCubic tension;
  double energy_at_rest;
};

struct Measured : SpringFunction {
  enum { beyond };
  enum { elongations, forces };
  using has = Has<Energy>;
  static constexpr const char* id = "table";
  static constexpr const char* summary = "measured curve, the tension at given elongations l - l0";
  static constexpr const char* reference =
      "F. N. Fritsch and R. E. Carlson, Monotone piecewise cubic interpolation, SIAM J. Numer. Anal. 17 (1980) 238-246";
  static constexpr bool fits_elements = true;
  static constexpr bool not_zero_at_rest = true;  // if the curve is not
  static constexpr Parameter parameters[] = {
      choice("beyond", {"linear", "constant"}, "the force before the first and after the last elongation")};
  static constexpr Table tables[] = {
      table("elongations", "m", "l - l0 of each point, below 0 in compression").increasing().at_least_values(2),
      table("forces", "N", "tension at each of them, below 0 where the spring pushes").as_long_as(elongations)};

  static MeasuredCurve prepare(const TableSource& source) {
    const Beyond outside = source.parameter(beyond) == 0 ? Beyond::linear : Beyond::constant;
    MonotoneCubic curve(source[elongations], source[forces], outside);
    const double energy_at_rest = curve.integral(0.0);
    return {std::move(curve), energy_at_rest};
  }

  static auto force(const auto& e, const auto&) { return e.table.tension(e.elongation()); }
  static auto energy(const auto& e, const auto&) {
    return e.table.tension.integral(e.elongation()) - e.table.energy_at_rest;
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.table", "0.1.0", "springnet", "MIT", Measured);
