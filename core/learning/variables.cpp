#include "learning/variables.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/field.hpp"

namespace springnet::learning {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr int greatest_degree = 20;  // of fields: higher ones are no smooth fields

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
    case Kind::friction:
      return {0.0, infinite, true};
    case Kind::initial_velocity:
    case Kind::load:
    case Kind::gravity:
      break;
  }
  return {};
}

[[nodiscard]] bool has_place(Kind kind) {
  return kind != Kind::load && kind != Kind::gravity && kind != Kind::friction;
}

}  // namespace

std::vector<LearnedValues> values_of(const std::vector<Learnable>& learnables) {
  std::vector<LearnedValues> result;
  for (const Learnable& each : learnables) result.push_back(each.values);
  return result;
}

// Adds the links of values that have variables in common.
class Variables::Builder {
 public:
  Builder(const Network& network, const PluginHost& plugins, const VectorXd& start, std::vector<Link>& links)
      : network_(network), plugins_(plugins), start_(start), links_(links) {}

  void add(const Learnable& what) {
    const bool is_velocity = what.values.kind == Kind::initial_velocity;
    const std::size_t first = links_.size(), axes = is_velocity ? 3 : 1, count = what.values.members.size();
    links_.resize(first + axes * count);
    for (std::size_t i = 0; i < axes * count; ++i) set_bounds(what, what.values.members[i / axes], first + i);
    set_widths(what, axes * count);
    if (count == 0) return;
    const bool is_field = what.field_degree >= 0;
    if (what.together && is_velocity)
      throw Error(ErrorKind::input, "learning: initial velocities are learned each by itself, or as a field");
    if (is_field && !has_place(what.values.kind))
      throw Error(ErrorKind::input,
                  "learning: loads, gravity and friction are at no place of their own, and no field; "
                  "learn each by itself");
    if (what.together && is_field)
      throw Error(ErrorKind::input, "learning: values are learned together, or as a field, not both");
    if (!is_field && !what.together) {
      for (std::size_t i = 0; i < axes * count; ++i) join({first + i}, MatrixXd::Ones(1, 1), false);
      return;
    }
    const MatrixXd basis = is_field ? basis_of(what) : MatrixXd::Ones(static_cast<Eigen::Index>(count), 1);
    for (std::size_t axis = 0; axis < axes; ++axis) {
      std::vector<std::size_t> values;
      for (std::size_t i = 0; i < count; ++i) values.push_back(first + axes * i + axis);
      join(values, basis, is_field);
    }
  }

  std::vector<Eigen::Triplet<double>> entries;  // of the combinations
  std::vector<double> at_start, lower, upper, scale;
  std::vector<bool> is_logarithmic;

 private:
  [[nodiscard]] double own(std::size_t value) const { return start_[static_cast<Eigen::Index>(value)]; }

  void set_bounds(const Learnable& what, std::uint32_t member, std::size_t value) {
    const Bounds bounds = bounds_of(network_, plugins_, what.values, member);
    Link& link = links_[value];
    link = {0, 1, 1.0, 0.0, false, std::max(bounds.lower, what.lower), std::min(bounds.upper, what.upper)};
    if (what.values.kind == Kind::friction && own(value) == 0.0)
      throw Error(
          ErrorKind::input,
          fmt::format("learning: the friction of surface {} starts at 0, from where its size is not found; begin "
                      "above it, as with 0.1",
                      member));
    if (!(own(value) >= link.lower && own(value) <= link.upper))
      throw Error(ErrorKind::input,
                  fmt::format("learning: the search starts at {:g}, which is not within {:g} and {:g}; "
                              "give the network another value, or other bounds",
                              own(value), link.lower, link.upper));
    link.is_logarithmic = (bounds.excludes_lower || what.by_logarithm) && link.lower >= 0.0 && own(value) > 0.0;
  }

  void set_widths(const Learnable& what, std::size_t count) {
    if (!what.guess_widths.empty() && what.guess_widths.size() != count)
      throw Error(ErrorKind::input, fmt::format("learning: {} values have {} widths of the guess; give each its own",
                                                count, what.guess_widths.size()));
    for (const double each : what.guess_widths)
      if (!(each >= 0.0 && std::isfinite(each)))
        throw Error(ErrorKind::input, fmt::format("learning: a guess has the width {}, must be 0 or above", each));
    widths_.insert(widths_.end(), what.guess_widths.begin(), what.guess_widths.end());
    widths_.resize(links_.size(), 0.0);
  }

  // Of a variable, from those of the values that it drives: what these are known by adds up. 1: nothing is known.
  [[nodiscard]] double width_of(const std::vector<std::size_t>& values, const VectorXd& basis) const {
    double known = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (const double own = widths_[values[i]]; own > 0.0) known += basis[static_cast<Eigen::Index>(i)] / (own * own);
    return known > 0.0 ? 1.0 / std::sqrt(known) : 1.0;
  }

  [[nodiscard]] MatrixXd basis_of(const Learnable& what) const {
    if (what.field_degree > greatest_degree)
      throw Error(ErrorKind::input, fmt::format("learning: the degree of a field is {}, must be at most {}",
                                                what.field_degree, greatest_degree));
    MatrixXd basis = bernstein_basis(places_of(network_, what.values), what.field_degree);
    if (basis.cols() > basis.rows())
      throw Error(ErrorKind::input,
                  fmt::format("learning: a field of degree {} has {} coefficients for {} values; give a lower degree, "
                              "or learn each value by itself",
                              what.field_degree, basis.cols(), basis.rows()));
    return basis;
  }

