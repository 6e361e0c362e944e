// The nearest points of a surface that moves, against all of its faces one by one.

#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include "generator.hpp"
#include "learning/surface.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::learning;
using namespace springnet::testing;

namespace {

// Distance of a point from a triangle by another way: from its plane where the foot is inside, else from its sides.
double distance_to(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p) {
  const auto to_side = [&](const Vector3& from, const Vector3& to) {
    const Vector3 way = to - from;
    const double share = way.squaredNorm() > 0.0 ? (p - from).dot(way) / way.squaredNorm() : 0.0;
    return (p - from - std::min(1.0, std::max(0.0, share)) * way).norm();
  };
  double least = std::min({to_side(a, b), to_side(b, c), to_side(c, a)});
  Eigen::Matrix3d m;  // p = a + m (s, t, u) with the normal as the third direction
  m << b - a, c - a, (b - a).cross(c - a);
  if (std::abs(m.determinant()) < 1e-14) return least;
  const Vector3 at = m.inverse() * (p - a);
  if (at[0] >= 0.0 && at[1] >= 0.0 && at[0] + at[1] <= 1.0) least = std::min(least, std::abs(at[2]) * m.col(2).norm());
  return least;
}

Eigen::Matrix3Xd positions_of(const Network& net, Dice& dice, double noise) {
  Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(net.nodes().size()));
  for (std::size_t k = 0; k < net.nodes().size(); ++k)
    result.col(static_cast<Eigen::Index>(k)) = net.nodes()[k].position + dice.in_box(noise);
  return result;
}

}  // namespace

TEST_CASE("the nearest point of a surface is that of all of its faces, however it has moved") {
  Network net;
  Lattice lattice;
  lattice.nodes = {5, 4, 3};
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(10, 1)));
  Surface surface(net);
  Dice dice(7);
  int faces = 0, edges = 0, corners = 0;
  for (const double noise : {0.0, 0.3, 3.0}) {  // the last one leaves nothing of the order of the faces
    const Eigen::Matrix3Xd at = positions_of(net, dice, noise);
    surface.move(at);
    for (int i = 0; i < 300; ++i) {
      const Vector3 point = Vector3(2, 1.5, 1) + dice.in_box(4.0);
      double least = std::numeric_limits<double>::infinity();
      for (const Face& face : net.faces())
        least = std::min(least, distance_to(at.col(face[0]), at.col(face[1]), at.col(face[2]), point));
      const Surface::Nearest nearest = surface.nearest(point);
      CHECK((nearest.point - point).norm() == doctest::Approx(least).epsilon(1e-10));
      Vector3 combined = Vector3::Zero();
      for (int c = 0; c < 3; ++c) combined += nearest.weights[c] * at.col(nearest.nodes[static_cast<std::size_t>(c)]);
      CHECK((combined - nearest.point).norm() < 1e-12);
      CHECK(nearest.weights.sum() == doctest::Approx(1.0));
      CHECK(nearest.weights.minCoeff() >= 0.0);
      // The way to the point is among the directions that its nodes decide.
      const Vector3 way = point - nearest.point;
      CHECK((nearest.normal * way - way).norm() < 1e-9 * (1.0 + way.norm()));
      const double dimensions = nearest.normal.trace();
      CHECK(std::abs(dimensions - std::round(dimensions)) < 1e-12);
      (dimensions < 1.5 ? faces : dimensions < 2.5 ? edges : corners) += 1;
    }
  }
  CHECK(faces > 50);
  CHECK(edges > 50);
  CHECK(corners > 50);
}

TEST_CASE("a point on the surface is its own nearest one, and faces without an area are lines and points") {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(2, 0, 0), Vector3(0, 1, 0)})
    net.add_node(point(p));
  net.add_face({0, 1, 3});
  net.add_face({0, 1, 2});  // a line
  const Surface surface(net);
  const Surface::Nearest inside = surface.nearest({0.25, 0.25, 0});
  CHECK(inside.point == Vector3(0.25, 0.25, 0));
  CHECK((inside.normal - Vector3(0, 0, 1).asDiagonal().toDenseMatrix()).norm() < 1e-15);
  const Surface::Nearest line = surface.nearest({1.5, -1, 0});
  CHECK(line.point == Vector3(1.5, 0, 0));
  CHECK((line.normal - Vector3(0, 1, 1).asDiagonal().toDenseMatrix()).norm() < 1e-15);
  CHECK(surface.nearest({3, 0, 1}).point == Vector3(2, 0, 0));
}

TEST_CASE("of a body without faces, nodes are the surface, beside the faces of others") {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 3};
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(10, 1)));
  net.begin_body("cloud");
  net.add_node(point({10, 0, 0}));
  net.add_node(point({11, 0, 0}));
  net.end_body();
  const Surface surface(net);
  const Surface::Nearest node = surface.nearest({10.4, 1, 0});
  CHECK(node.point == Vector3(10, 0, 0));
  CHECK(node.normal == Eigen::Matrix3d::Identity());
  // Of the block its faces, and no node within it.
  CHECK(surface.nearest({1, 1, 1.1}).point == Vector3(1, 1, 2));
}
