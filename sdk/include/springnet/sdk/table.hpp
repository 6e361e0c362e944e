// Curves through points for laws with tables: the monotone piecewise cubic of Fritsch and Carlson (SIAM J. Numer. Anal.
// 17 (1980) 238-246), its derivatives and its integral, on dual numbers.
//
//   struct Measured : SpringFunction {
//     static constexpr Table tables[] = {table("elongations", "m", "…").increasing().at_least_values(2),
//                                        table("forces", "N", "tension at each of them").as_long_as(0)};
//     MonotoneCubic prepare(const TableSource& source) const { return {source[0], source[1], Beyond::linear}; }
//     static auto force(const auto& e, const auto&) { return e.table(e.elongation()); }
//     …
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <springnet/sdk/dual.hpp>

namespace springnet::sdk {

// Slopes at `count` points for a cubic between each two that is monotone where the points are. Interior slopes become
// those of the parabola through a point and its neighbours, 0 at a local extremum. Slopes at both ends are given, with
// the sign of the secant beside them, or 0. Then all are limited: a cubic is monotone if its end slopes, divided by the
// secant, are not negative and lie in the disc of radius 3 around 0. x(k): of point k; secant(k): slope of the line
// from point k to the next; slope(k): reference to the slope at point k.
template <class X, class Secant, class Slope>
void monotone_slopes(std::size_t count, const X& x, const Secant& secant, const Slope& slope) {
  for (std::size_t k = 1; k + 1 < count; ++k) {
    const double before = secant(k - 1), after = secant(k);
    slope(k) = 0.0;
    if (!((before > 0 && after > 0) || (before < 0 && after < 0))) continue;
    const double share = (x(k + 1) - x(k)) / (x(k + 1) - x(k - 1));
    slope(k) = share * before + (1 - share) * after;
  }
  for (std::size_t k = 0; k + 1 < count; ++k) {
    const double middle = secant(k);
    if (middle == 0) continue;  // both slopes are 0 already
    const double size = std::hypot(slope(k) / middle, slope(k + 1) / middle);
    if (size <= 3) continue;
    slope(k) *= 3 / size;
    slope(k + 1) *= 3 / size;
  }
}

// What a curve does before its first and after its last point.
enum class Beyond {
  constant,  // keeps the value there; the derivative jumps to 0
  linear     // goes on with the slope there; the derivative is continuous
};

// y(x) through points (x_k, y_k), x increasing. y is continuous with its first derivative, does not overshoot between
// points, and is a straight line through two points, or points on a line. Its error falls with the third power of the
// spacing for smooth curves, with the second next to their extrema, where slopes are limited. Units are those of the
// points.
class MonotoneCubic {
 public:
  // Throws std::invalid_argument unless there are two points or more, as many x as y, all finite and x increasing, far
  // enough apart for finite slopes.
  MonotoneCubic(std::span<const double> x, std::span<const double> y, Beyond beyond) { fit(x, y, beyond); }

  // y(x); with dual numbers, with its derivatives, those of second order, too. nan for nan and infinities.
  template <std::size_t N, class T>
  [[nodiscard]] SPRINGNET_INLINE Dual<N, T> operator()(const Dual<N, T>& x) const {
    const Piece& p = pieces_[piece_of(value_of(x))];
    const T d = x.value - p.x;
    return detail::chain(x, p.value(d), p.slope(d));
  }
  // The integral of y from the first point to x, exact but for rounding; negative x too.
  template <std::size_t N, class T>
  [[nodiscard]] SPRINGNET_INLINE Dual<N, T> integral(const Dual<N, T>& x) const {
    const Piece& p = pieces_[piece_of(value_of(x))];
    const T d = x.value - p.x;
    return detail::chain(x, p.integral(d), p.value(d));
  }
  [[nodiscard]] double operator()(double x) const { return (*this)(Dual<0>(x)).value; }
  [[nodiscard]] double integral(double x) const { return integral(Dual<0>(x)).value; }

 private:
  // y = c0 + d (c1 + d (c2 + d c3)) with d = x - p.x; `before`: the integral from the first point up to p.x. 64 bytes
  // with the padding: a cache line.
  struct alignas(64) Piece {
    double x, c0, c1, c2, c3, before;

