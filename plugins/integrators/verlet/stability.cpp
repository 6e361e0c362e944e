#include "stability.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace {

constexpr int most_iterations = 100, least_iterations = 10;
constexpr double accuracy = 1e-4;   // change of the limit in an iteration, three times in a row
constexpr double rounding = 1e-20;  // of squares
constexpr double infinite = std::numeric_limits<double>::infinity();

// Of h^2 q + h l = 1.
double step_of(double q, double l) {
  const double root = std::sqrt(std::max(l * l + 4.0 * q, 0.0));
  return l + root > 0.0 ? 2.0 / (l + root) : infinite;
}

// A symmetric matrix [[a, b], [b, c]].
struct Two {
  double a, b, c;
  [[nodiscard]] double quotient(double x, double y) const { return x * x * a + 2.0 * x * y * b + y * y * c; }
};

// Where in the plane of two directions the step is least: cosine and sine of an angle. h: a step that is too long, s.
std::pair<double, double> least_in_plane(const Two& quadratic, const Two& linear, double h) {
  double x = 1.0, y = 0.0;
  for (int i = 0; i < 20; ++i) {
    // Without a limit so far the quadratic part decides, or where there is none the linear one.
    const bool any = quadratic.a != 0.0 || quadratic.b != 0.0 || quadratic.c != 0.0;
    const double s = std::isfinite(h) ? h * h : any ? 1.0 : 0.0, t = std::isfinite(h) ? h : any ? 0.0 : 1.0;
    const double a = s * quadratic.a + t * linear.a, b = s * quadratic.b + t * linear.b,
                 c = s * quadratic.c + t * linear.c;
    const double angle = 0.5 * std::atan2(2.0 * b, a - c);  // of the greater eigenvalue
    x = std::cos(angle);
    y = std::sin(angle);
    const double next = step_of(quadratic.quotient(x, y), linear.quotient(x, y));
    if (!(std::abs(next - h) > 1e-12 * h)) break;
    h = next;
  }
  return {x, y};
}

}  // namespace

double Stability::limit(bool restarts) {
  if (!restarts) return least(Form::lagging);
  const double damped = least(Form::restarting_damping), both = least(Form::restarting);
  return std::isnan(both) ? both : std::min(both, damped);
}

double Stability::product(const Values& a, const Values& b) const {
  const springnet_network& network = host_.network();
  const std::size_t n = network.node_count;
  double sum = 0.0;
  for (std::size_t i = 0; i < 3 * n; ++i) sum += network.mass[i % n] * a[i] * b[i];
  return sum;
}

void Stability::apply(Form form, const Values& x, Values& quadratic, Values& linear) {
  const std::size_t size = x.size();
  host_.jacobian_times(zero_.data(), x.data(), linear.data());
  if (form == Form::restarting_damping) {
    std::fill(quadratic.begin(), quadratic.end(), 0.0);
  } else {
    host_.jacobian_times(x.data(), zero_.data(), quadratic.data());
    for (double& value : quadratic) value *= -0.25;
  }
  if (form == Form::restarting) {
    host_.jacobian_times(zero_.data(), linear.data(), twice_.data());
    for (std::size_t i = 0; i < size; ++i) quadratic[i] -= 0.25 * twice_[i];
  }
  const double share = form == Form::lagging ? -1.0 : -0.5;
  for (double& value : linear) value *= share;
}

double Stability::least(Form form) {
  const std::size_t size = 3 * std::size_t{host_.network().node_count};
  for (Values* values :
       {&x_, &x_quadratic_, &x_linear_, &d_, &d_quadratic_, &d_linear_, &gradient_, &last_gradient_, &zero_, &twice_})
    values->assign(size, 0.0);
  // Numbers that no symmetry of a net shares, the same in every run (xorshift; Marsaglia 2003).
  std::uint64_t bits = 0x9e3779b97f4a7c15u;
  for (double& value : x_) {
    bits ^= bits << 13;
    bits ^= bits >> 7;
    bits ^= bits << 17;
    value = static_cast<double>(bits >> 11) * 0x1p-53 - 0.5;
  }
  host_.project(nullptr, x_.data());
  const double start = product(x_, x_);
  if (!(start > 0.0)) return infinite;  // nothing moves freely
  for (double& value : x_) value /= std::sqrt(start);
  apply(form, x_, x_quadratic_, x_linear_);
  double h = step_of(product(x_, x_quadratic_), product(x_, x_linear_));
  double last_square = 0.0;
  int resting = 0;
  for (int iteration = 0; iteration < most_iterations && resting < 3; ++iteration) {
    // What of (h^2 Q + h L) x is not along x; where nothing limits the step, of Q x, or of L x.
    const double s = std::isfinite(h) ? h * h : 1.0, t = std::isfinite(h) ? h : 1.0;
    for (std::size_t i = 0; i < size; ++i) gradient_[i] = s * x_quadratic_[i] + t * x_linear_[i];
    const double along = product(x_, gradient_);
    for (std::size_t i = 0; i < size; ++i) gradient_[i] -= along * x_[i];
    const double square = product(gradient_, gradient_);
    if (!std::isfinite(square) || !std::isfinite(along)) return std::numeric_limits<double>::quiet_NaN();
    // Where x is an eigenvector the rest is rounding, which constraints need not allow.
    if (!(square > rounding * along * along)) break;
    // Polak and Ribiere's direction, at right angles to x.
    const double turn = last_square > 0.0 ? (square - product(gradient_, last_gradient_)) / last_square : 0.0;
    for (std::size_t i = 0; i < size; ++i) d_[i] = gradient_[i] + std::max(turn, 0.0) * d_[i];
    const double left = product(x_, d_);
    for (std::size_t i = 0; i < size; ++i) d_[i] -= left * x_[i];
    const double length = std::sqrt(product(d_, d_));
    if (!(length > 0.0)) break;
    for (double& value : d_) value /= length;
    last_square = square;
    std::swap(gradient_, last_gradient_);

    apply(form, d_, d_quadratic_, d_linear_);
    const auto two = [&](const Values& of_x, const Values& of_d) {
      return Two{product(x_, of_x), 0.5 * (product(d_, of_x) + product(x_, of_d)), product(d_, of_d)};
    };
    const Two quadratic = two(x_quadratic_, d_quadratic_), linear = two(x_linear_, d_linear_);
    const auto [c, d] = least_in_plane(quadratic, linear, h);
    for (std::size_t i = 0; i < size; ++i) {
      const double old = x_[i];
      x_[i] = c * old + d * d_[i];
      d_[i] = (c * d_[i] - d * old) * length;
      x_quadratic_[i] = c * x_quadratic_[i] + d * d_quadratic_[i];
      x_linear_[i] = c * x_linear_[i] + d * d_linear_[i];
    }
    const double next = step_of(quadratic.quotient(c, d), linear.quotient(c, d));
    if (std::isnan(next)) return next;
    const bool rests = iteration >= least_iterations && !(std::abs(next - h) > accuracy * next);
    resting = rests ? resting + 1 : 0;
    h = next;
  }
  return h;
}
