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
    for (const fuzzy::Variable& input : base.inputs) {
      const double middle = 0.5 * (input.smallest + input.largest);
      inputs.emplace_back(std::abs(middle) < 1e-100 ? 0.0 : middle);  // smaller ones are refused
    }
    const auto require_numbers = [&] {
      for (const std::optional<fuzzy::Guess>& guess : fuzzy::evaluate(base, inputs).outputs)
        testing::require(!guess || (std::isfinite(guess->value) && guess->width >= 0.0), "a guess is a number");
    };
    require_numbers();
    for (std::size_t i = 0; i < inputs.size(); i += 2) inputs[i].reset();  // nothing is known of these
    require_numbers();
    const std::string written = fuzzy::to_fcl(base);
    testing::require(fuzzy::to_fcl(fuzzy::parse_rules(written, "written.fcl")) == written, "what is written is read");
  });
  return 0;
}
