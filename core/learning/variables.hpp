// Variables of a search for values. Each value follows a combination of them, by itself or by its exponential: one
// variable for each value, or for several together, or the coefficients of a field.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <springnet/learn.hpp>

namespace springnet::learning {

[[nodiscard]] std::vector<LearnedValues> values_of(const std::vector<Learnable>& learnables);
[[nodiscard]] inline std::size_t value_count(const Learnable& learnable) {
  const bool is_vector = learnable.values.kind == LearnedValues::Kind::initial_velocity;
  return (is_vector ? 3 : 1) * learnable.values.members.size();
}

class Variables {
 public:
  // start: the values of the network. Throws Error(input) for parameters that are not declared learnable, for bounds
  // that exclude the start, and for fields with more coefficients than values.
  Variables(const Network& network, const PluginHost& plugins, const std::vector<Learnable>& learnables,
            const Eigen::VectorXd& start);

  [[nodiscard]] Eigen::Index count() const noexcept { return start_.size(); }
  [[nodiscard]] const Eigen::VectorXd& start() const noexcept { return start_; }
  [[nodiscard]] const Eigen::VectorXd& lower() const noexcept { return lower_; }
  [[nodiscard]] const Eigen::VectorXd& upper() const noexcept { return upper_; }
  // Changes of variables that count as the same: 1 of a logarithm, else the size of the value at the start, times the
  // width of the guess where it is known.
  [[nodiscard]] const Eigen::VectorXd& scale() const noexcept { return scale_; }
  // Searched by the logarithm of its values.
  [[nodiscard]] bool is_logarithmic(Eigen::Index variable) const {
    return is_logarithmic_[static_cast<std::size_t>(variable)];
  }
  // The first of the variables that drive a value, one after another, and the weights of their combination.
  [[nodiscard]] std::size_t variable_of(std::size_t value) const noexcept { return links_[value].variable; }
  [[nodiscard]] Eigen::VectorXd weights_of(std::size_t value) const;

  // Within the bounds of the values, whatever rounding an exponential adds.
  [[nodiscard]] Eigen::VectorXd values(const Eigen::VectorXd& x) const;
  // d(value)/d(combination) at x.
  [[nodiscard]] double slope(std::size_t value, const Eigen::VectorXd& x) const;
  // Changes of the values for those of the variables, a column each; and the transpose.
  [[nodiscard]] Eigen::MatrixXd times(const Eigen::VectorXd& x, const Eigen::MatrixXd& changes) const;
  [[nodiscard]] Eigen::VectorXd transposed_times(const Eigen::VectorXd& x, const Eigen::VectorXd& gradient) const;
  // The value for a combination that is shifted from that at x.
  [[nodiscard]] double value_at(std::size_t value, const Eigen::VectorXd& x, double shift) const;

 private:
  // value = offset + factor times the combination, or its exponential.
  struct Link {
    std::size_t variable, variables;
    double factor, offset;
    bool is_logarithmic;
    double lower, upper;  // of the value
  };
  class Builder;
  [[nodiscard]] static double value_of(const Link& link, double combination);
  [[nodiscard]] Eigen::VectorXd slopes(const Eigen::VectorXd& x) const;

  std::vector<Link> links_;                                    // [value]
  Eigen::SparseMatrix<double, Eigen::RowMajor> combinations_;  // [value][variable]
  std::vector<bool> is_logarithmic_;                           // [variable]
  Eigen::VectorXd start_, lower_, upper_, scale_;
};

}  // namespace springnet::learning
