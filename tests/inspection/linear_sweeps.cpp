// Host functions with which integrators find their limits, against dense matrices: sweeps of the linearised network,
// and the dominant eigenvalue.
#include <cmath>
#include <complex>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/LU>
#include <springnet/sdk/limits.hpp>

#include "../elements/bodies.hpp"
#include "eigenvalues.hpp"
#include "simulation/limit_survey.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// w^2 da/dp + w da/dv.
Eigen::MatrixXd matrix_of(const sdk::Host& host, double w) {
  const auto size = static_cast<Eigen::Index>(3 * host.network().node_count);
  Eigen::MatrixXd result(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::VectorXd p = w * w * Eigen::VectorXd::Unit(size, j), v = w * Eigen::VectorXd::Unit(size, j);
    host.jacobian_times(p.data(), v.data(), result.col(j).data());
  }
  return result;
}

struct Swept {
  std::unique_ptr<LimitSurvey> survey;
  sdk::Host host;
  explicit Swept(const Network& net) : survey(std::make_unique<LimitSurvey>(net, *plugins())), host(survey->table()) {
    const auto [time, state] = host.committed();
    host.begin_interval(time, time + 1.0);
    host.linearise(sdk::evaluation_at(time, state));
  }
  // One sweep in the engine's order, u_k <- w a_k, on u ([3n]); nodes of blocks solve their own 3x3 problem.
  void sweep(double w, bool blocks, std::vector<double>& u) const {
    const std::uint32_t n = host.network().node_count;
    std::vector<double> p(3 * n), inertia(9 * n);
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    auto call = sdk::sized<springnet_sweep>();
    call.order = order.data();
    call.order_count = n;
    call.time_constant = w;
    call.next_velocity = {u.data(), u.data() + n, u.data() + 2 * n};
    call.next_position = {p.data(), p.data() + n, p.data() + 2 * n};
    call.velocity = sdk::view(call.next_velocity);
    call.position = sdk::view(call.next_position);
    call.want_blocks = blocks ? 1 : 0;
    host.linear_sweep(call, [&](const springnet_node_batch& batch) {
      REQUIRE(batch.count == 1);
      const std::uint32_t k = batch.first;
      const Vector3 a(batch.acceleration.x[0], batch.acceleration.y[0], batch.acceleration.z[0]);
      Vector3 next = w * a;
      if (blocks) {
        using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
        const Eigen::Map<const Block> by_v(batch.acceleration_by_velocity), by_p(batch.acceleration_by_position);
        const Vector3 old(u[k], u[n + k], u[2 * n + k]);
        const Block own = w * by_v + w * w * by_p;
        next = (Block::Identity() - own).inverse() * (w * a - own * old);
      }
      for (std::uint32_t c = 0; c < 3; ++c) u[c * n + k] = next[c];
    });
  }
};

std::vector<double> shaken(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<double> u(size);
  for (double& value : u) value = static_cast<double>(random()) * 0x1p-32 - 0.5;
  return u;
}

}  // namespace

TEST_CASE(
    "a linear sweep applies the rows of the matrix one after another, with every kind of element, with blocks too") {
  Network net = all_kinds(6, false);
  net.fix(2);
  const Swept swept(net);
  const std::size_t n = net.nodes().size();
  constexpr double w = 0.07;
  const Eigen::MatrixXd matrix = matrix_of(swept.host, w);
  for (const bool blocks : {false, true}) {
    std::vector<double> u = shaken(3 * n, 5);
    const std::uint8_t* fixed = swept.host.network().fixed;
    for (std::size_t i = 0; i < 3 * n; ++i)
      if (fixed[i % n] != 0) u[i] = 0.0;
    Eigen::VectorXd expected = Eigen::Map<const Eigen::VectorXd>(u.data(), static_cast<Eigen::Index>(3 * n));
    for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(n); ++k) {
      if (fixed[k] != 0) continue;
      const auto at = [&](Eigen::Index c) { return c * static_cast<Eigen::Index>(n) + k; };
      Vector3 next;
      Eigen::Matrix3d own;
      for (Eigen::Index c = 0; c < 3; ++c) {
        next[c] = matrix.row(at(c)).dot(expected);
        for (Eigen::Index d = 0; d < 3; ++d) own(c, d) = matrix(at(c), at(d));
      }
      const Vector3 old(expected[at(0)], expected[at(1)], expected[at(2)]);
      if (blocks) next = (Eigen::Matrix3d::Identity() - own).inverse() * (next - own * old);
      for (Eigen::Index c = 0; c < 3; ++c) expected[at(c)] = next[c];
    }
    swept.sweep(w, blocks, u);
    const Eigen::Map<const Eigen::VectorXd> found(u.data(), static_cast<Eigen::Index>(3 * n));
    CHECK((found - expected).norm() <= 1e-12 * expected.norm());  // rounding
  }
}

