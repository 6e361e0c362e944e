// The content of a page.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>
#include <springnet/view.hpp>

#include "view/forces.hpp"
#include "view/frames.hpp"
#include "view/rounding.hpp"
#include "view/selection.hpp"
#include "view/states.hpp"

namespace springnet::view {

// Numbers of a frame besides those of nodes, springs and surfaces; the chosen elements' values follow.
enum Scalar : std::size_t { time, kinetic, potential, steps, sweeps, events, fixed_scalars = events + 9 };

struct Removal {
  SpringIndex spring;
  double time;           // s
  std::uint64_t record;  // the first record without it
  bool ruptured;         // else cut
};

struct Content {
  const Scene& scene;
  Selection selection;
  std::vector<ElementIndex> elements;  // whose values are plotted
  Forces forces;
  Frames frames;
  std::vector<Removal> removed;
  std::vector<std::string> notes;
  std::string failure{};                        // why the run failed; empty if it did not
  std::shared_ptr<const PluginHost> plugins{};  // for the units of laws
  std::vector<LawStates> law_states{};          // laws of springs and elements that have internal states
  States states{};
  std::size_t touches = 0;                       // of bodies that a frame has room for
  std::shared_ptr<const LearnedView> learned{};  // null: the page of a run
};

// Elements that get a curve: all if they are few, else the enclosed volumes.
[[nodiscard]] std::vector<ElementIndex> plotted_elements(const Network& network);

// Bytes of the page's program, without any data.
[[nodiscard]] double program_bytes();

// Bytes of the page without frames, and of a frame.
[[nodiscard]] double base_bytes(const Content& content);
[[nodiscard]] double frame_bytes(const Content& content, bool rounded);

// Whether the numbers of nodes and springs must be rounded to 16 bits to keep the page below `size` bytes.
[[nodiscard]] bool must_round(const Content& content, double size);

// With 16 bit numbers in these ranges, or with 32 bit floats.
struct Motion {
  const Content& content;
  std::optional<Ranges> rounded;
};

// A page that plays them, one at a time, the first one first.
void write_page(std::ostream& out, const std::vector<Motion>& motions);

}  // namespace springnet::view
