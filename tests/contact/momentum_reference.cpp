// The balance of momentum in the reference integrator: gravity, reactions, and the impulses of touches.

#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct Example {
  std::string name;
  Network net;
  double until;  // s
};

std::vector<Example> examples() {
  const Friction rough{Friction::Kind::coulomb, 0.2};
  return {{"sphere", on_sphere(), 3.0},
          {"landing on a sphere", thrown_on_sphere(frictionless), 1.2},
          {"landing on a rough sphere", thrown_on_sphere(rough), 1.2},
          {"landing on a capsule", thrown_on_capsule(frictionless), 1.2},
          {"landing on a rough capsule", thrown_on_capsule(rough), 1.2},
          {"pair", thrown_pair(), 0.6},
          {"box", thrown_box(), 0.6},
          {"shaken plane", on_shaken_plane(), 0.9},
          {"shaken oscillator", shaken_oscillator(), 3.0}};
}

// The Gauss-Legendre rule of five points.
constexpr double x[] = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640};
constexpr double w[] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                        0.2369268850561891};

struct Sample {
  Vector3 force = Vector3::Zero();   // N, all reactions
  Vector3 gained = Vector3::Zero();  // N s, change of momentum less gravity and impulses
  double size = 1.0;                 // N s
};

// m, m/s: by about as much the reference corrects constrained velocities in each step.
constexpr double tolerance = 3e-14;

class Balance {
 public:
  explicit Balance(const Example& example) : net_(example.net), until_(example.until) {
    for (const Node& node : net_.nodes()) mass_ += node.mass;
    Simulation s = simulate(net_, cvode(tolerance), until_);
    s.advance_to(until_);
    std::vector<double> ends = {0.0};
    for (int i = 1; i <= 40; ++i) ends.push_back(until_ * i / 40);
    for (const Event& event : s.events())
      if (event.time > 0.0 && event.time < until_) ends.push_back(event.time);
    std::sort(ends.begin(), ends.end());
    for (std::size_t i = 1; i < ends.size(); ++i)
      if (ends[i] > ends[i - 1]) panels_[ends[i - 1]] = ends[i];
  }

  // The greatest error of the balance, relative to momentum. Reactions are integrated adaptively: where a slip ends the
  // direction of friction turns ever faster.
  double worst() {
    constexpr double shortest = 1e-11;  // s
    while (!panels_.empty()) {
      run();
      std::map<double, double> next;
      for (const auto& [from, to] : panels_) {
        const double middle = 0.5 * (from + to);
        const Vector3 halves = rule(from, middle) + rule(middle, to);
        if ((halves - rule(from, to)).norm() <= 1e-13 || to - from < shortest) {
          given_[to] = halves;
          continue;
        }
        constexpr int parts = 8;
        for (int i = 0; i < parts; ++i)
          next[from + (to - from) * i / parts] = i + 1 < parts ? from + (to - from) * (i + 1) / parts : to;
      }
      panels_ = next;
    }
    run();
    Vector3 given = Vector3::Zero();
    double result = 0.0, size = 1.0;
    for (const auto& [to, part] : given_) {
      given += part;
      size = std::max(size, samples_[to].size);
      result = std::max(result, (samples_[to].gained - given).norm());
    }
    return result / size;
  }

 private:
  // All samples in one run, because time only goes forward.
  void run() {
    samples_.clear();
    for (const auto& [from, to] : panels_)
      for (const auto& [a, b] :
           {std::pair(from, to), std::pair(from, 0.5 * (from + to)), std::pair(0.5 * (from + to), to)})
        for (const double point : x) samples_[at(a, b, point)];
    for (const auto& [to, part] : given_) samples_[to];
    // A short time step, because a millionth of it counts as no time.
    Simulation s = simulate(net_, cvode(tolerance), 1e-4);
    const Vector3 start = s.momentum();
    for (auto& [time, sample] : samples_) {
      s.advance_to(time);
      sample.gained = s.momentum() - start - s.time() * mass_ * net_.gravity();
      for (NodeIndex k = 0; k < s.node_count(); ++k) {
        sample.force += s.reaction(k);
        sample.gained -= s.contact_impulse(k);
        sample.size = std::max({sample.size, s.contact_impulse(k).norm(), s.momentum().norm()});
      }
      sample.gained += (time - s.time()) * sample.force;
    }
  }

  [[nodiscard]] static double at(double from, double to, double point) {
    return from + 0.5 * (to - from) * (1.0 + point);
  }
  [[nodiscard]] Vector3 rule(double from, double to) {
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = 0; i < 5; ++i) sum += 0.5 * (to - from) * w[i] * samples_[at(from, to, x[i])].force;
    return sum;
  }

  Network net_;
  double until_, mass_ = 0.0;
  std::map<double, double> panels_;  // s, start and end of those not integrated yet
  std::map<double, Vector3> given_;  // N s, by the end of a panel
  std::map<double, Sample> samples_;
};

}  // namespace

TEST_CASE("in the reference momentum changes by gravity, the integral of reactions, and impulses alone") {
  for (const Example& example : examples()) {
    INFO(example.name);
    CHECK(Balance(example).worst() <= 1e-10);
  }
}
