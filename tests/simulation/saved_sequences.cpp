// Steps, changes, saved states and copies in sequences at random: a simulation that goes on, and one that has been
// restored or copied from it on the way, have the same bits.

#include <doctest/doctest.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "generator.hpp"
#include "repetitions.hpp"
#include "saved_states.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

SimulationOptions some_method(Dice& dice) {
  std::vector<SimulationOptions> all = all_methods();
  SimulationOptions options = all[dice.below(static_cast<std::uint32_t>(all.size()))];
  // What has most to remember: events that are located.
  if (dice.chance(0.3))
    options = with(recurrent(newton, 0.0, {{"theta", 0.5}, {"unsettled", on_unsettled_adapt}, {"events", 1}}),
                   dice.between(0.005, 0.04));
  options.dissipated_energy = dice.chance(0.25);
  options.renumber = dice.chance(0.5);
  return options;
}

class Sequence {
 public:
  explicit Sequence(std::uint64_t seed)
      : dice_(seed),
        network_(std::make_shared<const Network>(
            dice_.chance(0.5)
                ? eventful()
                : cube(dice_.between(100, 2000), dice_.between(0, 5), dice_.between(1, 10), dice_.between(0, 0.02)))),
        options_(some_method(dice_)),
        own_(network_, plugins(), options_),
        other_(network_, plugins(), options_) {
    if (dice_.chance(0.3)) change();
  }

  // Empty: all was the same; else what was not.
  std::string run() {
    for (int i = 0; i < 14 && difference_.empty() && !over_; ++i) {
      switch (dice_.below(8)) {
        case 0:
        case 1:
          change();
          break;
        case 2:
          save();
          break;
        case 3:
          copy();
          break;
        default:
          advance();
      }
    }
    return difference_;
  }

 private:
  void compare() {
    const std::string what = difference(own_, other_);
    if (!what.empty()) difference_ = what + " after" + log_;
  }
  void advance() {
    log_ += " step";
    const bool done = step(own_);
    if (step(other_) != done)
      difference_ = "one fails after" + log_;
    else if (done)
      compare();
    over_ = !done;
  }
  // The one that goes on is saved, or the other one, to be taken up by its twin or a new one.
  void save() {
    log_ += " save";
    const bool back = dice_.chance(0.3);
    const std::string saved = (back ? other_ : own_).save();
    Simulation& to = back ? own_ : other_;
    if (dice_.chance(0.5)) renew(to);
    to.restore(saved);
    compare();
  }
  // Another object of the same network, if it can begin: nodes may have been moved behind the floor since.
  void renew(Simulation& simulation) const {
    try {
      simulation = Simulation(network_, plugins(), options_);
    } catch (const Error& error) {
      REQUIRE(std::string(error.what()).find("behind") != std::string::npos);
    }
  }
  void copy() {
    log_ += " clone";
    Simulation between = own_.clone();
    if (dice_.chance(0.3)) between.restore(own_.save());
    other_ = std::move(between);
    compare();
  }

  void both(const std::string& what, const std::function<void(Simulation&)>& apply) {
    log_ += " " + what;
    std::string refusals[2];
    int k = 0;
    for (Simulation* each : {&own_, &other_}) {
      try {
        apply(*each);
      } catch (const Error& error) {
        refusals[k] = error.what();
      }
      ++k;
    }
    if (refusals[0] != refusals[1]) difference_ = "other answers after" + log_;
  }
  void change() {
    const auto node = [&] { return dice_.below(64); };
    const auto spring = [&] { return dice_.below(252); };
    const Vector3 some = dice_.in_box(1.0);
    const NodeIndex k = node();
    const double value = dice_.between(0.5, 1.5), until = own_.time() + dice_.between(0.01, 0.2);
    std::vector<SpringIndex> springs;
    for (std::uint32_t i = 0, count = 1 + dice_.below(dice_.chance(0.2) ? 200 : 6); i < count; ++i)
      springs.push_back(spring());
    switch (dice_.below(14)) {
      case 0:
      case 1:
        return both("cut", [&](Simulation& each) { each.cut(springs); });
      case 2:
        return both("force", [&](Simulation& each) { each.set_force(k, some); });
      case 3:
        return both("gravity", [&](Simulation& each) { each.set_gravity(some - Vector3(0, 0, 5)); });
      case 4:
        return both("velocity", [&](Simulation& each) { each.set_velocity(k, some); });
      case 5:
        return both("fix", [&](Simulation& each) { each.set_fixed(k, value < 1.0); });
      case 6:
        return both("move", [&](Simulation& each) { each.move_node(k, each.position(k) + 0.1 * some, until); });
      case 7:
        return both("surface", [&](Simulation& each) {
          each.move_surface(each.surface_count() - 1, each.surface_position(each.surface_count() - 1) + 0.1 * some,
                            until);
        });
      case 8:
        return both("stiffness", [&](Simulation& each) {
          each.set_parameter(springs, ComponentKind::spring_function, "stiffness", {300.0 * value});
        });
      case 9:
        return both("lengths", [&](Simulation& each) { each.set_rest_lengths(springs, {value}); });
      case 10:
        return both("mass", [&](Simulation& each) { each.set_masses({k}, {value}); });
      case 11:
        return both("remove", [&](Simulation& each) { each.remove_nodes({k}); });
      case 12:
        return extend(k, some, value);
      default:
        return both("integrator", [&](Simulation& each) {
          const LawUse use = value < 0.8 ? LawUse{"verlet", {{"substeps", 10}}}
                             : value < 1.2
                                 ? recurrent(automatic, 0.0, {{"theta", 0.5}, {"unsettled", on_unsettled_adapt}})
                                 : cvode(1e-6);
          each.set_integrator(use);
        });
    }
  }
  void extend(NodeIndex k, const Vector3& some, double value) {
    both("extend", [&](Simulation& each) {
      std::shared_ptr<const Network> whole;
      each.extend([&](Network& now) {
        const NodeIndex added = now.add_node(point(each.position(k) + some));
        now.add_spring(k, added, now.add_material(damped(200.0 * value, 1.0)));
        whole = std::make_shared<const Network>(now);
      });
      if (&each == &other_) network_ = whole;
    });
  }

  Dice dice_;
  std::shared_ptr<const Network> network_;
  SimulationOptions options_;
  Simulation own_, other_;
  std::string log_, difference_;
  bool over_ = false;
};

}  // namespace

TEST_CASE("whatever happens before and after, what is restored or copied has the same bits") {
  const std::uint64_t count = repetitions("SPRINGNET_SEQUENCES", 300);
  const std::uint64_t first = repetitions("SPRINGNET_FIRST_SEQUENCE", 1);
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    CAPTURE(seed);
    CHECK(Sequence(seed).run() == "");
  }
}
