#include "layers/elements/enclosure_volumes.hpp"

#include <algorithm>
#include <array>

namespace springnet::layers {
namespace {

// The arrays of a state in the order of base_.
std::array<const double*, 6> arrays_of(const NodeArrays& nodes) {
  return {nodes.px, nodes.py, nodes.pz, nodes.vx, nodes.vy, nodes.vz};
}

}  // namespace

void EnclosureVolumes::compute(const ElementLayout& elements, const NodeArrays& nodes) {
  elements_ = &elements;
  following_ = false;
  values_.resize(elements.enclosures().size());
  for (std::size_t s = 0; s < values_.size(); ++s) {
    const ElementLayout::EnclosureElement& enclosure = elements.enclosures()[s];
    if (elements.alive(enclosure.element)) values_[s] = enclosure.shape.values(nodes);
  }
}

void EnclosureVolumes::follow(const ElementLayout& elements, const NodeArrays& nodes) {
  compute(elements, nodes);
  const std::array<const double*, 6> from = arrays_of(nodes);
  std::uint32_t end = 0;
  for (const ElementLayout::EnclosureElement& enclosure : elements.enclosures())
    end = std::max(end, enclosure.shape.nodes().back());
  for (std::size_t c = 0; c < 6; ++c) base_[c].assign(from[c], from[c] + end + 1);
  now_ = nodes;
  following_ = true;
}

void EnclosureVolumes::change_since_commit(std::uint32_t node, Vector3& position, Vector3& velocity) const noexcept {
  const std::array<const double*, 6> now = arrays_of(now_);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto row = static_cast<Eigen::Index>(c);
    position[row] = now[c][node] - base_[c][node];
    velocity[row] = now[c + 3][node] - base_[c + 3][node];
  }
}

Enclosure::Values EnclosureVolumes::values_for(std::uint32_t node, std::uint32_t enclosure, const Vector3& gradient,
                                               const Vector3& rate_gradient) const noexcept {
  Enclosure::Values seen = values_[enclosure];
  if (!following_) return seen;
  Vector3 position, velocity;
  change_since_commit(node, position, velocity);
  seen.volume += gradient.dot(position);
  seen.rate += rate_gradient.dot(position) + gradient.dot(velocity);
  return seen;
}

void EnclosureVolumes::commit(std::uint32_t node) {
  bool is_in_enclosure = false;
  for (const ElementShare& share : elements_->shares(node)) {
    if (share.enclosure == no_enclosure) continue;
    const Enclosure& enclosure = elements_->enclosures()[share.enclosure].shape;
    values_[share.enclosure] = values_for(node, share.enclosure, enclosure.gradient(share.place, base()),
                                          enclosure.rate_gradient(share.place, base()));
    is_in_enclosure = true;
  }
  if (!is_in_enclosure) return;
  const std::array<const double*, 6> now = arrays_of(now_);
  for (std::size_t c = 0; c < 6; ++c) base_[c][node] = now[c][node];
}

}  // namespace springnet::layers
