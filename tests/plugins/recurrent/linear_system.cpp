// The linear systems of Newton's method, with a host whose derivatives are dense matrices: factorised and iterated,
// with and without constraints, against the same system solved by Eigen.
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <Eigen/Dense>

#include "linear_system.hpp"
#include "matrix_free.hpp"

using namespace springnet;
using recurrent::LinearSystem;

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

// A chain of nodes in space, node to node and to the second next, with da/dp = -M^-1 K and da/dv = -M^-1 D; some
// connections between nodes are rigid.
struct DenseHost {
  std::size_t n;
  std::vector<double> mass;
  Matrix by_position, by_velocity;  // [3 n][3 n], x of all nodes first
  Matrix rows;                      // G, [constraint][3 n]
  springnet_network net{};
  springnet_message text{};
  springnet_host table{};
  springnet_status status = SPRINGNET_OK;  // that every call returns
  int linearised = 0, factorised = 0, products = 0;
  Eigen::FullPivLU<Matrix> factors;

  DenseHost(std::size_t nodes, double stiffness, double damping, int constraints) : n(nodes) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    const auto size = static_cast<Eigen::Index>(3 * n);
    Matrix k = Matrix::Zero(size, size), d = k;
    rows = Matrix::Zero(constraints, size);
    for (std::size_t i = 0; i < n; ++i) mass.push_back(1.0 + 0.5 * number(random));
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = a + 1; b < std::min(a + 3, n); ++b) {
        const Eigen::Vector3d direction = Eigen::Vector3d(1.0, 0.5 * number(random), 0.5 * number(random)).normalized();
        Vector along = Vector::Zero(size);
        for (Eigen::Index c = 0; c < 3; ++c) {
          along[c * size / 3 + static_cast<Eigen::Index>(a)] = direction[c];
          along[c * size / 3 + static_cast<Eigen::Index>(b)] = -direction[c];
        }
        k += stiffness * (1.0 + 0.5 * number(random)) * along * along.transpose();
        d += damping * (1.0 + 0.5 * number(random)) * along * along.transpose();
        if (b == a + 1 && static_cast<int>(a) % 3 == 0 && static_cast<int>(a) / 3 < constraints)
          rows.row(static_cast<Eigen::Index>(a / 3)) = along.transpose();
      }
    }
    by_position = -mobility() * k;
    by_velocity = -mobility() * d;
    net.struct_size = sizeof net;
    net.node_count = static_cast<std::uint32_t>(n);
    net.mass = mass.data();
    net.rigid_count = static_cast<std::uint32_t>(constraints);
    std::strcpy(text.text, "the host is tired");
    table.struct_size = sizeof table;
    table.context = this;
    table.message = [](void* c) { return &of(c).text; };
    table.report = [](void*, const char*, double) {};
    table.linearise = [](void* c, const springnet_evaluation*) {
      ++of(c).linearised;
      return of(c).status;
    };
    table.jacobian_times = [](void* c, const double* dp, const double* dv, double* out) {
      DenseHost& self = of(c);
      ++self.products;
      const auto entries = static_cast<Eigen::Index>(3 * self.n);
      Eigen::Map<Vector>(out, entries) = self.by_position * Eigen::Map<const Vector>(dp, entries) +
                                         self.by_velocity * Eigen::Map<const Vector>(dv, entries);
      return self.status;
    };
    table.diagonal_blocks = [](void* c, double v, double p, double* out) {
      DenseHost& self = of(c);
      const Matrix whole = self.system(v, p);
      for (std::size_t node = 0; node < self.n; ++node)
        for (std::size_t r = 0; r < 3; ++r)
          for (std::size_t col = 0; col < 3; ++col)
            out[9 * node + 3 * r + col] =
                whole(static_cast<Eigen::Index>(r * self.n + node), static_cast<Eigen::Index>(col * self.n + node));
      return self.status;
    };
    table.factorise = [](void* c, double v, double p) {
      DenseHost& self = of(c);
      ++self.factorised;
      self.factors.compute(self.bordered(self.system(v, p)));
      return self.status;
    };
    table.solve = [](void* c, std::int32_t, const double* b, double* x) {
      DenseHost& self = of(c);
      const auto entries = static_cast<Eigen::Index>(3 * self.n);
      Vector right = Vector::Zero(entries + self.rows.rows());
      right.head(entries) = Eigen::Map<const Vector>(b, entries);
      Eigen::Map<Vector>(x, entries) = self.factors.solve(right).head(entries);
      return self.status;
    };
    table.project = [](void* c, const double* blocks, double* values) {
      DenseHost& self = of(c);
      Matrix w = self.mobility();
      for (std::size_t node = 0; blocks != nullptr && node < self.n; ++node)
        for (std::size_t r = 0; r < 3; ++r)
          for (std::size_t col = 0; col < 3; ++col)
            w(static_cast<Eigen::Index>(r * self.n + node), static_cast<Eigen::Index>(col * self.n + node)) =
                blocks[9 * node + 3 * r + col];
      Eigen::Map<Vector> value(values, static_cast<Eigen::Index>(3 * self.n));
      const Matrix moved = w * self.rows.transpose();
      value -= moved * (self.rows * moved).ldlt().solve(self.rows * Vector(value));
      return self.status;
    };
  }
  DenseHost(const DenseHost&) = delete;
  DenseHost& operator=(const DenseHost&) = delete;

  static DenseHost& of(void* context) { return *static_cast<DenseHost*>(context); }
  [[nodiscard]] Matrix mobility() const {
    Vector inverse(static_cast<Eigen::Index>(3 * n));
    for (std::size_t i = 0; i < 3 * n; ++i) inverse[static_cast<Eigen::Index>(i)] = 1.0 / mass[i % n];
    return inverse.asDiagonal();
  }
  [[nodiscard]] Matrix system(double velocity_weight, double position_weight) const {
    const Matrix one = Matrix::Identity(by_position.rows(), by_position.cols());
    return one - velocity_weight * by_velocity - position_weight * by_position;
  }
  // [A, M^-1 G^T; G, 0]
  [[nodiscard]] Matrix bordered(const Matrix& a) const {
    const Eigen::Index size = a.rows(), more = rows.rows();
    Matrix all = Matrix::Zero(size + more, size + more);
    all.topLeftCorner(size, size) = a;
    all.topRightCorner(size, more) = mobility() * rows.transpose();
    all.bottomLeftCorner(more, size) = rows;
    return all;
  }
  // (I - w da/dv - w^2 da/dp + shift) x = b, G x = 0.
  [[nodiscard]] Vector expected(double w, double shift, const std::vector<double>& b) const {
    const auto size = static_cast<Eigen::Index>(3 * n);
    Matrix a = system(w, w * w);
    a.diagonal().array() += shift;
    Vector right = Vector::Zero(size + rows.rows());
    right.head(size) = Eigen::Map<const Vector>(b.data(), size);
    return bordered(a).fullPivLu().solve(right).head(size);
  }
  // In the space that constraints allow.
  [[nodiscard]] std::vector<double> right_side() {
    std::vector<double> b(3 * n);
    for (std::size_t i = 0; i < b.size(); ++i) b[i] = std::sin(1.0 + 0.7 * static_cast<double>(i * i % 31));
    if (rows.rows() > 0) table.project(this, nullptr, b.data());
    return b;
  }
};

