// A scene that is turned, mirrored, or written in other units moves in the same way.

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Places become rotation * length * place, in units of mass and time that make numbers `mass` and `time` times as
// large.
struct View {
  std::string name;
  Eigen::Matrix3d rotation;
  double length, mass, time;

  [[nodiscard]] Vector3 place(const Vector3& p) const { return length * (rotation * p); }
  [[nodiscard]] Vector3 velocity(const Vector3& v) const { return length / time * (rotation * v); }
  [[nodiscard]] Vector3 force(const Vector3& f) const { return mass * length / (time * time) * (rotation * f); }
};

Motion seen(const Motion& motion, const View& view) {
  Motion result = motion;
  for (double& t : result.times) t *= view.time;
  for (Vector3& d : result.displacements) d = view.place(d);
  result.amplitude = view.place(motion.amplitude);
  result.frequency /= view.time;
  result.from *= view.time;
  result.until *= view.time;
  return result;
}

Network seen(const Network& net, const View& view) {
  Network result;
  result.set_gravity(view.velocity(net.gravity()) / view.time);
  for (Node node : net.nodes()) {
    node.position = view.place(node.position);
    node.velocity = view.velocity(node.velocity);
    node.mass *= view.mass;
    result.add_node(node);
  }
  for (const Spring& spring : net.springs()) {
    Material material = net.materials()[spring.material];
    material.spring->parameters.at("stiffness") *= view.mass / (view.time * view.time);
    if (material.viscosity) material.viscosity->parameters.at("damping") *= view.mass / view.time;
    result.add_spring(spring.first, spring.second, result.add_material(material), view.length * spring.rest_length);
  }
  for (const Rigid& rigid : net.rigids()) result.add_rigid(rigid.first, rigid.second);
  for (Plane plane : net.planes()) {
    plane.point = view.place(plane.point);
    plane.normal = view.rotation * plane.normal;
    if (plane.motion) plane.motion = seen(*plane.motion, view);
    result.add_plane(plane);
  }
  for (Instrument instrument : net.instruments()) {
    instrument.first = view.place(instrument.first);
    instrument.second = view.place(instrument.second);
    instrument.radius *= view.length;
    if (instrument.motion) instrument.motion = seen(*instrument.motion, view);
    result.add_instrument(instrument);
  }
  return result;
}

// A triangle of rods and a spring that falls on a corner and slides.
Network falling_triangle(const Friction& friction) {
  Network net;
  net.add_node(point({0, 0, 0.05}, 0.3, {0.4, 0.1, 0}));
  net.add_node(point({0.5, 0.1, 0.4}, 0.4, {0.4, 0.1, 0}));
  net.add_node(point({-0.1, 0.5, 0.5}, 0.5, {0.4, 0.1, 0}));
  net.add_rigid(0, 1);
  net.add_rigid(1, 2);
  net.add_spring(2, 0, net.add_material(damped(80.0, 0.2)));
  net.set_gravity({0, 0, -4});
  Plane plane;
  plane.friction = friction;
  net.add_plane(plane);
  return net;
}

struct Obstructed {
  std::string name;
  Network net;
  double until;  // s
};

}  // namespace

TEST_CASE("contact looks the same turned, mirrored, and in other units") {
  const Eigen::Matrix3d turned =
      (Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()) * Eigen::AngleAxisd(-1.9, Vector3::UnitX()))
          .toRotationMatrix();
  const Vector3 axis = Vector3(2, -1, 0.5).normalized();
  const Eigen::Matrix3d mirrored = Eigen::Matrix3d::Identity() - 2.0 * axis * axis.transpose();
  const View views[] = {{"turned", turned, 1.0, 1.0, 1.0},
                        {"mirrored", mirrored, 1.0, 1.0, 1.0},
                        {"mm, g, ms", Eigen::Matrix3d::Identity(), 1e3, 1e3, 1e3},
                        {"mm, t, s", Eigen::Matrix3d::Identity(), 1e3, 1e-3, 1.0}};
  const Friction rough{Friction::Kind::coulomb, 0.3};
  const Obstructed examples[] = {{"sphere", on_sphere(), 3.0},
                                 {"landing on a rough sphere", thrown_on_sphere(rough), 1.2},
                                 {"landing on a capsule", thrown_on_capsule(frictionless), 1.2},
                                 {"pair", thrown_pair(), 0.6},
                                 {"box", thrown_box(), 0.6},
                                 {"shaken oscillator", shaken_oscillator(), 3.0},
                                 {"triangle", falling_triangle(frictionless), 0.5},
                                 {"rough triangle", falling_triangle(rough), 0.5},
                                 {"held triangle", falling_triangle({Friction::Kind::held, 0.0}), 0.5}};
  for (const Obstructed& example : examples) {
    for (const View& view : views) {
      const Network other = seen(example.net, view);
      std::vector<Scheme> schemes = {{"newton, theta 1/2", {}, 2.0},
                                     {"wavefront, theta 1", {}, 1.0},
                                     {"verlet", {"verlet", {}}, 2.0},
                                     {"generalized_alpha", generalized_alpha(), 2.0},
                                     {"bdf", cvode(1e-11), 0.0}};
      for (const Scheme& scheme : schemes) {
        INFO(example.name << ", " << view.name << ": " << scheme.name);
        const double force = view.mass * view.length / (view.time * view.time);
        const auto integrator = [&](double unit) {
          if (scheme.name[0] == 'n') return recurrent(newton, 1e-11 * unit, {{"theta", 0.5}});
          if (scheme.name[0] == 'w') return recurrent(wavefront, 1e-11 * unit, {{"theta", 1.0}});
          return scheme.integrator;
        };
        // No step ends where something begins.
        const double h = scheme.order > 0.0 ? 0.0019 : 0.05;
        Simulation s = simulate(example.net, integrator(1.0), h);
        Simulation t = simulate(other, integrator(force), h * view.time);
        if (!reaches(s, example.until) || !reaches(t, example.until * view.time)) continue;
        double worst = 0.0;
        for (NodeIndex k = 0; k < s.node_count(); ++k)
          worst = std::max(worst, (t.position(k) - view.place(s.position(k))).norm() / view.length);
        // Rounding and thresholds, grown by what touches; the reference's tolerance over its steps.
        CHECK(worst <= (scheme.order > 0.0 ? 1e-9 : 1e-8));
        // The reference may graze a surface once more within its tolerance.
        if (scheme.order > 0.0) CHECK(s.events().size() == t.events().size());
      }
    }
  }
}
