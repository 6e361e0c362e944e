// Scenes whose springs have formulas as laws.
#pragma once

#include <string>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "scenes.hpp"

// Two springs, with these lines about them; nine lines of text before.
inline std::string chain(const std::string& lines) {
  return simulation +
         "[[body]]\nname = \"chain\"\nnodes = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]\nsprings = [[0, 1], [1, 2]]\n"
         "neuron = { type = \"point_mass\", mass = 1.0 }\n" +
         lines + "\n";
}

inline void refused(const std::string& text, const std::string& facts) {
  const std::string message = refusal(text);
  INFO(message);
  CHECK(springnet::testing::has_facts(message, facts));
}
