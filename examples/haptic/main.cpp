// A haptic loop: a ball strokes a block of soft tissue. Frames of the network come at 40 Hz; between them the force on
// the ball is rendered at 1 kHz by the local force model of the last frame. Prints how far the rendered forces are from
// those of the next frame, and what frames and models cost.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

namespace {

using springnet::Vector3;

constexpr double frame = 0.025;   // s
constexpr int renderings = 25;    // of a frame
constexpr int frames = 160;       // 4 s
constexpr double spacing = 0.01;  // m
constexpr double radius = 0.02;   // m, of the ball
constexpr std::size_t ball = 0;   // number of the surface
constexpr std::uint32_t wide = 12, high = 7;

// 12 x 12 x 7 nodes, 1 cm apart: 0.7 kg of tissue, about 10 kPa, lying on a table.
springnet::Network tissue() {
  springnet::Network network;
  const auto material = network.add_material(
      {.spring = springnet::LawUse{"nonlinear", {{"stiffness", 40.0}, {"cubic", 4e6}}},  // N/m, N/m^3
       .viscosity = springnet::LawUse{"linear", {{"damping", 0.2}}}});                   // N s/m
  network.add_lattice("tissue",
                      {.nodes = {wide, wide, high},
                       .spacing = Vector3::Constant(spacing),
                       .origin = Vector3::Zero(),
                       .diagonals = springnet::Diagonals::all},
                      {.mass = 0.7e-3}, material);
  for (springnet::NodeIndex node = 0; node < wide * wide; ++node) network.fix(node);
  network.set_gravity({0.0, 0.0, -9.81});
  return network;
}

constexpr double top = (high - 1) * spacing, middle = 0.5 * (wide - 1) * spacing;

// Where a hand takes the ball: 1 cm down within a second, then to and fro at 1 Hz, 2 cm wide, and up and down by 2 mm.
Vector3 hand(double time) {
  const double depth = 0.5 * 0.01 * (1.0 - std::cos(std::numbers::pi * std::min(time, 1.0)));
  const double turn = 2.0 * std::numbers::pi * std::max(0.0, time - 1.0);
  return {middle + 0.01 * std::sin(turn), middle, top + radius - depth + 0.002 * std::sin(2.3 * turn)};
}

struct Error {
  double sum = 0.0, greatest = 0.0;
  int count = 0;
  void add(double error) {
    sum += error * error;
    greatest = std::max(greatest, error);
    ++count;
  }
  [[nodiscard]] double rms() const { return std::sqrt(sum / count); }
};

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

void run(const char* name, springnet::Friction friction) {
  auto plugins = std::make_shared<const springnet::PluginHost>(springnet::PluginHost::with_default_search());
  springnet::Network network = tissue();
  network.add_instrument(
      {.name = "ball", .first = hand(0.0), .second = hand(0.0), .radius = radius, .friction = friction});
  // Choices are numbers here, in the order in which `springnet plugin show recurrent` lists them: 4 is newton.
  springnet::Simulation simulation(network, plugins,
                                   {.time_step = frame, .integrator = {"recurrent", {{"update", 4}}}});
  springnet::LocalForce model;
  Error held, rendered;
  Vector3 last = Vector3::Zero(), shown = Vector3::Zero();
  double force = 0.0, steps_time = 0.0, models_time = 0.0;
  for (int n = 1; n <= frames; ++n) {
    if (n > 1) {
      // The device's loop, in real time in a thread of its own: it needs the model and the place of the hand only.
      for (int i = 1; i <= renderings; ++i)
        shown = model.at(hand((n - 1 + static_cast<double>(i) / renderings) * frame));
      last = model.force;
    }
    const double begin = seconds();
    simulation.move_surface(ball, hand(n * frame), n * frame);
    simulation.step();
    const double stepped = seconds();
    model = simulation.local_surface_force(ball);
    models_time += seconds() - stepped;
    steps_time += stepped - begin;
    force = std::max(force, model.force.norm());
    if (n == 1) continue;
    held.add((last - model.force).norm());
    rendered.add((shown - model.force).norm());
  }
  std::printf("%s_greatest_force_N %.4g\n", name, force);
  std::printf("%s_held_force_rms_error_percent %.3g\n", name, 100.0 * held.rms() / force);
  std::printf("%s_held_force_greatest_error_percent %.3g\n", name, 100.0 * held.greatest / force);
  std::printf("%s_local_model_rms_error_percent %.3g\n", name, 100.0 * rendered.rms() / force);
  std::printf("%s_local_model_greatest_error_percent %.3g\n", name, 100.0 * rendered.greatest / force);
  std::printf("%s_ms_per_step %.3g\n%s_ms_per_model %.3g\n", name, 1e3 * steps_time / frames, name,
              1e3 * models_time / frames);
}

}  // namespace

int main() {
  try {
    run("smooth", {springnet::Friction::Kind::none});
    run("rough", {springnet::Friction::Kind::coulomb, 0.3});
  } catch (const springnet::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
