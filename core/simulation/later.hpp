// What is given over time, as it is seen from a later beginning: in a network that begins at the present of another one
// the time starts at 0 again.
#pragma once

#include <optional>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/signal.hpp>

namespace springnet {

// The motion after `time` (s), relative to the displacement that it has then; empty if it is at rest from then on.
[[nodiscard]] std::optional<Motion> later(const Motion& motion, double time);
[[nodiscard]] std::optional<Turn> later(const Turn& turn, double time);
// Empty if it is over.
[[nodiscard]] std::optional<Load> later(const Load& load, double time);
[[nodiscard]] Signal later(const Signal& signal, double time);

}  // namespace springnet
