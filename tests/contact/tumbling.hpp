// Small bodies of rods and springs that tumble onto planes, spheres, capsules and into grooves, at random.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "../random_nets/generator.hpp"
#include "nets.hpp"
#include "reference.hpp"

namespace springnet::testing {

class Tumbling {
 public:
  enum class Body {
    rod,
    triangle,
    triangle_with_springs,
    tetrahedron,
    two_rods,
    chain,
    triangle_with_elastic_side,
    rod_on_springs
  };
  enum class Ground { plane, sphere, plane_and_sphere, groove, capsule };

  explicit Tumbling(std::uint64_t seed) : dice_(seed * 7919 + 17) {
    body_ = static_cast<Body>(dice_.below(8));
    friction_.kind = std::array{Friction::Kind::held, Friction::Kind::none, Friction::Kind::coulomb}[dice_.below(3)];
    ground_ = static_cast<Ground>(dice_.below(5));
    if (friction_.kind == Friction::Kind::coulomb) friction_.coefficient = dice_.between(0.1, 0.9);
    net.set_gravity({0, 0, -dice_.between(2.0, 10.0)});
    place_nodes();
    join();
    add_ground();
    lift();
  }

  Network net;
  static constexpr double until = 1.5;  // s

  [[nodiscard]] std::string name() const {
    static constexpr const char* bodies[] = {
        "a rod",    "a triangle", "a triangle with springs",         "a tetrahedron",
        "two rods", "a chain",    "a triangle with an elastic side", "a rod on springs"};
    static constexpr const char* grounds[] = {"a plane", "a sphere", "a plane and a sphere", "a groove", "a capsule"};
    static constexpr const char* frictions[] = {", held", ", frictionless", ", with friction"};
    return std::string(bodies[static_cast<std::size_t>(body_)]) + " on " + grounds[static_cast<std::size_t>(ground_)] +
           frictions[static_cast<std::size_t>(friction_.kind)];
  }

 private:
  void place_nodes() {
    const Vector3 drift = dice_.in_box(1.0), spin = dice_.in_box(4.0);  // m/s, rad/s
    const bool four = body_ == Body::triangle_with_springs || body_ == Body::tetrahedron || body_ == Body::two_rods;
    std::vector<Vector3> places(body_ == Body::rod ? 2 : four ? 4 : 3);
    Vector3 centre = Vector3::Zero();
    for (Vector3& place : places) centre += (place = dice_.in_box(0.35)) / static_cast<double>(places.size());
    double low = 0.0;
    for (Vector3& place : places) low = std::min(low, (place -= centre).z());
    const bool flat = ground_ == Ground::plane || ground_ == Ground::groove;
    const double height = flat ? dice_.between(0.02, 0.3) - low : 1.0 - low + dice_.between(0.02, 0.15);
    for (const Vector3& place : places) {
      const double mass = dice_.between(0.1, 1.0);
      net.add_node(point(place + Vector3(0, 0, height), mass, drift + spin.cross(place)));
    }
  }

  void join() {
    const double stiffness = dice_.decades(10.0, 1000.0);
    const MaterialIndex material =
        net.add_material(damped(stiffness, dice_.chance(0.5) ? dice_.between(0.05, 1.0) : 0.0));
    using Pairs = std::vector<std::array<NodeIndex, 2>>;
    static const Pairs rods[] = {{{0, 1}},
                                 {{0, 1}, {1, 2}, {2, 0}},
                                 {{0, 1}, {1, 2}, {2, 0}},
                                 {{0, 1}, {0, 2}, {1, 2}, {0, 3}, {1, 3}, {2, 3}},
                                 {{0, 1}, {2, 3}},
                                 {{0, 1}, {1, 2}},
                                 {{0, 1}, {1, 2}},
                                 {{0, 1}}};
    static const Pairs springs[] = {{}, {},       {{0, 3}, {1, 3}, {2, 3}}, {}, {{0, 2}, {1, 3}, {0, 3}},
                                    {}, {{2, 0}}, {{1, 2}, {0, 2}}};
    for (const auto& [a, b] : rods[static_cast<std::size_t>(body_)]) net.add_rigid(a, b);
    for (const auto& [a, b] : springs[static_cast<std::size_t>(body_)]) net.add_spring(a, b, material);
  }

  void add_ground() {
    const auto add_plane = [&](const char* name, const Vector3& normal) {
      Plane plane;
      plane.name = name;
      plane.normal = normal;
      plane.friction = friction_;
      net.add_plane(plane);
    };
    const auto add_round = [&](const Vector3& first, const Vector3& second, double radius) {
      Instrument round;
      round.name = "round";
      round.first = first;
      round.second = second;
      round.radius = radius;
      round.friction = friction_;
      net.add_instrument(round);
    };
    if (ground_ == Ground::plane || ground_ == Ground::plane_and_sphere) add_plane("floor", {0, 0, 1});
    if (ground_ == Ground::groove) {
      add_plane("left", {0.5, 0.1, 1});
      add_plane("right", {-0.4, 0.2, 1});
    }
    if (ground_ == Ground::sphere || ground_ == Ground::plane_and_sphere)
      add_round({0.05, -0.03, 0.5}, {0.05, -0.03, 0.5}, 0.5);
    if (ground_ == Ground::capsule) add_round({-0.3, -0.5, 0.55}, {0.3, 0.5, 0.6}, 0.4);
  }

  // Out of the obstacles, if the body starts in one.
  void lift() {
    const Reference shapes = surfaces_of(net);
    double deepest = 0.0;
    for (const Node& node : net.nodes())
      for (int j = 0; j < shapes.surface_count(); ++j)
        deepest = std::max(deepest, -shapes.gap(j, 0.0, node.position, node.velocity).distance);
    if (deepest == 0.0) return;
    Network lifted;
    lifted.set_gravity(net.gravity());
    for (Node node : net.nodes()) {
      node.position.z() += 2.0 * deepest + 0.3;
      lifted.add_node(node);
    }
    for (const Material& material : net.materials()) lifted.add_material(material);
    for (const Spring& spring : net.springs())
      lifted.add_spring(spring.first, spring.second, spring.material, spring.rest_length);
    for (const Rigid& rigid : net.rigids()) lifted.add_rigid(rigid.first, rigid.second);
    for (const Plane& plane : net.planes()) lifted.add_plane(plane);
    for (const Instrument& instrument : net.instruments()) lifted.add_instrument(instrument);
    net = lifted;
  }

  Dice dice_;
  Body body_;
  Friction friction_;
  Ground ground_;
};

}  // namespace springnet::testing
