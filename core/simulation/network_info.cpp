#include "simulation/network_info.hpp"

namespace springnet {

const springnet_network& NetworkInfo::now() {
  info_.load_revision = model_.load_revision;
  if (revision_ == model_.revision) return info_;
  revision_ = model_.revision;
  const layers::Layout& layout = model_.layout;
  const Contact& contact = model_.contact;
  no_cluster_.assign(model_.rigid.any() ? 0 : model_.node_count(), ConstraintRow::no_node);
  info_.struct_size = sizeof info_;
  info_.node_count = model_.node_count();
  info_.spring_count = layout.live_count();
  info_.internal_count = layout.internal().count();
  internal_ranges_.clear();
  for (const springnet_internal_range& range : layout.internal().ranges()) internal_ranges_.push_back(&range);
  info_.internal_ranges = internal_ranges_.data();
  info_.internal_range_count = internal_ranges_.size();
  info_.spring_number_count = layout.spring_count();
  info_.element_number_count = layout.elements().count();
  info_.input_count = layout.laws().inputs.size();
  info_.revision = model_.revision;
  info_.unit_count = static_cast<std::uint32_t>(layout.units().size());
  info_.event_count = static_cast<std::uint32_t>(events_.count());
  info_.surface_count = static_cast<std::uint32_t>(contact.obstacles().size());
  info_.body_contact_count = static_cast<std::uint32_t>(model_.constraints.bodies().count());
  info_.length_scale = model_.scales.length;
  info_.velocity_scale = model_.scales.velocity;
  info_.force_scale = model_.scales.force;
  info_.mass = model_.mass.data();
  info_.fixed = contact.fixed().data();
  info_.held = contact.held().data();
  info_.user_number = layout.ordering().user.data();
  info_.neighbour_start = info_.neighbours = nullptr;
  if (layout.has_neighbours()) add_neighbours();
  info_.connection_revision = layout.revision();
  info_.touching = contact.touching().data();
  info_.cluster = model_.rigid.any() ? model_.rigid.cluster_of() : no_cluster_.data();
  info_.rigid_count = model_.rigid.rods().size();
  info_.status = contact.status().data();
  const BodyPushes& pushes = model_.constraints.pushes();
  info_.pushed = pushes.pushed().data();
  info_.pushed_count = &pushes.count();
  return info_;
}

void NetworkInfo::add_neighbours() {
  info_.neighbour_start = model_.layout.neighbour_start().data();
  info_.neighbours = model_.layout.neighbours().data();
}

const springnet_network& NetworkInfo::with_neighbours() {
  static_cast<void>(now());
  add_neighbours();
  return info_;
}

}  // namespace springnet
