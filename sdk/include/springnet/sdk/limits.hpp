// The largest time steps of an integrator, for `springnet inspect`: how it reports them, and how it finds them on the
// network that the host has linearised.
//
// A method is written as a linear map that takes a small change of the state, or of the velocities alone, from one step
// or sweep to the next; its largest time step is where the dominant eigenvalue of the map reaches 1.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <springnet/sdk/host.hpp>
#include <springnet/sdk/math.hpp>

namespace springnet::sdk {

inline constexpr std::uint32_t no_limit_node = 0xffffffffu;

struct Limit {
  std::uint32_t kind = SPRINGNET_LIMIT_NONE;
  double time_step = 0.0;              // s
  double weight = 0.0;                 // s, see springnet_limit; 0: the time step
  std::uint32_t node = no_limit_node;  // engine's
  std::string reason{};                // of none and unknown
};

class LimitSink {
 public:
  explicit LimitSink(const springnet_limits& limits) noexcept : limits_(&limits) {}
  // rule: "" if the integrator has no rules to choose from. An infinite limit is reported as none.
  void report(const char* rule, const Limit& limit) const {
    auto result = sized<springnet_limit>();
    result.kind = std::isinf(limit.time_step) ? std::uint32_t{SPRINGNET_LIMIT_NONE} : limit.kind;
    result.rule = rule;
    result.time_step = limit.time_step;
    result.weight = limit.weight;
    result.node = limit.node;
    result.reason = limit.reason.empty() ? nullptr : limit.reason.c_str();
    static_cast<void>(limits_->tell(limits_->context, &result));
  }
  void none(const char* rule, std::string reason = {}) const {
    report(rule, {SPRINGNET_LIMIT_NONE, 0.0, 0.0, no_limit_node, std::move(reason)});
  }
  void unknown(const char* rule, std::string reason) const {
    report(rule, {SPRINGNET_LIMIT_UNKNOWN, 0.0, 0.0, no_limit_node, std::move(reason)});
  }

 private:
  const springnet_limits* limits_;
};

// A vector with a component along every mode, the same in every run; [size].
[[nodiscard]] inline std::vector<double> scattered_vector(std::size_t size) {
  std::vector<double> x(size);
  std::uint64_t state = 0x9e3779b97f4a7c15u;
  for (double& value : x) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    value = static_cast<double>(state >> 11) * 0x1p-53 - 0.5;
  }
  return x;
}

// The positive solution h of a h^2 + b h = 1, s; infinity if there is none.
[[nodiscard]] inline double step_of(double a, double b) noexcept {
  const double square = b * b + 4.0 * a;
  const double sum = square < 0.0 ? 0.0 : b + std::sqrt(square);
  return sum > 0.0 ? 2.0 / sum : std::numeric_limits<double>::infinity();
}

// The network as Host::linearise left it, in x = sqrt(m) u: velocities times the roots of the masses, [3n], x of all
// nodes first. Its matrices are symmetric in these coordinates where the forces have a potential.
class LinearisedNetwork {
 public:
  explicit LinearisedNetwork(Host host)
      : host_(host), nodes_(host.network().node_count), root_(3 * nodes_), p_(3 * nodes_), v_(3 * nodes_) {
    for (std::size_t i = 0; i < root_.size(); ++i) root_[i] = std::sqrt(host.network().mass[i % nodes_]);
  }