TEST_CASE("a linear sweep updates clusters together, and its velocities satisfy the rigid connections") {
  Network net = chain(8, Vector3::Zero(), {1.0, 0.3, 0.1}, damped(40.0, 1.0), 0.5);
  net.fix(0);
  net.add_rigid(2, 3);
  net.add_rigid(3, 4);
  net.add_rigid(6, 7);
  const Swept swept(net);
  const std::size_t n = net.nodes().size();
  std::vector<double> u = shaken(3 * n, 9);
  swept.host.project(nullptr, u.data());
  swept.sweep(0.05, false, u);
  std::vector<double> projected = u;
  swept.host.project(nullptr, projected.data());
  for (std::size_t i = 0; i < 3 * n; ++i) CHECK(projected[i] == doctest::Approx(u[i]).epsilon(1e-9));
}

TEST_CASE("the dominant eigenvalue of symmetric and unsymmetric matrices, and refused requests") {
  const LimitSurvey survey(chain(2, Vector3::Zero(), Vector3::UnitX(), damped(1.0, 0.0)), *plugins());
  const sdk::Host host(survey.table());
  std::mt19937 random(3);
  const Eigen::Index size = 60;
  Eigen::MatrixXd full(size, size);
  for (Eigen::Index i = 0; i < size * size; ++i) full.data()[i] = static_cast<double>(random()) * 0x1p-32 - 0.5;
  for (const bool symmetric : {true, false}) {
    const Eigen::MatrixXd matrix = symmetric ? Eigen::MatrixXd(full + full.transpose()) : full;
    const Eigen::VectorXcd values = eigenvalues(matrix);
    for (const std::uint32_t wanted : {SPRINGNET_LARGEST_MAGNITUDE, SPRINGNET_LARGEST_REAL_PART}) {
      sdk::DominantOptions options;
      options.wanted = wanted;
      options.tolerance = 1e-6;
      std::vector<double> start = sdk::scattered_vector(static_cast<std::size_t>(size));
      const sdk::Dominant found = host.dominant_eigenvalue(start, options, [&](double* x) {
        const Eigen::VectorXd image = matrix * Eigen::Map<const Eigen::VectorXd>(x, size);
        Eigen::Map<Eigen::VectorXd>(x, size) = image;
      });
      if (wanted == SPRINGNET_LARGEST_MAGNITUDE)
        CHECK(std::abs(found.value) == doctest::Approx(values.cwiseAbs().maxCoeff()).epsilon(1e-5));
      else
        CHECK(found.value.real() == doctest::Approx(values.real().maxCoeff()).epsilon(1e-5));
      // The eigenvector is one.
      const auto as_vector = [&](const std::vector<double>& x) {
        return Eigen::Map<const Eigen::VectorXd>(x.data(), size);
      };
      Eigen::VectorXcd mode = as_vector(found.real).cast<std::complex<double>>();
      mode += std::complex<double>(0.0, 1.0) * as_vector(found.imaginary).cast<std::complex<double>>();
      CHECK((matrix * mode - found.value * mode).norm() <= 1e-4 * std::abs(found.value));
    }
  }
  std::vector<double> zero(6, 0.0), ones(6, 1.0), none;
  const auto nothing = [](double*) {};
  CHECK_THROWS_WITH_AS(static_cast<void>(host.dominant_eigenvalue(zero, {}, nothing)), doctest::Contains("start is 0"),
                       sdk::Failure);
  CHECK_THROWS_WITH_AS(static_cast<void>(host.dominant_eigenvalue(
                           ones, {}, [](double*) { throw sdk::Failure("the map has no answer"); })),
                       "the map has no answer", sdk::Failure);
  CHECK(host.dominant_eigenvalue(none, {}, nothing).value == 0.0);
  CHECK(std::isinf(host.dominant_eigenvalue(ones, {}, [](double* x) { x[0] = NAN; }).value.real()));
}
