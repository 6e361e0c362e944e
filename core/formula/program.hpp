// Some nodes of a graph as a list of steps on tiles of numbers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formula/graph.hpp"

namespace springnet::formula {

// Where a step reads and writes: first the inputs of the graph that the program reads, then its constants, then memory.
using Place = std::uint32_t;

struct ProgramStep {
  Code code;
  std::uint8_t arguments;
  std::array<Place, 5> from;
  Place to, also;       // also: of a second result, or `to`
  std::uint32_t index;  // of a table
};

struct Program {
  std::vector<std::uint32_t> inputs;  // numbers of the inputs that it reads, ascending
  std::vector<double> constants;
  std::uint32_t slots = 0;  // of memory
  std::vector<ProgramStep> steps;
  std::vector<Place> outputs;  // one for each node asked for
  bool has_functions = false;  // any step but sums, products and choices

  [[nodiscard]] Place first_constant() const { return static_cast<Place>(inputs.size()); }
  [[nodiscard]] Place first_slot() const { return static_cast<Place>(inputs.size() + constants.size()); }
  [[nodiscard]] std::size_t places() const { return first_slot() + slots; }
};

// often_same(input): the input is likely to be one number for a whole batch. What depends on such inputs alone keeps a
// slot of its own, so that it can be computed once.
template <class OftenSame>
[[nodiscard]] Program schedule(const Graph& graph, std::span<const Node> outputs, const OftenSame& often_same);

// Of one program: forces and tangent of a law over seven scalars have 7 + 7 * 14.
inline constexpr std::size_t max_outputs = 128;
// Numbers of a tile: as many as a call of the engine has, so that it is one tile; and no power of two, for which the
// same number of all slots would compete for the same lines of the cache.
inline constexpr std::size_t tile_size = 448;

// What evaluates the curve of a table, or its first or second derivative (order), at x.
class Curves {
 public:
  Curves() = default;
  Curves(const Curves&) = delete;
  Curves& operator=(const Curves&) = delete;
  virtual ~Curves() = default;
  virtual void evaluate(std::uint32_t table, unsigned order, const double* x, double* out, std::size_t count) const = 0;
};

struct Batch {
  std::size_t count;
  const double* const* inputs;   // by their numbers in the graph
  const std::uint32_t* strides;  // likewise, 0 or 1
  const Curves* curves;          // may be null if the graph has no curve
  std::uint32_t instruction_set;
};
// outputs: arrays of `count` numbers, null where not wanted. Results do not depend on the instruction set.
void run(const Program& program, const Batch& batch, double* const* outputs);

// ---- inline

namespace detail {
[[nodiscard]] Program schedule(const Graph& graph, std::span<const Node> outputs, const std::vector<bool>& often_same);
}
template <class OftenSame>
Program schedule(const Graph& graph, std::span<const Node> outputs, const OftenSame& often_same) {
  std::vector<bool> same(graph.size(), false);
  for (Node node = 0; node < graph.size(); ++node)
    same[node] = graph[node].code == Code::input && often_same(graph[node].index);
  return detail::schedule(graph, outputs, same);
}

}  // namespace springnet::formula