  [[nodiscard]] std::size_t size() const noexcept { return root_.size(); }
  [[nodiscard]] const std::vector<double>& root_mass() const noexcept { return root_; }
  // A scattered vector, projected onto the constraints.
  [[nodiscard]] std::vector<double> start() const {
    std::vector<double> x = scattered_vector(size());
    host_.project(nullptr, x.data());
    for (std::size_t i = 0; i < size(); ++i) x[i] *= root_[i];
    return x;
  }
  // x <- (position_weight da/dp + velocity_weight da/dv) x.
  void times(double position_weight, double velocity_weight, double* x) {
    for (std::size_t i = 0; i < size(); ++i) {
      const double u = x[i] / root_[i];
      p_[i] = position_weight * u;
      v_[i] = velocity_weight * u;
    }
    host_.jacobian_times(p_.data(), v_.data(), x);
    for (std::size_t i = 0; i < size(); ++i) x[i] *= root_[i];
  }
  // Whether w^2 da/dp + w da/dv is symmetric, but for rounding.
  [[nodiscard]] bool is_symmetric(double w) {
    const std::vector<double> a = start();
    std::vector<double> b = a;
    for (std::size_t i = 0; i < size(); ++i) b[i] = a[i] * a[size() - 1 - i] / root_[i];
    host_.project(nullptr, b.data());
    for (std::size_t i = 0; i < size(); ++i) b[i] *= root_[i];
    std::vector<double> image_a = a, image_b = b;
    times(w * w, w, image_a.data());
    times(w * w, w, image_b.data());
    double ab = 0.0, ba = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
      ab += b[i] * image_a[i];
      ba += a[i] * image_b[i];
      scale += std::abs(b[i] * image_a[i]) + std::abs(a[i] * image_b[i]);
    }
    return std::abs(ab - ba) <= 1e-11 * scale;
  }
  // A step near the limits: the smallest at which a node's own block of w^2 da/dp + w da/dv has norm 1. Empty if
  // nothing acts on any free node.
  [[nodiscard]] std::optional<double> first_guess() const {
    constexpr double large = 1e30;  // so that the identity in the blocks does not hide small entries
    const auto norms = [&](double velocity_weight, double position_weight) {
      std::vector<double> blocks(9 * nodes_), result(nodes_);
      host_.diagonal_blocks(velocity_weight, position_weight, blocks.data());
      for (std::size_t k = 0; k < nodes_; ++k) {
        double square = 0.0;
        for (std::size_t i = 0; i < 9; ++i) {
          const double value = (blocks[9 * k + i] - (i % 4 == 0 ? 1.0 : 0.0)) / large;
          square += value * value;
        }
        result[k] = std::sqrt(square);
      }
      return result;
    };
    const std::vector<double> damping = norms(large, 0.0), stiffness = norms(0.0, large);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < nodes_; ++k) least = std::min(least, step_of(stiffness[k], damping[k]));
    return std::isfinite(least) && least > 0.0 ? std::optional(least) : std::nullopt;
  }
  // The node that moves most in a motion x, which may be complex; among equals the one with the lowest user's number.
  [[nodiscard]] std::uint32_t node_of(const std::vector<double>& real,
                                      const std::vector<double>& imaginary = {}) const {
    const springnet_network& network = host_.network();
    const auto square_of = [&](std::size_t k) {
      double sum = 0.0;
      for (std::size_t i = k; i < size(); i += nodes_) {
        sum += real[i] * real[i] / (root_[i] * root_[i]);
        if (!imaginary.empty()) sum += imaginary[i] * imaginary[i] / (root_[i] * root_[i]);
      }
      return sum;
    };
    double greatest = 0.0;
    for (std::size_t k = 0; k < nodes_; ++k) greatest = std::max(greatest, square_of(k));
    constexpr double alike = 0.998;  // differences below are the iteration's, not the network's
    std::uint32_t node = no_limit_node;
    for (std::uint32_t k = 0; k < nodes_; ++k) {
      if (!(greatest > 0.0) || square_of(k) < alike * greatest) continue;
      if (node == no_limit_node || network.user_number[k] < network.user_number[node]) node = k;
    }
    return node;
  }
  [[nodiscard]] std::uint32_t node_of(const Dominant& mode) const { return node_of(mode.real, mode.imaginary); }
  // How many vectors an eigenvalue search may keep: up to 64 MB.
  [[nodiscard]] std::uint32_t max_vectors() const noexcept {
    return static_cast<std::uint32_t>(std::clamp(8e6 / static_cast<double>(size() + 1), 8.0, 80.0));
  }

 private:
  Host host_;
  std::size_t nodes_;
  std::vector<double> root_, p_, v_;
};

