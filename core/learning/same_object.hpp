// Experiments on one object.
#pragma once

#include <string>
#include <vector>

#include <springnet/learn.hpp>

namespace springnet::learning {

// Throws Error(input) unless all have a network with nodes, springs and elements like those of the first one: springs
// between the same nodes, elements of the same kind. Loads, starts and what is fixed may be others, and so may values.
void check_same_object(const std::vector<Experiment>& experiments);
// Notes of masses and rest lengths that are not learned, and not those of the first one.
[[nodiscard]] std::vector<std::string> notes_of_differences(const std::vector<Experiment>& experiments,
                                                            const std::vector<Learnable>& learnables);
// If it is learned, which is for all of them.
void check_same_gravity(const std::vector<Experiment>& experiments, const std::vector<Learnable>& learnables);
void check_same_friction(const std::vector<Experiment>& experiments, const std::vector<Learnable>& learnables);

}  // namespace springnet::learning
