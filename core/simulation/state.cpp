#include "simulation/state.hpp"

#include <utility>

namespace springnet {

std::uint32_t pitch_of(std::uint32_t nodes) noexcept { return (nodes + 7) / 8 * 8 + 24; }

State::State(std::uint32_t nodes) : memory(9 * std::size_t{pitch_of(nodes)}, 0.0) {
  view.struct_size = sizeof view;
  const std::size_t pitch = pitch_of(nodes);
  double* at = memory.data();
  for (springnet_vectors* vectors : {&view.position, &view.velocity, &view.force}) {
    *vectors = {at, at + pitch, at + 2 * pitch};
    at += 3 * pitch;
  }
}

void State::swap(State& other) noexcept {
  std::swap(view, other.view);
  memory.swap(other.memory);
}

layers::NodeArrays State::nodes() const noexcept {
  return {view.position.x, view.position.y, view.position.z, view.velocity.x, view.velocity.y, view.velocity.z};
}

}  // namespace springnet