// The smallest step h at which the greatest eigenvalue of h^2 Q + h L reaches 1, for symmetric Q and L: infinity if
// there is none, nan if a product is not finite. map(h, x) replaces x by (h^2 Q + h L) x. `guess`: s; `start`: in, a
// vector; out, the motion that limits the step. Each eigenvector found gives, by its Rayleigh quotients, a step that
// exceeds the limit only by the square of the vector's error.
template <class Map>
[[nodiscard]] double critical_step(const Host& host, double guess, std::vector<double>& start, std::uint32_t vectors,
                                   Map&& map, double accuracy = 1e-3) {
  constexpr int max_steps = 12, max_raises = 1;
  constexpr std::uint32_t max_vectors = 30;
  constexpr double raise = 1e6;
  DominantOptions options;
  options.wanted = SPRINGNET_LARGEST_REAL_PART;
  options.tolerance = 0.3 * std::sqrt(accuracy);
  options.applications = 90;
  options.vectors = std::min(vectors, max_vectors);
  const auto is_zero = [](double value) { return value == 0.0; };
  if (std::all_of(start.begin(), start.end(), is_zero)) return std::numeric_limits<double>::infinity();
  double h = guess;
  int raises = 0;
  for (int step = 0; step < max_steps; ++step) {
    const Dominant mode = host.dominant_eigenvalue(start, options, [&](double* x) { map(h, x); });
    if (!std::isfinite(mode.value.real())) return std::numeric_limits<double>::quiet_NaN();
    const std::vector<double>& x = mode.real;
    double square = 0.0;
    for (const double value : x) square += value * value;
    if (!(square > 0.0)) return std::numeric_limits<double>::infinity();
    const auto quotient = [&](double at) {
      std::vector<double> image = x;
      map(at, image.data());
      double sum = 0.0;
      for (std::size_t i = 0; i < x.size(); ++i) sum += x[i] * image[i];
      return sum / square;
    };
    const double one = quotient(h), two = quotient(2.0 * h);
    const double quadratic = 0.5 * two - one, linear = 2.0 * one - 0.5 * two;  // h^2 Q, h L
    if (!std::isfinite(one) || !std::isfinite(two)) return std::numeric_limits<double>::quiet_NaN();
    const double next = h * step_of(quadratic, linear);
    if (!std::isfinite(next) || next > 1e20 * guess) {
      if (++raises > max_raises) return std::numeric_limits<double>::infinity();
      h *= raise;
      continue;
    }
    start = x;
    // If one term dominates, the eigenvector does not depend on the step.
    const bool one_dominates = std::min(std::abs(quadratic), std::abs(linear)) <=
                               1e-2 * accuracy * std::max(std::abs(quadratic), std::abs(linear));
    if (one_dominates || std::abs(next - h) <= accuracy * h) return next;
    h = next;
  }
  return h;
}

// Finds the step at which the dominant eigenvalue of a map, which may depend on the step in any way, reaches 1.
// `Map` has set_step(h), s, and apply(double* x).
template <class Map>
class StepSearch {
 public:
  struct Settings {
    std::uint32_t wanted = SPRINGNET_LARGEST_MAGNITUDE;
    bool may_be_none = false;  // a network may have no limit even though something acts on its nodes
    double reach = 1e5;        // times the guess: beyond it no limit is searched for
    std::uint64_t applications = 20000;
    std::uint32_t vectors = 40;
    double accuracy = 1e-3;        // of the limit, relative
    double known_accuracy = 1e-2;  // of SPRINGNET_LIMIT_KNOWN
  };

  // start: not 0; [size].
  StepSearch(const Host& host, Map& map, std::vector<double> start, const Settings& settings)
      : host_(host),
        map_(map),
        scattered_(std::move(start)),
        start_(scattered_),
        settings_(settings),
        budget_(settings.applications) {}

