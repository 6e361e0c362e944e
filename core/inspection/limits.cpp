#include "inspection/limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inspection/dominant.hpp"
#include "inspection/sweep.hpp"

namespace springnet {

namespace {

constexpr double sought_accuracy = 1e-3;  // of a limit, relative
constexpr double known_accuracy = 1e-2;   // what may be called known
constexpr double hopeless = 1e5;          // times the first guess: no limit is looked for beyond,
constexpr double hopeless_blocks = 1e3;   // where motions that nothing resists have a factor of 1 but for rounding

// The positive root of a t^2 + b t = 1, for a, b >= 0.
double crossing(double a, double b) { return 2.0 / (b + std::sqrt(b * b + 4.0 * a)); }

// A time constant at which some node's own springs make its part of t^2 M^-1 K + t M^-1 D about 1. Limits are near.
std::optional<double> first_guess(const Network& network, const LinearNetwork& linear, const Joints& joints) {
  std::optional<double> least;
  for (NodeIndex k = 0; k < joints.node_count(); ++k) {
    if (!linear.nodes[k].free) continue;
    double stiffness = 0.0, damping = 0.0;
    for (const Joint& joint : joints.of(k)) {
      if (joint.spring == no_spring) continue;
      const LinearSpring& spring = linear.springs[joint.spring];
      stiffness += std::abs(spring.stiffness) + std::abs(spring.across_stiffness());
      damping += std::abs(spring.axial_damping) + std::abs(spring.general_damping);
    }
    stiffness += linear.elements.stiffness_bound(k);
    damping += linear.elements.damping_bound(k);
    const LinearNode& node = linear.nodes[k];
    const double t = crossing(stiffness / network.nodes()[k].mass + node.by_position.norm(),
                              damping / network.nodes()[k].mass + node.by_velocity.norm());
    if (std::isfinite(t) && t > 0.0) least = std::min(t, least.value_or(t));
  }
  return least;
}

// Whether no motion can gain energy from springs and neurons, so that I + t^2 M^-1 K + t M^-1 D is positive definite
// for every t. It may be so otherwise as well.
bool plainly_definite(const LinearNetwork& linear) {
  const auto dissipative = [](const Block& block) {
    return block.isDiagonal(0.0) && block.diagonal().maxCoeff() <= 0.0;
  };
  return std::all_of(linear.springs.begin(), linear.springs.end(),
                     [](const LinearSpring& s) {
                       // What rounding leaves of the tension of a spring at its rest length is no compression.
                       return s.stiffness >= 0.0 && s.across_stiffness() >= -1e-12 * s.stiffness &&
                              s.axial_damping >= 0.0 && s.general_damping >= 0.0;
                     }) &&
         linear.elements.plainly_definite() &&
         std::all_of(linear.nodes.begin(), linear.nodes.end(), [&](const LinearNode& node) {
           return !node.free || (dissipative(node.by_position) && dissipative(node.by_velocity));
         });
}

// Looks for the time constant at which the dominant eigenvalue of a sweep reaches 1.
class Search {
 public:
  // may_be_none: a net may have no limit even though something acts on its nodes. reach: times the guess.
  Search(LinearSweep& sweep, Wanted wanted, bool may_be_none, double reach)
      : sweep_(sweep), may_be_none_(may_be_none), reach_(reach), start_(scattered()) {
    // Seconds for a net of 100,000 nodes, and no more than 64 MB of vectors.
    const auto size = static_cast<double>(std::max<Eigen::Index>(sweep.size(), 1));
    budget_ = static_cast<std::size_t>(std::clamp(2e8 / static_cast<double>(sweep.work() + 1), 60.0, 20000.0));
    options_.wanted = wanted;
    options_.basis = static_cast<std::size_t>(std::clamp(8e6 / size, 8.0, 80.0));
    options_.tolerance = 0.2 * sought_accuracy;
  }

  // Empty if there is none within reach.
  std::optional<double> run(double guess);
  [[nodiscard]] bool accurate() const { return accurate_; }
  // The motion that neither grows nor fades at the limit.
  [[nodiscard]] const Dominant& mode() const { return mode_; }

