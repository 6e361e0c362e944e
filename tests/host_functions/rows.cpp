// The prepared system row by row, and the names of events.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include <Eigen/Dense>

#include "probe.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// S from its rows; unknown 3 k + c is component c of node k.
Eigen::MatrixXd matrix_of(const springnet_system_rows& rows, std::size_t nodes) {
  const auto size = static_cast<Eigen::Index>(3 * nodes);
  Eigen::MatrixXd s = Eigen::MatrixXd::Zero(size, size);
  const auto at = [](std::uint32_t node) { return 3 * static_cast<Eigen::Index>(node); };
  for (std::uint32_t k = 0; k < nodes; ++k)
    for (std::uint32_t b = rows.row_start[k]; b < rows.row_start[k + 1]; ++b) {
      if (b > rows.row_start[k]) CHECK(rows.columns[b] > rows.columns[b - 1]);
      s.block<3, 3>(at(k), at(rows.columns[b])) += Eigen::Map<const Eigen::Matrix3d>(rows.blocks + 9 * b);
    }
  for (std::uint32_t e = 0; e < rows.low_rank_count; ++e) {
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size), w = g;
    for (std::uint64_t i = rows.low_rank_start[e]; i < rows.low_rank_start[e + 1]; ++i) {
      g.segment<3>(at(rows.low_rank_nodes[i])) = Eigen::Map<const Vector3>(rows.low_rank_g + 3 * i);
      w.segment<3>(at(rows.low_rank_nodes[i])) = Eigen::Map<const Vector3>(rows.low_rank_w + 3 * i);
    }
    s += g * w.transpose();
  }
  return s;
}

}  // namespace

TEST_CASE("the rows of the prepared system are those of the derivatives, and solve as the host does") {
  Network net = of_everything();
  net.fix(4);
  within_step(net, [](const sdk::Host& host) {
    const At at(host);
    const std::size_t n = at.n;
    const springnet_evaluation evaluation = at.evaluation();
    constexpr double velocity = 0.02, position = 0.003, shift = 0.5;
    host.linearise(evaluation);
    host.prepare_system({velocity, position, shift});
    const springnet_system_rows rows = host.system_rows();
    CHECK(rows.low_rank_count == 1);
    const Eigen::MatrixXd s = matrix_of(rows, n);
    const springnet_network& network = host.network();
    std::vector<double> u(3 * n), p(3 * n), v(3 * n), image(3 * n);
    for (std::size_t i = 0; i < 3 * n; ++i) u[i] = network.fixed[i % n] != 0 ? 0.0 : std::sin(7.0 * double(i));
    for (std::size_t i = 0; i < 3 * n; ++i) p[i] = position * u[i], v[i] = velocity * u[i];
    host.jacobian_times(p.data(), v.data(), image.data());
    Eigen::VectorXd x(3 * n), b(3 * n);
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto to = static_cast<Eigen::Index>(3 * k + c);
        x[to] = u[c * n + k];
        b[to] = network.fixed[k] != 0 ? 0.0 : network.mass[k] * ((1.0 + shift) * u[c * n + k] - image[c * n + k]);
      }
    CHECK((s * x - b).norm() <= 1e-12 * b.norm());
    // The same right-hand side, solved by both.
    std::vector<double> solved(3 * n);
    std::vector<double> right(3 * n);
    for (std::size_t i = 0; i < 3 * n; ++i) right[i] = network.fixed[i % n] != 0 ? 0.0 : std::cos(3.0 * double(i));
    static_cast<void>(host.solve_system(right.data(), 1e-13, solved.data()));
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t c = 0; c < 3; ++c) b[static_cast<Eigen::Index>(3 * k + c)] = network.mass[k] * right[c * n + k];
    const Eigen::VectorXd mine = s.partialPivLu().solve(b);
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        CHECK(std::abs(mine[static_cast<Eigen::Index>(3 * k + c)] - solved[c * n + k]) <= 1e-10);
  });
}

