// A matrix given by its products and a preconditioner given by its action, for Eigen's iterative solvers.
#pragma once

#include <functional>
#include <utility>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace springnet::recurrent {
class MatrixFree;
}

template <>
struct Eigen::internal::traits<springnet::recurrent::MatrixFree>
    : public Eigen::internal::traits<Eigen::SparseMatrix<double>> {};

namespace springnet::recurrent {

using Product = std::function<void(const Eigen::VectorXd& in, Eigen::VectorXd& out)>;

class MatrixFree : public Eigen::EigenBase<MatrixFree> {
 public:
  using Scalar = double;
  using RealScalar = double;
  using StorageIndex = int;
  enum { ColsAtCompileTime = Eigen::Dynamic, MaxColsAtCompileTime = Eigen::Dynamic, IsRowMajor = false };

  MatrixFree(Eigen::Index size, Product product) : size_(size), product_(std::move(product)) {}
  [[nodiscard]] Eigen::Index rows() const noexcept { return size_; }
  [[nodiscard]] Eigen::Index cols() const noexcept { return size_; }
  void multiply(const Eigen::VectorXd& in, Eigen::VectorXd& out) const { product_(in, out); }

  template <class Right>
  Eigen::Product<MatrixFree, Right, Eigen::AliasFreeProduct> operator*(const Eigen::MatrixBase<Right>& right) const {
    return {*this, right.derived()};
  }

 private:
  Eigen::Index size_;
  Product product_;
};

struct Action {
  Product apply;
  template <class Matrix>
  Action& compute(const Matrix&) noexcept {
    return *this;
  }
  template <class Matrix>
  Action& analyzePattern(const Matrix&) noexcept {  // NOLINT(readability-identifier-naming): Eigen calls it so
    return *this;
  }
  template <class Matrix>
  Action& factorize(const Matrix&) noexcept {
    return *this;
  }
  template <class Right>
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::MatrixBase<Right>& right) const {
    Eigen::VectorXd result(right.size());
    apply(right, result);
    return result;
  }
  [[nodiscard]] Eigen::ComputationInfo info() const noexcept { return Eigen::Success; }
};

}  // namespace springnet::recurrent

template <class Right>
struct Eigen::internal::generic_product_impl<springnet::recurrent::MatrixFree, Right, Eigen::SparseShape,
                                             Eigen::DenseShape, Eigen::GemvProduct>
    : Eigen::internal::generic_product_impl_base<
          springnet::recurrent::MatrixFree, Right,
          Eigen::internal::generic_product_impl<springnet::recurrent::MatrixFree, Right>> {
  template <class Result>
  // NOLINTNEXTLINE(readability-identifier-naming): Eigen calls it so
  static void scaleAndAddTo(Result& result, const springnet::recurrent::MatrixFree& left, const Right& right,
                            const double& factor) {
    Eigen::VectorXd product(right.size());
    left.multiply(right, product);
    result += factor * product;
  }
};
