// Signals: numbers over time that laws read as inputs, such as the activation of a muscle.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <springnet/network_lists.hpp>

namespace springnet {

using InputIndex = std::uint32_t;

// A table, a sinusoid, or a constant (neither), in the unit of the input.
struct Signal {
  // hold: the value of an entry until the next one, where it jumps. linear: straight between entries. cubic: monotone
  // between entries with a continuous slope, level at both ends, without overshoot (Fritsch and Carlson, SIAM J. Numer.
  // Anal. 17, 1980).
  enum class Interpolation { hold, linear, cubic };
  Interpolation interpolation = Interpolation::linear;
  std::vector<double> times;   // s, increasing; constant before the first and after the last entry
  std::vector<double> values;  // one for each time; empty: no table

  double mean = 0.0;       // of the sinusoid; the constant
  double amplitude = 0.0;  // mean + amplitude sin(2 pi frequency t + phase)
  double frequency = 0.0;  // Hz
  double phase = 0.0;      // rad
};

// A signal for springs and elements whose laws have an input of a name. Where several signals are given to one of
// them for the same input, the last one counts; without a signal the input has the value that its law declares.
struct Input {
  std::string input;  // as laws declare it: "activation"
  std::string name;   // for Simulation::set_input; may be empty, else unique
  std::vector<SpringIndex> springs;
  std::vector<std::uint32_t> elements;
  Signal signal;
};

}  // namespace springnet
