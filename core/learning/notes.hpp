// What the user should know of a result, as sentences.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <springnet/learn.hpp>
#include <springnet/simulation.hpp>

namespace springnet::learning {

// "spring.stiffness of springs 0-3 and 7, mass of nodes 1-4"; empty: of none.
[[nodiscard]] std::string list_of(const std::vector<LearnedParameter>& parameters,
                                  const std::function<bool(const LearnedParameter&)>& is_meant);

// On ruptures and contacts at the ends of the steps of a motion, which may happen in other steps than with the values
// at the start; empty: there are none.
[[nodiscard]] std::string note_of_events(const std::vector<Event>& events, const std::vector<Event>& at_start);

// On values without influence, at bounds and outside of their intervals, and on what was held out.
void add_notes(LearnedNet& learned);

}  // namespace springnet::learning
