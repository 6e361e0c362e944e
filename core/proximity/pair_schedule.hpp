// When pairs of a list may next be close. Between two looks at a pair its gap falls at most by what nodes have moved
// relative to each other meanwhile, so that one with a wide gap needs no look for long.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "proximity/primitives.hpp"

namespace springnet::proximity {

class PairSchedule {
 public:
  // All pairs of the lists are due. skin: m, > 0: gaps that the lists cover.
  void reset(const PairLists& pairs, double skin);

  // In canonical order, the pairs of the lists whose gap at `x` is at most `reach` (m, >= 0). moved: m, a bound of how
  // far any two nodes have moved relative to each other, on their way here, since the last call.
  void find_close(const Primitives& primitives, const PairLists& pairs, const Positions& x, double moved, double reach,
                  PairLists& close);

 private:
  [[nodiscard]] std::int64_t slot_number(double due) const;
  [[nodiscard]] std::vector<std::uint32_t>& slot(std::int64_t number);
  void put(std::uint32_t item);

  double width_ = 0.0;                             // m, of a slot
  double far_ = 0.0;                               // m, a gap of pairs whose distance is not looked at more closely
  double path_ = 0.0;                              // m, sum of `moved`
  std::int64_t first_ = 0;                         // number of the first slot that may have pairs
  std::vector<double> due_;                        // m, [pair]: the path after which to look again
  std::vector<std::vector<std::uint32_t>> slots_;  // [number modulo their count] pairs
  std::vector<std::uint32_t> taken_, seen_, close_;
};

}  // namespace springnet::proximity
