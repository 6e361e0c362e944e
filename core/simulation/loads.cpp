#include "simulation/loads.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace springnet {

Loads::Loads(const Network& network, const std::vector<std::uint32_t>& engine_number)
    : gravity_(network.gravity()), node_count_(network.nodes().size()) {
  for (const Load& load : network.loads()) {
    Entry entry{{}, load.force, load.from, load.until, 0.0};
    for (const NodeIndex node : load.nodes) entry.nodes.push_back(engine_number[node]);
    entries_.push_back(std::move(entry));
  }
}

bool Loads::set_interval(double from, double until) {
  bool changed = false;
  for (Entry& entry : entries_) {
    double weight = 0.0;
    if (std::isfinite(until) && until > from) {
      const double overlap = std::min(until, entry.until) - std::max(from, entry.from);
      // Steps that end where a load is switched do so up to rounding of the time.
      const double share = overlap / (until - from);
      weight = share < 1e-9 ? 0.0 : share > 1.0 - 1e-9 ? 1.0 : share;
    } else {
      weight = entry.from <= from && from < entry.until ? 1.0 : 0.0;
    }
    changed = changed || weight != entry.weight;
    entry.weight = weight;
  }
  if (changed) gather();
  return changed;
}

double Loads::next_switch(double time) const noexcept {
  double next = std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    if (entry.from > time) next = std::min(next, entry.from);
    if (entry.until > time) next = std::min(next, entry.until);
  }
  return next;
}

void Loads::set_host_force(std::uint32_t node, const Vector3& force) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (host_[c].empty()) host_[c].assign(node_count_, 0.0);
    host_[c][node] = force[static_cast<Eigen::Index>(c)];
  }
  gather();
}

void Loads::gather() {
  for (std::size_t c = 0; c < 3; ++c) {
    if (host_[c].empty())
      total_[c].assign(node_count_, 0.0);
    else
      total_[c] = host_[c];
    for (const Entry& entry : entries_) {
      if (entry.weight == 0.0) continue;
      for (const std::uint32_t node : entry.nodes)
        total_[c][node] += entry.weight * entry.force[static_cast<Eigen::Index>(c)];
    }
  }
}

layers::ExternalForces Loads::external() noexcept {
  layers::ExternalForces external;
  external.gravity = gravity_;
  if (!total_[0].empty()) external.loads = {total_[0].data(), total_[1].data(), total_[2].data()};
  return external;
}

double Loads::greatest() const noexcept {
  double greatest = 0.0;
  for (const Entry& entry : entries_) greatest = std::max(greatest, entry.force.norm());
  return greatest;
}

}  // namespace springnet