TEST_CASE("rows are there of a system that the host keeps without a matrix, too, and not before one is prepared") {
  Lattice lattice;
  lattice.nodes = {12, 12, 12};
  Network net;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(50.0, 1.0)));
  within_step(net, [](const sdk::Host& host) {
    CHECK_THROWS_WITH_AS(static_cast<void>(host.system_rows()), doctest::Contains("without a prepared system"),
                         sdk::Failure);
    const At at(host);
    const springnet_evaluation evaluation = at.evaluation();
    host.prepare_system({0.01, 1e-4}, evaluation, false);
    const springnet_system_rows rows = host.system_rows();
    CHECK(rows.row_start[at.n] > 6 * 12 * 12 * 11);
    CHECK(rows.low_rank_count == 0);
    CHECK(rows.blocks[0] > 1.0);  // 1 kg, and stiffness
  });
}

TEST_CASE("events have names: what, whose, at which surface") {
  Network net;
  Material weak{LawUse{"rupturing", {{"stiffness", 5.0}, {"strength", 1.0}}}, std::nullopt};
  const MaterialIndex breaks = net.add_material(weak), holds = net.add_material(damped(5.0, 0.1));
  for (int k = 0; k < 4; ++k) net.add_node(point({double(k % 2), double(k / 2), 1.0 + 0.1 * k}));
  net.add_spring(0, 1, holds);
  net.add_spring(1, 2, breaks);
  net.add_spring(2, 3, holds);
  net.add_element(Invariant::area, {0, 1, 2}, breaks);
  Plane wall;
  wall.name = "wall";
  wall.point = {-9, 0, 0};
  wall.normal = {1, 0, 0};
  net.add_plane({.name = "floor"});
  net.add_plane(wall);
  within_step(net, [](const sdk::Host& host) {
    const At at(host);
    const springnet_network& network = host.network();
    const std::uint32_t count = network.event_count;
    std::vector<double> values(count);
    std::vector<std::int32_t> directions(count);
    std::vector<std::uint32_t> kinds(count), who(count), surfaces(count);
    host.event_values(at.evaluation(), values.data(), directions.data(), {kinds.data(), who.data(), surfaces.data()});
    std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, double> found;
    for (std::uint32_t i = 0; i < count; ++i) {
      const bool node = kinds[i] == SPRINGNET_EVENT_TOUCH;
      found[{kinds[i], node ? network.user_number[who[i]] : who[i], surfaces[i]}] = values[i];
    }
    CHECK(found.size() == 4 * 2 + 2);
    constexpr std::uint32_t none = 0xffffffffu;
    for (std::uint32_t k = 0; k < 4; ++k) {
      // The gap to the floor, and to the wall.
      CHECK(found.at({SPRINGNET_EVENT_TOUCH, k, 0}) == doctest::Approx(1.0 + 0.1 * k));
      CHECK(found.at({SPRINGNET_EVENT_TOUCH, k, 1}) == doctest::Approx(9.0 + k % 2));
    }
    CHECK(found.count({SPRINGNET_EVENT_SPRING_RUPTURE, 1, none}) == 1);
    CHECK(found.count({SPRINGNET_EVENT_ELEMENT_RUPTURE, 0, none}) == 1);
  });
}

TEST_CASE("a node at rest on a rough surface may be released or slip, a sliding one may be released or come to rest") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}, 1.0, {2, 0, 0}));
  net.set_gravity({0, 0, -10});
  net.add_plane({.name = "floor", .friction = {Friction::Kind::coulomb, 0.3}});
  std::map<std::uint32_t, std::vector<std::uint32_t>> kinds_of;
  within_step(net, [&](const sdk::Host& host) {
    const At at(host);
    const std::uint32_t count = host.network().event_count;
    std::vector<double> values(count);
    std::vector<std::uint32_t> kinds(count), who(count);
    host.event_values(at.evaluation(), values.data(), nullptr, {kinds.data(), who.data(), nullptr});
    for (std::uint32_t i = 0; i < count; ++i) kinds_of[host.network().user_number[who[i]]].push_back(kinds[i]);
  });
  CHECK(kinds_of[0] == std::vector<std::uint32_t>{SPRINGNET_EVENT_RELEASE, SPRINGNET_EVENT_SLIP});
  CHECK(kinds_of[1] ==
        std::vector<std::uint32_t>{SPRINGNET_EVENT_RELEASE, SPRINGNET_EVENT_REST, SPRINGNET_EVENT_SLIP_CHANGE});
}
