// An inclusion is found from motions of the surface alone.

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include <doctest/doctest.h>

#include "inclusion.hpp"

using namespace springnet;
using namespace springnet::testing;

// tests/long has a block of 1,000 nodes, whose inclusion is an eighth of its width; here it is a third.
TEST_CASE("a stiff inclusion is found from motions of the surface with 1 % noise") {
  const char* const given = std::getenv("SPRINGNET_INCLUSION_NODES");
  InclusionOptions with;
  with.nodes = given != nullptr ? static_cast<std::uint32_t>(std::atoi(given)) : 4;
  const bool is_small = with.nodes <= 5;
  with.step = is_small ? 0.1 : 0.05;
  with.duration = is_small ? 1.6 : 3.0;
  with.every = is_small ? 2 : 1;
  const Inclusion real = inclusion(with);
  LearnOptions options;
  options.stages = 1;
  // Far from the least cost an iteration over many springs lowers it by less than 1e-3 of itself.
  options.tolerance = is_small ? 1e-3 : 1e-4;
  if (!is_small) options.max_iterations = 20;
  if (is_small)
    options.guess_rule = GuessRule::discrepancy;
  else
    options.guess_weight = 20;  // stiffnesses change by a fifth or so: the rule would take as long for each weight
  const LearnedNet learned =
      learn(real.experiments, plugins(),
            {{{LearnedValues::Kind::spring_parameter, false, "stiffness", from_to(0, real.is_stiff.size())}}}, options);
  CAPTURE(learned.reason);
  const double dice = dice_of(real, learned.parameters, with.contrast);
  double inside = 0.0, outside = 0.0, from_guess[2] = {0.0, 0.0}, stiff = 0.0;
  for (const LearnedParameter& each : learned.parameters) {
    const bool is = real.is_stiff[each.member];
    (is ? inside : outside) += std::log(each.value / stiffness_around);
    from_guess[is ? 1 : 0] += each.from_guess;
    stiff += is ? 1.0 : 0.0;
  }
  const double others = static_cast<double>(learned.parameters.size()) - stiff;
  MESSAGE(with.nodes, " nodes a side, ", learned.observed, " values: Dice ", dice,
          "; geometric mean of the stiffness by that around ", std::exp(inside / stiff), " inside and ",
          std::exp(outside / others), " outside; share of the guess ", from_guess[1] / stiff, " and ",
          from_guess[0] / others, "; rms ", learned.rms, ", weight ", learned.guess_weight);
  CHECK(dice >= 0.6);
  CHECK(learned.rms == doctest::Approx(1.0).epsilon(0.03));
  // Between fixed nodes nothing can be said, and it is not.
  const Network block_net = block_of(with);
  for (const LearnedParameter& each : learned.parameters) {
    const Spring& own = block_net.springs()[each.member];
    const bool is_held = block_net.nodes()[own.first].fixed && block_net.nodes()[own.second].fixed;
    CHECK(each.has_influence == !is_held);
  }
}