  // basis: [value][variable] with rows that are not negative and have the sum 1, so that bounds of all values hold if
  // each variable is within them.
  void join(const std::vector<std::size_t>& values, const MatrixXd& basis, bool is_field) {
    const double reference = own(values.front());
    double greatest = 0.0;
    bool same_sign = true, any_zero = false, all_zero = true, logarithmic = true;
    for (const std::size_t value : values) {
      greatest = std::max(greatest, std::abs(own(value)));
      same_sign = same_sign && own(value) * reference > 0.0;
      any_zero = any_zero || own(value) == 0.0;
      all_zero = all_zero && own(value) == 0.0;
      logarithmic = logarithmic && links_[value].is_logarithmic;
    }
    if (!is_field && any_zero && !all_zero)
      throw Error(ErrorKind::input, "learning: values that are learned together start at 0, all or none");
    const bool is_added = is_field && !same_sign;
    double low = -infinite, high = infinite;
    for (const std::size_t value : values) {
      Link& link = links_[value];
      link.variable = at_start.size();
      link.variables = static_cast<std::size_t>(basis.cols());
      link.is_logarithmic = logarithmic;
      link.factor = is_added || all_zero ? 1.0 : own(value) / reference;
      link.offset = is_added ? own(value) : 0.0;
      // Searched by its logarithm, a value never reaches 0.
      const auto to_variable = [&](double of) {
        const double plain = (of - link.offset) / link.factor;
        if (!logarithmic) return plain;
        return plain > 0.0 ? std::log(plain) : -infinite;
      };
      low = std::max(low, to_variable(link.factor < 0.0 ? link.upper : link.lower));
      high = std::min(high, to_variable(link.factor < 0.0 ? link.lower : link.upper));
    }
    const double start = is_added ? 0.0 : logarithmic ? std::log(reference) : reference;
    for (Eigen::Index i = 0; i < basis.rows(); ++i)
      for (Eigen::Index k = 0; k < basis.cols(); ++k)
        if (basis(i, k) != 0.0)
          entries.emplace_back(static_cast<int>(values[static_cast<std::size_t>(i)]),
                               static_cast<int>(at_start.size()) + static_cast<int>(k), basis(i, k));
    for (Eigen::Index k = 0; k < basis.cols(); ++k) {
      at_start.push_back(start);
      is_logarithmic.push_back(logarithmic);
      lower.push_back(low);
      upper.push_back(high);
      const double unit = logarithmic || greatest == 0.0 ? 1.0 : is_added ? greatest : std::abs(reference);
      scale.push_back(unit * width_of(values, basis.col(k)));
    }
  }

  const Network& network_;
  const PluginHost& plugins_;
  const VectorXd& start_;
  std::vector<Link>& links_;
  std::vector<double> widths_;  // [value] of guesses; 0: not known
};

Variables::Variables(const Network& network, const PluginHost& plugins, const std::vector<Learnable>& learnables,
                     const VectorXd& start) {
  Builder builder(network, plugins, start, links_);
  for (const Learnable& each : learnables) builder.add(each);
  const auto vector_of = [](const std::vector<double>& of) {
    return VectorXd(Eigen::Map<const VectorXd>(of.data(), static_cast<Eigen::Index>(of.size())));
  };
  start_ = vector_of(builder.at_start);
  is_logarithmic_ = std::move(builder.is_logarithmic);
  lower_ = vector_of(builder.lower);
  upper_ = vector_of(builder.upper);
  scale_ = vector_of(builder.scale);
  combinations_.resize(static_cast<Eigen::Index>(links_.size()), count());
  combinations_.setFromTriplets(builder.entries.begin(), builder.entries.end());
}

double Variables::value_of(const Link& link, double combination) {
  const double plain = link.is_logarithmic ? std::exp(combination) : combination;
  return std::clamp(link.offset + link.factor * plain, link.lower, link.upper);
}

VectorXd Variables::weights_of(std::size_t value) const {
  const Link& link = links_[value];
  VectorXd result = VectorXd::Zero(static_cast<Eigen::Index>(link.variables));
  using Entry = Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator;
  for (Entry entry(combinations_, static_cast<Eigen::Index>(value)); entry; ++entry)
    result[entry.col() - static_cast<Eigen::Index>(link.variable)] = entry.value();
  return result;
}

VectorXd Variables::values(const VectorXd& x) const {
  VectorXd result = combinations_ * x;
  for (std::size_t k = 0; k < links_.size(); ++k) {
    double& own = result[static_cast<Eigen::Index>(k)];
    own = value_of(links_[k], own);
  }
  return result;
}

double Variables::value_at(std::size_t value, const VectorXd& x, double shift) const {
  return value_of(links_[value], combinations_.row(static_cast<Eigen::Index>(value)).dot(x) + shift);
}

double Variables::slope(std::size_t value, const VectorXd& x) const {
  const Link& link = links_[value];
  return link.is_logarithmic ? value_at(value, x, 0.0) : link.factor;
}

VectorXd Variables::slopes(const VectorXd& x) const {
  VectorXd result(static_cast<Eigen::Index>(links_.size()));
  for (std::size_t k = 0; k < links_.size(); ++k) result[static_cast<Eigen::Index>(k)] = slope(k, x);
  return result;
}

MatrixXd Variables::times(const VectorXd& x, const MatrixXd& changes) const {
  const MatrixXd combined = combinations_ * changes;
  return slopes(x).asDiagonal() * combined;
}

VectorXd Variables::transposed_times(const VectorXd& x, const VectorXd& gradient) const {
  return combinations_.transpose() * slopes(x).cwiseProduct(gradient);
}

}  // namespace springnet::learning