 private:
  Eigen::VectorXd scattered() const {
    Eigen::VectorXd u = scattered_vector(sweep_.size());
    sweep_.restrict(u);
    return u;
  }
  // Logarithm of what a sweep multiplies the dominant motion with. Anything that fades for certain is at least -20.
  double growth(double t);

  LinearSweep& sweep_;
  bool may_be_none_;
  double reach_;
  Eigen::VectorXd start_;
  DominantOptions options_;
  std::size_t budget_;
  Dominant mode_;
  bool accurate_ = true;
};

double Search::growth(double t) {
  sweep_.set_time_constant(t);
  options_.applications = std::max(budget_ / 4, options_.basis);
  if (mode_.applications > 0) start_ += 0.1 * start_.norm() * scattered();  // lest a motion hides
  mode_ = dominant_eigenvalue([this](Eigen::VectorXd& u) { sweep_.apply(u); }, start_, options_);
  budget_ -= std::min(budget_, mode_.applications);
  if (!(start_.norm() > 0.0) || !start_.allFinite()) start_ = scattered();
  const double factor = options_.wanted == Wanted::largest_real ? mode_.value.real() : std::abs(mode_.value);
  accurate_ = mode_.error <= known_accuracy * std::max(1.0, std::abs(factor));
  return factor > 0.0 ? std::clamp(std::log(factor), -20.0, 20.0) : -20.0;
}

std::optional<double> Search::run(double guess) {
  double below = 0.0, above = std::numeric_limits<double>::infinity();
  double below_growth = 0.0, above_growth = 0.0;
  double t = guess;
  double least_raise = 1.02;
  while (true) {
    const double now = growth(t);
    // Motions that nothing resists have a factor of 1 in a sweep with blocks, or nearly: only what is clearly above
    // grows.
    if (now >= 1e-6) {
      above = t, above_growth = now;
    } else {
      below = t, below_growth = now;
    }
    // A sweep's factor goes with the first to second power of t near the limit; more slowly with blocks, where it may
    // come near 1 without ever reaching it.
    if (std::isfinite(above) && below > 0.0 && std::abs(now) <= 0.5 * sought_accuracy && !may_be_none_) return t;
    if (above <= below * (1.0 + sought_accuracy)) return t;
    if (budget_ == 0) break;
    if (below > 0.0 && std::isfinite(above)) {
      // The secant in the logarithms, kept off the ends of the bracket.
      const double width = std::log(above / below);
      const double share = std::clamp(-below_growth / (above_growth - below_growth), 0.02, 0.98);
      t = below * std::exp(width * share);
    } else if (below > 0.0) {
      if (t > reach_ * guess) return std::nullopt;
      t *= std::clamp(std::exp(-now), least_raise, 4.0);
      least_raise = std::min(4.0, least_raise * least_raise);
    } else {
      if (t < guess / reach_) break;
      t *= std::clamp(std::exp(-now), 0.25, 0.98);
    }
  }
  accurate_ = accurate_ && above <= below * (1.0 + known_accuracy);
  if (!std::isfinite(above) && may_be_none_) return std::nullopt;
  return std::isfinite(above) && below > 0.0 ? std::sqrt(above * below) : t;
}

// The node that moves most, and the spring or element that acts on it most.
std::optional<Bottleneck> bottleneck(const Network& network, const LinearNetwork& linear, const Joints& joints,
                                     const LinearSweep& sweep, const Dominant& mode, double t) {
  if (mode.real.size() == 0) return std::nullopt;
  constexpr double alike = 1.0 - 1e-3;  // differences below are the iteration's, not the net's: the lowest number wins
  std::optional<NodeIndex> node;
  double greatest = 0.0;
  for (NodeIndex k = 0; k < joints.node_count(); ++k) {
    const double square = sweep.velocity(mode.real, k).squaredNorm() + sweep.velocity(mode.imaginary, k).squaredNorm();
    if (square * alike * alike <= greatest) continue;
    greatest = square;
    node = k;
  }
  if (!node) return std::nullopt;
  Bottleneck result{*node, network.nodes()[*node].mass, std::nullopt, std::nullopt, 0.0, 0.0, 0.0, 0.0};
  double share = 0.0;
  for (const Joint& joint : joints.of(*node)) {
    if (joint.spring == no_spring) continue;
    const LinearSpring& spring = linear.springs[joint.spring];
    const double damping = spring.axial_damping + spring.general_damping;
    const double elastic = t * t * spring.stiffness / result.mass, viscous = t * damping / result.mass;
    if ((std::abs(elastic) + std::abs(viscous)) * alike <= share) continue;
    share = std::abs(elastic) + std::abs(viscous);
    result.spring = joint.spring;
    result.stiffness = spring.stiffness;
    result.damping = damping;
    result.elastic_share = elastic;
    result.viscous_share = viscous;
  }
  for (const LinearShare& seen : linear.elements.of(*node)) {
    const LinearElement& element = linear.elements.all()[seen.element];
    const double square = element.gradient[seen.place].squaredNorm();
    const double elastic = t * t * element.stiffness * square / result.mass;
    const double viscous = t * element.damping * square / result.mass;
    if ((std::abs(elastic) + std::abs(viscous)) * alike <= share) continue;
    share = std::abs(elastic) + std::abs(viscous);
    result.spring = std::nullopt;
    result.element = seen.element;
    result.stiffness = element.stiffness * square;
    result.damping = element.damping * square;
    result.elastic_share = elastic;
    result.viscous_share = viscous;
  }
  return result;
}

}  // namespace

void find_limits(const Network& network, const LinearNetwork& linear, const Joints& joints, Inspection& result) {
  using Kind = TimeConstantLimit::Kind;
  for (const UpdateRule rule : update_rules) {
    result.limits.push_back({rule, linear.unknown_because.empty() ? Kind::none : Kind::unknown, 0.0, std::nullopt});
  }
  result.unknown_because = linear.unknown_because;
  if (!result.unknown_because.empty()) {
    result.limits[static_cast<std::size_t>(UpdateRule::newton)].kind = Kind::none;
    return;
  }
  const std::optional<double> guess = first_guess(network, linear, joints);
  if (!guess) return;  // nothing acts on any free node
  const double theta = result.options.theta;

  const auto search = [&](UpdateRule rule, Wanted wanted) {
    LinearSweep sweep(network, linear, joints, rule);
    const bool explicit_rule = rule == UpdateRule::synchronous || rule == UpdateRule::wavefront;
    Search root(sweep, wanted, wanted == Wanted::largest_real || !explicit_rule,
                explicit_rule ? hopeless : hopeless_blocks);
    TimeConstantLimit limit{rule, Kind::none, 0.0, std::nullopt};
    if (const std::optional<double> t = root.run(*guess)) {
      limit.kind = root.accurate() ? Kind::known : Kind::estimate;
      limit.time_constant = *t / theta;
      limit.set_by = bottleneck(network, linear, joints, sweep, root.mode(), *t);
    }
    return limit;
  };
  const auto put = [&](TimeConstantLimit limit) { result.limits[static_cast<std::size_t>(limit.rule)] = limit; };
  for (const UpdateRule rule : {UpdateRule::synchronous, UpdateRule::wavefront}) {
    put(search(rule, Wanted::largest_magnitude));
  }

  // Where A_t is symmetric and I + A_t positive definite, node by node (Gauss and Seidel) converges in every order
  // (Ostrowski, Reich). Where it is not definite any more, a step has several solutions, and a rule that goes downhill,
  // as these do, ends at one of them. That begins where the rightmost eigenvalue of -A_t, the synchronous sweep,
  // reaches 1.
  if (plainly_definite(linear)) return;
  if (LinearSweep(network, linear, joints, UpdateRule::synchronous).symmetric()) {
    const TimeConstantLimit unique = search(UpdateRule::synchronous, Wanted::largest_real);
    if (unique.kind != Kind::none) result.unique_time_constant = unique.time_constant;
    return;
  }
  for (const UpdateRule rule : {UpdateRule::block, UpdateRule::coloured}) put(search(rule, Wanted::largest_magnitude));
}

}  // namespace springnet
