// The laws of a unit's springs with their derivatives, segment by segment, for what goes over springs without a matrix.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "layers/evaluator.hpp"
#include "layers/law_pair.hpp"
#include "layers/linear/spring_kernels.hpp"

namespace springnet::layers {

class AxialSegments {
 public:
  // References must outlive it.
  AxialSegments(const Layout& layout, const Evaluator& evaluator) : layout_(layout), evaluator_(evaluator) {}

  // Takes memory for all threads of the evaluator: an exception that left one would end the process.
  void reserve();
  // Evaluates the laws of a unit at a state, in any thread after reserve(). use(AxialAnswers): of each segment, whether
  // to go on. places: [slot of the unit], for AxialAnswers. False: a law failed, or `use` did not go on.
  template <class Use>
  [[nodiscard]] bool for_each(std::size_t unit, double time, const NodeArrays& nodes,
                              const std::vector<std::uint32_t>& places, const Use& use) const;

 private:
  struct Scratch {
    SegmentGeometry geometry;
    PairAnswers<max_segment> answers;
  };
  [[nodiscard]] Scratch& own_scratch() const;
  // False: a law failed.
  [[nodiscard]] bool answer(const Unit& unit, const Segment& segment, double time, const NodeArrays& nodes,
                            const std::vector<std::uint32_t>& places, Scratch& scratch, AxialAnswers& answers) const;

  const Layout& layout_;
  const Evaluator& evaluator_;
  std::vector<std::unique_ptr<Scratch>> scratch_;  // [thread]
};

template <class Use>
bool AxialSegments::for_each(std::size_t index, double time, const NodeArrays& nodes,
                             const std::vector<std::uint32_t>& places, const Use& use) const {
  const Unit& unit = layout_.units()[index];
  Scratch& scratch = own_scratch();
  for (const Segment& segment : unit.segments) {
    if (segment.dead == segment.count) continue;
    AxialAnswers answers{};
    if (!answer(unit, segment, time, nodes, places, scratch, answers) || !use(answers)) return false;
  }
  return true;
}

}  // namespace springnet::layers
