// Products with transposed derivatives and projections: y . (J x) = (J^T y) . x to rounding.

#include <doctest/doctest.h>

#include "../elements/bodies.hpp"
#include "../layers/random_net.hpp"
#include "sliding.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// x . y, and the sum of the sizes of its terms.
struct Product {
  double value, size;
};
Product product(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  return {x.dot(y), x.cwiseAbs().dot(y.cwiseAbs())};
}

void check_transposed(HostAt& at) {
  const auto size = static_cast<std::size_t>(at.position.size());
  at.host.linearise(at.evaluation());
  const Eigen::VectorXd dp = random_vector(size, 1), dv = random_vector(size, 2), y = random_vector(size, 3);
  Eigen::VectorXd out(dp.size()), by_position(dp.size()), by_velocity(dp.size());
  for (const std::uint32_t kind : {0u, std::uint32_t{SPRINGNET_TRUE_FRICTION}}) {
    CAPTURE(kind);
    at.host.jacobian_times(dp.data(), dv.data(), out.data(), kind);
    at.host.jacobian_transposed_times(y.data(), by_position.data(), by_velocity.data(), kind);
    const Product of_out = product(y, out), p = product(by_position, dp), v = product(by_velocity, dv);
    CHECK(out.norm() > 0.0);
    CHECK(std::abs(of_out.value - p.value - v.value) <= of_sums * (of_out.size + p.size + v.size));

    Eigen::VectorXd x = dp, z = y;
    at.host.project(nullptr, x.data(), kind);
    at.host.project(nullptr, z.data(), kind | SPRINGNET_TRANSPOSED);
    CHECK(std::abs(x.dot(y) - z.dot(dp)) <= of_sums * (product(x, y).size + product(z, dp).size));
    // Projections: once more changes nothing but rounding.
    Eigen::VectorXd again = x;
    at.host.project(nullptr, again.data(), kind);
    const bool begins = kind == SPRINGNET_TRUE_FRICTION;  // slips that begin turn, which is no projection
    if (!begins) CHECK((again - x).norm() <= 1e-9 * x.norm());
  }
  // With mobilities of one's own.
  std::vector<double> mobility;
  for (std::size_t k = 0; k < size / 3; ++k) {
    const Eigen::VectorXd r = random_vector(9, static_cast<unsigned>(50 + k));
    const Eigen::Matrix3d root = Eigen::Map<const Eigen::Matrix3d>(r.data());
    const Eigen::Matrix3d m = root * root.transpose() + Eigen::Matrix3d::Identity();
    mobility.insert(mobility.end(), m.data(), m.data() + 9);
  }
  Eigen::VectorXd x = dp, z = y;
  at.host.project(mobility.data(), x.data());
  at.host.project(mobility.data(), z.data(), SPRINGNET_TRANSPOSED);
  CHECK(std::abs(x.dot(y) - z.dot(dp)) <= of_sums * (product(x, y).size + product(z, dp).size));
}

}  // namespace

TEST_CASE("springs of all kinds, elements of every invariant, an enclosed volume") {
  for (const unsigned seed : {1u, 2u, 3u}) {
    HostAt springs(random_network(40, 3, seed));
    check_transposed(springs);
    HostAt elements(all_kinds(seed));
    check_transposed(elements);
  }
}

TEST_CASE("rigid connections, nodes that stick, slide, or begin to slide on a floor with and without friction") {
  for (const Friction& friction : {Friction{Friction::Kind::none, 0.0}, Friction{Friction::Kind::coulomb, 0.3}}) {
    for (const bool rigid : {false, true}) {
      for (const bool at_rest : {false, true}) {
        CAPTURE(rigid);
        CAPTURE(at_rest);
        HostAt at(on_floor({friction, rigid, at_rest}).net());
        check_transposed(at);
      }
    }
  }
}

TEST_CASE("transposed products are the same for every number of threads") {
  std::vector<Eigen::VectorXd> answers;
  for (const unsigned threads : {1u, 3u}) {
    Network net;
    Lattice lattice;
    lattice.nodes = {20, 20, 30};
    lattice.diagonals = Diagonals::space;
    net.add_lattice("block", lattice, Node{}, net.add_material(damped(3.0, 0.5)));
    HostAt at(net, plugins(), threads);
    const auto size = static_cast<std::size_t>(at.position.size());
    at.position += 0.05 * random_vector(size, 1);
    at.host.linearise(at.evaluation());
    const Eigen::VectorXd y = random_vector(size, 3);
    Eigen::VectorXd both(2 * y.size());
    at.host.jacobian_transposed_times(y.data(), both.data(), both.data() + size);
    answers.push_back(both);
  }
  CHECK(answers[0] == answers[1]);
}
