// Systems with terms of low rank, against the dense matrix in more digits.

#include <doctest/doctest.h>

#include "layers/linear/low_rank.hpp"

using namespace springnet::layers;

namespace {

using Extended = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

// A, not symmetric and well conditioned.
Eigen::MatrixXd matrix(Eigen::Index size) {
  Eigen::MatrixXd a = 0.1 * Eigen::MatrixXd::NullaryExpr(size, size, [](Eigen::Index i, Eigen::Index j) {
                        return std::sin(static_cast<double>(3 * i + 7 * j * j + 1));
                      });
  a.diagonal().array() += 2.0;
  return a;
}

LowRank::Solve solver(const Eigen::MatrixXd& a) {
  return [&a](bool transposed, const Eigen::MatrixXd& b) -> Eigen::MatrixXd {
    return transposed ? Eigen::MatrixXd(a.transpose().partialPivLu().solve(b))
                      : Eigen::MatrixXd(a.partialPivLu().solve(b));
  };
}

}  // namespace

TEST_CASE("terms of very different sizes all count, in the system and in its transpose") {
  const Eigen::Index size = 12;
  const Eigen::MatrixXd a = matrix(size);
  Eigen::MatrixXd u = matrix(size).rightCols(3), w = matrix(size).leftCols(3);
  for (Eigen::Index i = 0; i < 3; ++i) {  // stiff, ordinary, and soft
    u.col(i) *= std::pow(10.0, 8 - 8 * static_cast<double>(i));
    w.col(i) *= std::pow(10.0, 9 - 5 * static_cast<double>(i));
  }
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(size, -1.0, 2.0);
  LowRank terms;
  terms.set(u, w);
  CHECK_FALSE(terms.is_singular(solver(a)));
  for (const bool transposed : {false, true}) {
    CAPTURE(transposed);
    const Eigen::VectorXd x = terms.solve(transposed, b, solver(a));
    // A x + u c = b, c = w^T x: nothing is added to anything that is far greater.
    Extended whole = Extended::Identity(size + 3, size + 3), right = Extended::Zero(size + 3, 1);
    whole.topLeftCorner(size, size) = (transposed ? Eigen::MatrixXd(a.transpose()) : a).cast<long double>();
    whole.topRightCorner(size, 3) = (transposed ? w : u).cast<long double>();
    whole.bottomLeftCorner(3, size) = -(transposed ? u : w).transpose().cast<long double>();
    right.topRows(size) = b.cast<long double>();
    const Eigen::VectorXd expected = whole.fullPivLu().solve(right).topRows(size).cast<double>();
    // Rounding of the answers of A, with its condition of some ten.
    CHECK((x - expected).norm() <= 1e-12 * expected.norm());
    // Above all in the component of the soft term.
    const Eigen::VectorXd soft = transposed ? u.col(2) : w.col(2);
    CHECK(soft.dot(x) == doctest::Approx(soft.dot(expected)).epsilon(1e-9));
  }
}

TEST_CASE("a term that makes the matrix singular is detected") {
  const Eigen::Index size = 6;
  const Eigen::MatrixXd a = matrix(size);
  // A + u w^T has the kernel A^-1 u where w^T A^-1 u = -1.
  Eigen::MatrixXd u = Eigen::VectorXd::LinSpaced(size, 1.0, 2.0), w = Eigen::VectorXd::LinSpaced(size, -1.0, 3.0);
  w *= -1.0 / (w.transpose() * a.partialPivLu().solve(u))(0, 0);
  LowRank terms;
  terms.set(u, w);
  CHECK(terms.is_singular(solver(a)));
  terms.set(u, 0.999 * w);
  CHECK_FALSE(terms.is_singular(solver(a)));
}
