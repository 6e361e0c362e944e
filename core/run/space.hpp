// Whether the output of a run fits on the disk, and what to do if not.
#pragma once

#include <optional>
#include <string>

#include <springnet/scene.hpp>

namespace springnet {

// Room for a run's output, bytes.
struct Space {
  double free = 0.0;     // on the disk
  double earlier = 0.0;  // in files of an earlier run, which this one removes
  // Leaves a share of the free space to others.
  [[nodiscard]] double available() const noexcept { return 0.98 * free + earlier; }
};

// Why the output does not fit, with remedies; empty if it fits. `folder` is for the message.
[[nodiscard]] std::optional<std::string> space_refusal(const Scene& scene, const Space& space,
                                                       const std::string& folder);

// The smallest output.interval, s, rounded up to two digits, with which the output takes at most `bytes`; empty if
// there is none.
[[nodiscard]] std::optional<double> interval_for(const Scene& scene, double bytes);

}  // namespace springnet