Vector as_vector(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

TEST_CASE("small systems are factorised, larger ones iterated, to the solution that Eigen has") {
  constexpr double w = 0.05;
  for (const int constraints : {0, 4}) {
    for (const std::size_t nodes : {12u, 60u}) {
      CAPTURE(constraints);
      CAPTURE(nodes);
      DenseHost host(nodes, 400.0, 10.0, constraints);
      LinearSystem system{sdk::Host(host.table)};
      system.attach(host.net);
      system.linearise(sdk::sized<springnet_evaluation>());
      const std::vector<double> b = host.right_side();
      // A shift as large as those that shorten steps.
      for (const double shift : {0.0, 1.0, 100.0}) {
        CAPTURE(shift);
        std::vector<double> x(b.size());
        REQUIRE(system.solve(w, shift, b, 1e-12, x));
        const Vector expected = host.expected(w, shift, b);
        // The accuracy is relative to b, and no eigenvalue is below 1 + shift; masses differ by a factor of three.
        CHECK((as_vector(x) - expected).norm() <= 1e-10 * expected.norm());
        CHECK((host.rows * as_vector(x)).norm() <= 1e-10 * expected.norm());
      }
      CHECK((host.factorised > 0) == (nodes <= 32));
    }
  }
}

TEST_CASE("factors are kept while derivatives and weights stay") {
  DenseHost host(8, 100.0, 1.0, 0);
  LinearSystem system{sdk::Host(host.table)};
  system.attach(host.net);
  const auto at = sdk::sized<springnet_evaluation>();
  const std::vector<double> b = host.right_side();
  std::vector<double> x(b.size());
  const auto solve = [&](double w, double shift) { CHECK(system.solve(w, shift, b, 1e-10, x)); };
  system.linearise(at);
  solve(0.1, 0.0);
  solve(0.1, 0.0);
  CHECK(host.factorised == 1);
  solve(0.2, 0.0);
  CHECK(host.factorised == 2);
  solve(0.2, 1.0);
  CHECK(host.factorised == 3);
  system.linearise(at);
  host.by_position *= 2.0;
  solve(0.2, 1.0);
  CHECK(host.factorised == 4);
  CHECK((as_vector(x) - host.expected(0.2, 1.0, b)).norm() <= 1e-12);
}

TEST_CASE("a system that iterations do not solve is factorised") {
  // Far more stiffness than mass along a chain: each iteration carries information one node further.
  DenseHost host(150, 1e10, 0.0, 0);
  LinearSystem system{sdk::Host(host.table)};
  system.attach(host.net);
  system.linearise(sdk::sized<springnet_evaluation>());
  const std::vector<double> b = host.right_side();
  std::vector<double> x(b.size());
  REQUIRE(system.solve(1.0, 0.0, b, 1e-10, x));
  CHECK(host.factorised == 1);
  // The condition is 1e11 or so.
  CHECK((as_vector(x) - host.expected(1.0, 0.0, b)).norm() <= 1e-3 * as_vector(b).norm());
}

TEST_CASE("a recoverable failure of the host gives no solution, another one throws") {
  DenseHost host(5, 10.0, 1.0, 0);
  LinearSystem system{sdk::Host(host.table)};
  system.attach(host.net);
  system.linearise(sdk::sized<springnet_evaluation>());
  const std::vector<double> b = host.right_side();
  std::vector<double> x(b.size());
  host.status = SPRINGNET_RECOVERABLE;
  CHECK_FALSE(system.solve(0.1, 0.0, b, 1e-10, x));
  host.status = SPRINGNET_FAILED;
  CHECK_THROWS_AS(static_cast<void>(system.solve(0.1, 0.0, b, 1e-10, x)), sdk::Failure);
  host.status = SPRINGNET_OK;
  CHECK(system.solve(0.1, 0.0, b, 1e-10, x));  // no state of the failure is kept
  CHECK((as_vector(x) - host.expected(0.1, 0.0, b)).norm() <= 1e-12);
}

TEST_CASE("projection removes what constraints do not allow, and nothing without constraints") {
  for (const int constraints : {0, 3}) {
    DenseHost host(10, 1.0, 1.0, constraints);
    LinearSystem system{sdk::Host(host.table)};
    system.attach(host.net);
    std::vector<double> values(30);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::cos(static_cast<double>(i));
    const std::vector<double> before = values;
    system.project(values);
    CHECK((values == before) == (constraints == 0));
    CHECK((host.rows * as_vector(values)).norm() <= 1e-14);
  }
}

TEST_CASE("a matrix known by its products multiplies and solves as the matrix") {
  Matrix dense = Matrix::Identity(12, 12);
  for (Eigen::Index i = 0; i < 12; ++i)
    for (Eigen::Index j = 0; j < 12; ++j) dense(i, j) += 0.3 * std::sin(static_cast<double>(3 * i + 5 * j));
  const recurrent::MatrixFree matrix(12, [&](const Vector& in, Vector& out) { out = dense * in; });
  CHECK(matrix.rows() == 12);
  CHECK(matrix.cols() == 12);
  const Vector x = Vector::LinSpaced(12, -1.0, 2.0);
  Vector y = Vector::Ones(12);
  y += matrix * x;
  CHECK((y - Vector::Ones(12) - dense * x).norm() <= 1e-14);
  recurrent::Action half;
  half.apply = [](const Vector& in, Vector& out) { out = 0.5 * in; };
  CHECK(half.solve(x) == Vector(0.5 * x));
}
