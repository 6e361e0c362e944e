#pragma once

#include <cstddef>

#include <springnet/export.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// Numbers of events so far, by kind.
struct EventCounts {
  std::size_t cut = 0;               // springs
  std::size_t ruptured = 0;          // springs
  std::size_t elements_removed = 0;  // cut or ruptured, those of more than two nodes
  std::size_t touched = 0;           // nodes; each time counts
  std::size_t released = 0;          // nodes; each time counts
  std::size_t slipped = 0;           // nodes, and pairs where their events are located; each time counts
  std::size_t stuck = 0;             // likewise
  std::size_t jammed = 0;            // nodes; each time counts
  std::size_t met = 0;               // pairs of nodes, edges, faces of bodies; each time counts
  std::size_t parted = 0;            // likewise
};

[[nodiscard]] SPRINGNET_API EventCounts count_events(const Simulation& simulation);

}  // namespace springnet
