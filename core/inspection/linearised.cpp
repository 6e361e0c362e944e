#include "inspection/linearised.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <Eigen/Core>

namespace springnet {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct LawAnswer {
  double force = unknown, by_q = unknown, by_rate = unknown;
};

// A law of one material, asked for one spring after the other.
class LawAtRest {
 public:
  LawAtRest(const Component& component, const LawUse& use)
      : component_(component),
        law_(component.law()),
        values_(complete_parameters(*component.description, use.parameters, "law '" + use.id + "'")),
        parameters_(pointers(values_)),
        parameter_strides_(values_.size(), 0),
        state_values_(defaults(law_.states, law_.state_count)),
        states_(pointers(state_values_)),
        state_rates_(law_.state_count),
        state_rate_pointers_(law_.state_count),
        input_values_(defaults(law_.inputs, law_.input_count)),
        inputs_(pointers(input_values_)),
        input_strides_(input_values_.size(), 0) {
    for (std::size_t k = 0; k < state_rates_.size(); ++k) state_rate_pointers_[k] = &state_rates_[k];
  }

  [[nodiscard]] bool reads_speed() const { return law_.invariant == SPRINGNET_RELATIVE_SPEED; }

  LawAnswer answer(double length, double rest_length) {
    const std::uint32_t capabilities = component_.description->capabilities;
    // A table comes from a scene's arrays, which a network does not keep.
    if ((capabilities & SPRINGNET_HAS_DERIVATIVES) == 0 || law_.prepare != nullptr) return {};
    const double q = reads_speed() ? 0.0 : length;
    const double rate = 0.0;
    LawAnswer result{0.0, 0.0, 0.0};
    springnet_message message{};
    springnet_law_batch batch{};
    batch.struct_size = sizeof batch;
    batch.count = 1;
    batch.instruction_set = SPRINGNET_GENERIC;
    batch.q = &q;
    batch.rate = (capabilities & SPRINGNET_READS_RATE) != 0 ? &rate : nullptr;
    batch.reference = &rest_length;
    batch.parameters = parameters_.data();
    batch.parameter_strides = parameter_strides_.data();
    batch.states = states_.data();
    batch.inputs = inputs_.data();
    batch.input_strides = input_strides_.data();
    batch.force = &result.force;
    batch.force_by_q = &result.by_q;
    batch.force_by_rate = batch.rate == nullptr ? nullptr : &result.by_rate;
    batch.state_rates = state_rate_pointers_.data();
    batch.message = &message;
    return law_.evaluate(&batch) == SPRINGNET_OK ? result : LawAnswer{};
  }

 private:
  static std::vector<const double*> pointers(const std::vector<double>& values) {
    std::vector<const double*> result;
    for (const double& value : values) result.push_back(&value);
    return result;
  }
  static std::vector<double> defaults(const springnet_parameter* const* parameters, std::uint32_t count) {
    std::vector<double> result;
    for (std::uint32_t k = 0; k < count; ++k) result.push_back(parameters[k]->default_value);
    return result;
  }

  const Component& component_;
  const springnet_law& law_;
  std::vector<double> values_;
  std::vector<const double*> parameters_;
  std::vector<std::uint32_t> parameter_strides_;
  std::vector<double> state_values_;
  std::vector<const double*> states_;
  std::vector<double> state_rates_;
  std::vector<double*> state_rate_pointers_;
  std::vector<double> input_values_;
  std::vector<const double*> inputs_;
  std::vector<std::uint32_t> input_strides_;
};

// The laws of one material. A component outlives the host's pointer to it here: `plugins` keeps it.
struct MaterialAtRest {
  MaterialAtRest(const Material& material, const PluginHost& plugins) {
    if (material.spring) {
      spring.emplace(*plugins.require(ComponentKind::spring_function, material.spring->id), *material.spring);
    }
    if (material.viscosity) {
      viscosity.emplace(*plugins.require(ComponentKind::viscosity_function, material.viscosity->id),
                        *material.viscosity);
    }
  }
  std::optional<LawAtRest> spring, viscosity;
};

using Vectors = Eigen::Matrix<double, 3, Eigen::Dynamic>;

// Products with K and D in coordinates scaled by the roots of the masses, where M^-1 K becomes symmetric.
class ScaledOperators {
 public:
  ScaledOperators(const Network& network, const std::vector<LinearSpring>& springs)
      : network_(network), springs_(springs), roots_(network.nodes().size()), directions_(3, springs.size()) {
    for (std::size_t k = 0; k < roots_.size(); ++k) {
      const Node& node = network.nodes()[k];
      roots_[k] = node.fixed ? 0.0 : 1.0 / std::sqrt(node.mass);
    }
    for (std::size_t s = 0; s < springs.size(); ++s) {
      const Spring& spring = network.springs()[s];
      const Vector3 difference = network.nodes()[spring.first].position - network.nodes()[spring.second].position;
      directions_.col(static_cast<Eigen::Index>(s)) =
          springs[s].length > 0.0 ? Vector3(difference / springs[s].length) : Vector3::Zero();
    }
  }

