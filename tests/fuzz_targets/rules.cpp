// A rule base in FCL: refused, or one that is evaluated, and written as it is read.
#include <cmath>

#include <springnet/fuzzy.hpp>

#include "target.hpp"

using namespace springnet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  testing::read_or_refuse("rules.fcl", [&] {
    const fuzzy::RuleBase base = fuzzy::parse_rules(text, "rules.fcl");
    fuzzy::Inputs inputs;
    for (const fuzzy::Variable& input : base.inputs) inputs.emplace_back(0.5 * (input.smallest + input.largest));
    const fuzzy::Evaluation evaluation = fuzzy::evaluate(base, inputs);
    for (const std::optional<fuzzy::Guess>& guess : evaluation.outputs)
      testing::require(!guess || (std::isfinite(guess->value) && guess->width >= 0.0), "a guess is a number");
    const std::string written = fuzzy::to_fcl(base);
    testing::require(fuzzy::to_fcl(fuzzy::parse_rules(written, "written.fcl")) == written, "what is written is read");
  });
  return 0;
}
