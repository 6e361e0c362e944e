// What the page of a learned net has beside that of a run: values with their intervals, and places that were observed.
#pragma once

#include <ostream>

#include "view/content.hpp"

namespace springnet::view {

// Throws Error(input) for springs, nodes and elements that the network does not have.
void check(const LearnedView& learned, const Network& network);

// Bytes, before base64: of all values; of the observed places in a frame, at most; of both and of the motion of the
// start, for a spring in a frame, on average.
[[nodiscard]] double values_bytes(const Content& content);
[[nodiscard]] double observed_bytes(const LearnedView* learned);
[[nodiscard]] double learned_cost(const LearnedView& learned, const Network& network, double frames);

// What was observed is in the frame next to its time; of each kind of a node only what is nearest to that of the frame.
struct ObservedFrames {
  std::vector<std::uint32_t> first;  // of each frame, and the number of all
  std::vector<std::uint32_t> nodes;  // places in the selection; not_shown: of none that is shown
  std::vector<float> points;         // x, y, z of each
  std::vector<std::uint8_t> kinds;   // ViewPoint::What, and 4 more of what was held out
};
[[nodiscard]] ObservedFrames observed_frames(const LearnedView& learned, const std::vector<double>& times,
                                             const Selection& selection);

void write_learned(std::ostream& out, const Content& content);

}  // namespace springnet::view
