#include "learning/variables.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet::learning {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

constexpr double infinite = std::numeric_limits<double>::infinity();

struct Bounds {
  double lower = -infinite, upper = infinite;
  bool excludes_lower = false;
};

// As the law or neuron declares the parameter; null: it has none of this name, which setting it tells.
const springnet_parameter* declared(const Component& component, std::string_view name) {
  for (std::uint32_t k = 0; k < component.description->parameter_count; ++k)
    if (name == component.description->parameters[k]->name) return component.description->parameters[k];
  return nullptr;
}

Bounds bounds_of(const LawUse& use, ComponentKind kind, const PluginHost& plugins, const LearnedValues& what) {
  const std::shared_ptr<const Component> component = use.component ? use.component : plugins.require(kind, use.id);
  const springnet_parameter* const parameter = declared(*component, what.parameter);
  if (parameter == nullptr) return {};
  if ((parameter->flags & SPRINGNET_LEARNABLE) == 0)
    throw Error(ErrorKind::input,
                fmt::format("learning: '{}' does not declare its parameter '{}' learnable", use.id, what.parameter));
  return {parameter->smallest, parameter->largest, (parameter->flags & SPRINGNET_EXCLUDES_SMALLEST) != 0};
}

Bounds bounds_of(const Network& network, const PluginHost& plugins, const LearnedValues& what, std::uint32_t member) {
  switch (what.kind) {
    case Kind::spring_parameter:
    case Kind::viscosity_parameter: {
      const MaterialIndex material =
          what.of_elements ? network.elements()[member].material : network.springs()[member].material;
      const Material& both = network.materials()[material];
      const bool is_spring = what.kind == Kind::spring_parameter;
      const std::optional<LawUse>& use = is_spring ? both.spring : both.viscosity;
      if (!use) return {};
      return bounds_of(*use, is_spring ? ComponentKind::spring_function : ComponentKind::viscosity_function, plugins,
                       what);
    }
    case Kind::neuron_parameter:
      return bounds_of(network.neurons()[network.nodes()[member].neuron], ComponentKind::neuron, plugins, what);
    case Kind::rest_length:
      return what.of_elements ? Bounds{} : Bounds{0.0, infinite, true};
    case Kind::mass:
      return {0.0, infinite, true};
    case Kind::initial_velocity:
      break;
  }
  return {};
}

}  // namespace

std::vector<LearnedValues> values_of(const std::vector<Learnable>& learnables) {
  std::vector<LearnedValues> result;
  for (const Learnable& each : learnables) result.push_back(each.values);
  return result;
}

Variables::Variables(const Network& network, const PluginHost& plugins, const std::vector<Learnable>& learnables,
                     const VectorXd& start) {
  std::vector<double> first, lower, upper, scale;
  std::size_t value = 0;
  for (const Learnable& each : learnables) {
    const bool is_velocity = each.values.kind == Kind::initial_velocity;
    const std::size_t size = (is_velocity ? 3 : 1) * each.values.members.size();
    if (each.together && is_velocity)
      throw Error(ErrorKind::input, "learning: initial velocities are learned each by itself");
    const double reference = size > 0 ? start[static_cast<Eigen::Index>(value)] : 0.0;
    for (std::size_t i = 0; i < size; ++i, ++value) {
      const std::uint32_t member = each.values.members[is_velocity ? i / 3 : i];
      const Bounds bounds = bounds_of(network, plugins, each.values, member);
      const double own = start[static_cast<Eigen::Index>(value)];
      Link link{0, 1.0, false, std::max(bounds.lower, each.lower), std::min(bounds.upper, each.upper)};
      if (!(own >= link.lower && own <= link.upper))
        throw Error(ErrorKind::input,
                    fmt::format("learning: the search starts at {:g}, which is not within {:g} and {:g}; "
                                "give the network another value, or other bounds",
                                own, link.lower, link.upper));
      link.is_logarithmic = bounds.excludes_lower && link.lower >= 0.0 && own > 0.0;
      const bool joins = each.together && i > 0;
      if (joins && (own == 0.0) != (reference == 0.0))
        throw Error(ErrorKind::input, "learning: values that are learned together start at 0, all or none");
      link.factor = each.together && reference != 0.0 ? own / reference : 1.0;
      if (joins) link.is_logarithmic = links_.back().is_logarithmic;
      // Searched by its logarithm, a value never reaches 0.
      const auto to_variable = [&](double of) {
        const double plain = of / link.factor;
        if (!link.is_logarithmic) return plain;
        return plain > 0.0 ? std::log(plain) : -infinite;
      };
      const double low = to_variable(link.factor < 0.0 ? link.upper : link.lower);
      const double high = to_variable(link.factor < 0.0 ? link.lower : link.upper);
      if (joins) {
        lower.back() = std::max(lower.back(), low);
        upper.back() = std::min(upper.back(), high);
      } else {
        first.push_back(to_variable(own));
        lower.push_back(low);
        upper.push_back(high);
        is_logarithmic_.push_back(link.is_logarithmic);
        scale.push_back(link.is_logarithmic || own == 0.0 ? 1.0 : std::abs(own));
      }
      link.variable = first.size() - 1;
      links_.push_back(link);
    }
  }
  const auto vector_of = [](const std::vector<double>& of) {
    return VectorXd(Eigen::Map<const VectorXd>(of.data(), static_cast<Eigen::Index>(of.size())));
  };
  start_ = vector_of(first);
  lower_ = vector_of(lower);
  upper_ = vector_of(upper);
  scale_ = vector_of(scale);
}

double Variables::value_of(const Link& link, double x) {
  return std::clamp(link.factor * (link.is_logarithmic ? std::exp(x) : x), link.lower, link.upper);
}

VectorXd Variables::values(const VectorXd& x) const {
  VectorXd result(static_cast<Eigen::Index>(links_.size()));
  for (std::size_t k = 0; k < links_.size(); ++k) result[static_cast<Eigen::Index>(k)] = value_at(k, x, 0.0);
  return result;
}

double Variables::value_at(std::size_t value, const VectorXd& x, double shift) const {
  const Link& link = links_[value];
  return value_of(link, x[static_cast<Eigen::Index>(link.variable)] + shift);
}

double Variables::slope(std::size_t value, const VectorXd& x) const {
  const Link& link = links_[value];
  return link.is_logarithmic ? value_at(value, x, 0.0) : link.factor;
}

MatrixXd Variables::times(const VectorXd& x, const MatrixXd& changes) const {
  MatrixXd result(static_cast<Eigen::Index>(links_.size()), changes.cols());
  for (std::size_t k = 0; k < links_.size(); ++k)
    result.row(static_cast<Eigen::Index>(k)) = slope(k, x) * changes.row(static_cast<Eigen::Index>(links_[k].variable));
  return result;
}

VectorXd Variables::transposed_times(const VectorXd& x, const VectorXd& gradient) const {
  VectorXd result = VectorXd::Zero(count());
  for (std::size_t k = 0; k < links_.size(); ++k)
    result[static_cast<Eigen::Index>(links_[k].variable)] += slope(k, x) * gradient[static_cast<Eigen::Index>(k)];
  return result;
}

}  // namespace springnet::learning
