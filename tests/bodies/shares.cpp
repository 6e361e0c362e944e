// How redundant pairs share what they do: as the smallest forces within their cones of friction.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/QR>

#include "bodies.hpp"
#include "rigid_bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// What the touches do to the nodes from `first` on: of a rigid body its force and moment only. Columns: along the
// normal of each touch and, with friction, along two directions across.
Eigen::MatrixXd resultants_of(const std::vector<BodyTouch>& touches, const Simulation& s, NodeIndex first, bool rigid,
                              bool friction) {
  const Eigen::Index each = friction ? 3 : 1;
  const Eigen::Index rows = rigid ? 6 : 3 * static_cast<Eigen::Index>(s.node_count() - first);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rows, each * static_cast<Eigen::Index>(touches.size()));
  for (std::size_t t = 0; t < touches.size(); ++t) {
    const Vector3 n = touches[t].normal, e = n.unitOrthogonal();
    const Vector3 directions[] = {n, e, n.cross(e)};
    for (Eigen::Index c = 0; c < each; ++c)
      for (std::size_t i = 0; i < touches[t].count; ++i) {
        const NodeIndex k = touches[t].nodes[i];
        if (k < first) continue;
        const Vector3 force = touches[t].weights[i] * directions[c];
        const Eigen::Index column = each * static_cast<Eigen::Index>(t) + c;
        if (rigid) {
          result.col(column).head<3>() += force;
          result.col(column).tail<3>() += (s.position(k) - s.position(first)).cross(force);
        } else {
          result.col(column).segment<3>(3 * static_cast<Eigen::Index>(k - first)) += force;
        }
      }
  }
  return result;
}

Eigen::VectorXd into_cones_of(Eigen::VectorXd x, double mu) {
  if (mu == 0.0) return x.cwiseMax(0.0);
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    const double n = x[i], size = x.segment<2>(i + 1).norm();
    if (size <= mu * n) continue;
    const double pressing = std::max(0.0, (n + mu * size) / (1.0 + mu * mu));
    x[i] = pressing;
    x.segment<2>(i + 1) *= size > 0.0 ? mu * pressing / size : 0.0;
  }
  return x;
}

// Dykstra's alternating projections of zero end at the least of all forces in the cones with these resultants.
Eigen::VectorXd least_of(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& resultants, double mu) {
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors(matrix);
  const Eigen::MatrixXd inverse = factors.pseudoInverse();
  const Eigen::MatrixXd keeps = inverse * matrix;
  const Eigen::VectorXd least = inverse * resultants;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(matrix.cols()), on_equations = x, on_cones = x;
  for (int i = 0; i < 20'000; ++i) {
    const Eigen::VectorXd before = x + on_equations, on = before - keeps * before + least;
    on_equations = before - on;
    const Eigen::VectorXd then = on + on_cones;
    x = into_cones_of(then, mu);
    on_cones = then - x;
  }
  return x;
}

}  // namespace

// A block whose four lower corners lie on a fixed sheet: ten edges and faces and more touch where four forces would do.
TEST_CASE("pairs of a face on a face report the smallest forces that carry what lies on them") {
  const double mass = 0.1, spacing = 0.2, thickness = 0.02;
  for (const bool rigid : {false, true})
    for (const double mu : {0.0, 0.5})
      for (const LawUse& integrator : {verlet, LawUse{"recurrent", {{"force_tolerance", 1e-9}}}, reference(1e-9)}) {
        CAPTURE(rigid);
        CAPTURE(mu);
        CAPTURE(integrator.id);
        // It lists those that met, and some of them slipped when the block settled, which goes on.
        const bool located = integrator.id == "cvode";
        Network net;
        add_sheet(net, "table", 6, 1.0, Vector3::Zero(), Vector3::UnitX(), Vector3::UnitY(), thickness, 1.0, true);
        const auto first = static_cast<NodeIndex>(net.nodes().size());
        add_block(net, "block", 2, spacing, {0.013, 0.027, thickness}, at_rest, mass, thickness, 300.0, 3.0);
        if (rigid) join(net, first, 8);
        touch(net, 0, 1, mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless);
        net.set_gravity({0, 0, -g});
        Simulation s = simulate(net, integrator, integrator.id == "verlet" ? 5e-4 : 5e-3);
        s.advance_to(2.0);
        const std::vector<BodyTouch> touches = s.body_touches();
        REQUIRE(touches.size() >= (located ? 4 : 10));
        const Eigen::MatrixXd matrix = resultants_of(touches, s, first, rigid, mu > 0.0);
        Eigen::VectorXd x(matrix.cols());
        Vector3 carried = Vector3::Zero(), moment = Vector3::Zero(), reactions = Vector3::Zero(),
                middle = Vector3::Zero();
        for (NodeIndex k = first; k < first + 8; ++k) middle += 0.125 * s.position(k);
        for (NodeIndex k = 0; k < first; ++k) reactions += s.reaction(k);
        for (std::size_t t = 0; t < touches.size(); ++t) {
          const BodyTouch& each = touches[t];
          const Vector3 e = each.normal.unitOrthogonal();
          const auto at = static_cast<Eigen::Index>(t);
          if (mu > 0.0)
            x.segment<3>(3 * at) << each.normal.dot(each.force), e.dot(each.force),
                each.normal.cross(e).dot(each.force);
          else
            x[at] = each.normal.dot(each.force);
          for (std::size_t i = 0; i < each.count; ++i)
            if (each.nodes[i] >= first) {
              carried += each.weights[i] * each.force;
              moment += each.weights[i] * (s.position(each.nodes[i]) - middle).cross(each.force);
            }
        }
        const double weight = 8 * mass * g;
        CHECK((carried - Vector3(0, 0, weight)).norm() <= 1e-4 * weight);  // at rest but for what still swings
        CHECK(moment.norm() <= 1e-4 * weight * spacing);
        CHECK((reactions - carried + 36 * Vector3(0, 0, -g)).norm() <= 1e-9 * weight);  // nodes of the table: 1 kg each
        CHECK((into_cones_of(x, mu) - x).norm() <= 1e-9 * x.norm());
        const Eigen::VectorXd least = least_of(matrix, matrix * x, mu);
        if (!located || mu == 0.0) CHECK((x - least).norm() <= 1e-4 * least.norm());
      }
}