  // The step, s; empty if there is none within reach.
  std::optional<double> run(double guess);
  // Whether the step is accurate to known_accuracy.
  [[nodiscard]] bool is_accurate() const noexcept { return accurate_; }
  // The motion that neither grows nor fades at the limit.
  [[nodiscard]] const Dominant& mode() const noexcept { return mode_; }

 private:
  static double norm(const std::vector<double>& x) {
    double square = 0.0;
    for (const double value : x) square += value * value;
    return std::sqrt(square);
  }
  // Logarithm of the dominant eigenvalue's magnitude, or real part; -20 at least.
  double growth(double step);

  Host host_;
  Map& map_;
  std::vector<double> scattered_, start_;
  Settings settings_;
  std::uint64_t budget_;  // applications left
  Dominant mode_;
  bool accurate_ = true;
};

template <class Map>
double StepSearch<Map>::growth(double step) {
  map_.set_step(step);
  DominantOptions options;
  options.wanted = settings_.wanted;
  options.tolerance = 0.2 * settings_.accuracy;
  options.applications = std::max<std::uint64_t>(budget_ / 4, settings_.vectors);
  options.vectors = settings_.vectors;
  if (mode_.applications > 0) {
    const double share = 0.1 * norm(start_) / norm(scattered_);  // so that no motion stays hidden
    for (std::size_t i = 0; i < start_.size(); ++i) start_[i] += share * scattered_[i];
  }
  mode_ = host_.dominant_eigenvalue(start_, options, [this](double* x) { map_.apply(x); });
  budget_ -= std::min(budget_, mode_.applications);
  const double length = norm(start_);
  if (!(length > 0.0) || !std::isfinite(length)) start_ = scattered_;
  const double factor = settings_.wanted == SPRINGNET_LARGEST_REAL_PART ? mode_.value.real() : std::abs(mode_.value);
  accurate_ = mode_.error <= settings_.known_accuracy * std::max(1.0, std::abs(factor));
  return factor > 0.0 ? std::clamp(sdk::log(factor), -20.0, 20.0) : -20.0;
}

template <class Map>
std::optional<double> StepSearch<Map>::run(double guess) {
  double below = 0.0, above = std::numeric_limits<double>::infinity();
  double below_growth = 0.0, above_growth = 0.0;
  double t = guess;
  double min_raise = 1.02;
  while (true) {
    const double now = growth(t);
    // Motions that nothing resists have a factor of about 1: only what is clearly above 1 grows.
    if (now >= 1e-6) {
      above = t, above_growth = now;
    } else {
      below = t, below_growth = now;
    }
    // Near the limit the factor grows with the first to second power of the step; more slowly for implicit methods,
    // where it may approach 1 without ever reaching it.
    const bool met = std::isfinite(above) && below > 0.0 && std::abs(now) <= 0.5 * settings_.accuracy;
    if (met && !settings_.may_be_none) return t;
    if (above <= below * (1.0 + settings_.accuracy)) return t;
    if (budget_ == 0) break;
    if (below > 0.0 && std::isfinite(above)) {
      // The secant in the logarithms, kept off the ends of the bracket.
      const double share = std::clamp(-below_growth / (above_growth - below_growth), 0.02, 0.98);
      t = below * sdk::exp(sdk::log(above / below) * share);
    } else if (below > 0.0) {
      if (t > settings_.reach * guess) return std::nullopt;
      t *= std::clamp(sdk::exp(-now), min_raise, 4.0);
      min_raise = std::min(4.0, min_raise * min_raise);
    } else {
      if (t < guess / settings_.reach) break;
      t *= std::clamp(sdk::exp(-now), 0.25, 0.98);
    }
  }
  accurate_ = accurate_ && above <= below * (1.0 + settings_.known_accuracy);
  if (!std::isfinite(above) && settings_.may_be_none) return std::nullopt;
  return std::isfinite(above) && below > 0.0 ? std::sqrt(above * below) : t;
}

}  // namespace springnet::sdk