  // elastic = K x, viscous = D x.
  void multiply(const Vectors& x, Vectors& elastic, Vectors& viscous) const {
    elastic.setZero(3, x.cols());
    viscous.setZero(3, x.cols());
    for (std::size_t s = 0; s < springs_.size(); ++s) {
      const LinearSpring& law = springs_[s];
      const Spring& ends = network_.springs()[s];
      const double root_first = roots_[ends.first], root_second = roots_[ends.second];
      const Vector3 n = directions_.col(static_cast<Eigen::Index>(s));
      const Vector3 difference = root_first * x.col(ends.first) - root_second * x.col(ends.second);
      const Vector3 along = n * n.dot(difference);
      const double across_stiffness = law.length > 0.0 ? law.tension / law.length : 0.0;
      const Vector3 by_position = law.stiffness * along + across_stiffness * (difference - along);
      const Vector3 by_velocity = law.axial_damping * along + law.general_damping * difference;
      elastic.col(ends.first) += root_first * by_position;
      elastic.col(ends.second) -= root_second * by_position;
      viscous.col(ends.first) += root_first * by_velocity;
      viscous.col(ends.second) -= root_second * by_velocity;
    }
  }

 private:
  const Network& network_;
  const std::vector<LinearSpring>& springs_;
  std::vector<double> roots_;
  Vectors directions_;
};

// A vector with a part in every direction, the same on every machine.
Vectors start_vector(std::size_t nodes) {
  Vectors x(3, static_cast<Eigen::Index>(nodes));
  std::uint64_t state = 0x9e3779b97f4a7c15u;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    x.data()[k] = static_cast<double>(state >> 11) * 0x1p-53 - 0.5;
  }
  return x / x.norm();
}

// The positive root of |a t^2 + b t| = 1, where a and b are Rayleigh quotients of K and D.
std::optional<double> crossing(double a, double b) {
  if (a < 0.0) {  // the greatest eigenvalue in size is a negative one
    a = -a;
    b = -b;
  }
  const double root = std::sqrt(b * b + 4.0 * a);
  const double denominator = b + root;  // t = 2 / (b + sqrt(b^2 + 4 a)): exact for a = 0 as well
  if (!(denominator > 0.0)) return std::nullopt;
  return 2.0 / denominator;
}

}  // namespace

std::vector<LinearSpring> linearise(const Network& network, const PluginHost& plugins) {
  std::vector<MaterialAtRest> materials;
  materials.reserve(network.materials().size());
  for (const Material& material : network.materials()) materials.emplace_back(material, plugins);

  std::vector<LinearSpring> result;
  result.reserve(network.springs().size());
  for (const Spring& spring : network.springs()) {
    const double length = (network.nodes()[spring.first].position - network.nodes()[spring.second].position).norm();
    MaterialAtRest& material = materials[spring.material];
    LinearSpring linear{length, 0.0, 0.0, 0.0, 0.0};
    if (material.spring) {
      const LawAnswer answer = material.spring->answer(length, spring.rest_length);
      linear.tension += answer.force;
      linear.stiffness += answer.by_q;
      linear.axial_damping += answer.by_rate;
    }
    if (material.viscosity) {
      const LawAnswer answer = material.viscosity->answer(length, spring.rest_length);
      if (material.viscosity->reads_speed()) {
        linear.general_damping += answer.by_q;
      } else {
        linear.tension += answer.force;
        linear.stiffness += answer.by_q;
        linear.axial_damping += answer.by_rate;
      }
    }
    result.push_back(linear);
  }
  return result;
}

std::optional<double> synchronous_limit(const Network& network, const std::vector<LinearSpring>& springs) {
  const auto finite = [](const LinearSpring& s) {
    return std::isfinite(s.tension) && std::isfinite(s.stiffness) && std::isfinite(s.axial_damping) &&
           std::isfinite(s.general_damping);
  };
  const auto mass_point = [&](const Node& node) {
    return node.fixed || network.neurons()[node.neuron].id == "point_mass";
  };
  if (springs.empty() || !std::all_of(springs.begin(), springs.end(), finite) ||
      !std::all_of(network.nodes().begin(), network.nodes().end(), mass_point)) {
    return std::nullopt;
  }

  const ScaledOperators operators(network, springs);
  Vectors x = start_vector(network.nodes().size());
  Vectors elastic, viscous;
  double limit = 0.0;  // 0: not known yet
  double weight = 1.0;
  // Some seconds at most: sixty products tell the estimate of a net of millions of springs to a few per cent.
  const int largest_count = static_cast<int>(std::clamp(2e8 / static_cast<double>(springs.size()), 60.0, 5000.0));
  for (int count = 0; count < largest_count; ++count) {
    // Power iteration with t^2 K + t D at the newest estimate of t; the quotients are accurate to the square of x's
    // error.
    operators.multiply(x, elastic, viscous);
    const double a = x.cwiseProduct(elastic).sum(), b = x.cwiseProduct(viscous).sum();
    const std::optional<double> next = crossing(a, b);
    if (next) {
      const double change = std::abs(*next - limit);
      limit = *next;
      // Slow changes add up: with a gap of 1 % between eigenvalues, what is left is about a hundred times the change.
      if (count > 10 && change <= 3e-6 * limit) return limit;
      weight = limit;
    }
    x = weight * weight * elastic + weight * viscous;
    const double norm = x.norm();
    if (!(norm > 0.0) || !std::isfinite(norm)) return std::nullopt;
    x /= norm;
  }
  return limit > 0.0 ? std::optional(limit) : std::nullopt;
}

}  // namespace springnet