    template <class T>
    [[nodiscard]] SPRINGNET_INLINE T value(const T& d) const {
      return c0 + d * (c1 + d * (c2 + d * c3));
    }
    template <class T>
    [[nodiscard]] SPRINGNET_INLINE T slope(const T& d) const {
      return c1 + d * (2.0 * c2 + d * (3.0 * c3));
    }
    template <class T>
    [[nodiscard]] SPRINGNET_INLINE T integral(const T& d) const {
      return before + d * (c0 + d * (c1 / 2.0 + d * (c2 / 3.0 + d * (c3 / 4.0))));
    }
  };

  // Piece 0 lies before the first point, piece k from point k - 1 on. A binary search of always as many steps; the
  // choice in each compiles to a conditional move.
  [[nodiscard]] SPRINGNET_INLINE std::size_t piece_of(double x) const {
    const double* const starts = starts_.data();
    std::size_t at = 0;
    for (std::size_t step = first_step_; step > 0; step /= 2) at += starts[at + step] <= x ? step : 0;
    return at;
  }

  void fit(std::span<const double> x, std::span<const double> y, Beyond beyond) {
    const std::size_t count = x.size();
    const auto fail = [](const std::string& what) { throw std::invalid_argument("a curve through points: " + what); };
    if (count != y.size()) fail("there must be as many x as y");
    if (count < 2) fail("it needs two points or more");
    const auto width = [&](std::size_t k) { return x[k + 1] - x[k]; };
    const auto secant = [&](std::size_t k) { return (y[k + 1] - y[k]) / width(k); };
    for (std::size_t k = 0; k + 1 < count; ++k) {
      if (!(x[k] < x[k + 1])) fail("x must increase, but not after point " + std::to_string(k + 1));
      if (!std::isfinite(width(k)) || !std::isfinite(secant(k)))
        fail("the slope after point " + std::to_string(k + 1) + " is not finite");
    }
    std::vector<double> slopes(count, secant(0));
    if (count > 2) {
      // Of the parabola through three points, at the first of them.
      const auto at_end = [](double own_width, double other_width, double own, double other) {
        const double slope = own + own_width / (own_width + other_width) * (own - other);
        return (slope > 0 && own > 0) || (slope < 0 && own < 0) ? slope : 0.0;
      };
      slopes.front() = at_end(width(0), width(1), secant(0), secant(1));
      slopes.back() = at_end(width(count - 2), width(count - 3), secant(count - 2), secant(count - 3));
    }
    monotone_slopes(
        count, [&](std::size_t k) { return x[k]; }, secant, [&](std::size_t k) -> double& { return slopes[k]; });

    const auto outside = [&](std::size_t point, double before) {
      return Piece{x[point], y[point], beyond == Beyond::linear ? slopes[point] : 0.0, 0.0, 0.0, before};
    };
    pieces_.reserve(count + 1);
    pieces_.push_back(outside(0, 0.0));
    double before = 0.0;
    for (std::size_t k = 0; k + 1 < count; ++k) {
      const double h = width(k), middle = secant(k), m0 = slopes[k], m1 = slopes[k + 1];
      pieces_.push_back({x[k], y[k], m0, (3.0 * middle - 2.0 * m0 - m1) / h, (m0 + m1 - 2.0 * middle) / h / h, before});
      before = pieces_.back().integral(h);
      const Piece& p = pieces_.back();
      if (!std::isfinite(p.c2) || !std::isfinite(p.c3) || !std::isfinite(before))
        fail("the curve after point " + std::to_string(k + 1) + " is not finite");
    }
    pieces_.push_back(outside(count - 1, before));

    // Starts of the pieces, filled up with nan to a power of two: no x lies there.
    while (2 * first_step_ < pieces_.size()) first_step_ *= 2;
    starts_.assign(2 * first_step_, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t k = 1; k < pieces_.size(); ++k) starts_[k] = pieces_[k].x;
  }

  std::vector<Piece> pieces_;
  std::vector<double> starts_;  // [piece]; the first is not read
  std::size_t first_step_ = 1;
};

}  // namespace springnet::sdk
