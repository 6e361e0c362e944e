#include "record/record.hpp"

namespace springnet {

Record::Record(const Network& network) : springs_(network.springs().ends()) {}

void Record::take(const Simulation& simulation) {
  simulation_ = &simulation;
  const auto forget = [](auto&... quantities) { ((quantities.known = false), ...); };
  forget(positions_, velocities_, forces_, lengths_, tensions_, energies_, elements_, surface_loads_, kinetic_,
         potential_);
}

void Record::by_user(const ConstNodeMap& from, Vectors& to) const {
  const std::vector<std::uint32_t>& columns = simulation_->columns();
  to.resize(3, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    to.col(static_cast<Eigen::Index>(k)) = from.col(static_cast<Eigen::Index>(columns[k]));
  }
}

const Record::Vectors& Record::positions() const {
  return once(positions_, [&](Vectors& out) { by_user(simulation_->positions(), out); });
}

const Record::Vectors& Record::velocities() const {
  return once(velocities_, [&](Vectors& out) { by_user(simulation_->velocities(), out); });
}

const Record::Vectors& Record::forces() const {
  return once(forces_, [&](Vectors& out) { by_user(simulation_->forces(), out); });
}

const std::vector<double>& Record::lengths() const {
  return once(lengths_, [&](std::vector<double>& out) {
    const Vectors& at = positions();
    out.resize(springs_.size());
    for (std::size_t k = 0; k < springs_.size(); ++k) {
      const auto& [first, second] = springs_[k];
      out[k] = (at.col(static_cast<Eigen::Index>(second)) - at.col(static_cast<Eigen::Index>(first))).norm();
    }
  });
}

const std::vector<double>& Record::tensions() const {
  return once(tensions_, [&](std::vector<double>& out) { simulation_->tensions(out); });
}

const std::vector<double>& Record::energies() const {
  return once(energies_, [&](std::vector<double>& out) { simulation_->spring_energies(out); });
}

// One by one, because a volume takes a pass over its surface and most readers need few elements.
double Record::element_value(ElementIndex element) const {
  static_cast<void>(once(elements_, [&](auto& values) { values.assign(simulation_->element_count(), std::nullopt); }));
  std::optional<double>& value = elements_.value.at(element);
  if (!value) value = simulation_->element_value(element);
  return *value;
}

const std::vector<Record::SurfaceLoad>& Record::surface_loads() const {
  return once(surface_loads_, [&](std::vector<SurfaceLoad>& out) {
    out.clear();
    for (std::size_t k = 0; k < simulation_->surface_count(); ++k) {
      out.push_back({simulation_->surface_force(k), simulation_->nodes_touching(k)});
    }
  });
}

double Record::kinetic_energy() const {
  return once(kinetic_, [&](double& out) { out = simulation_->kinetic_energy(); });
}

double Record::potential_energy() const {
  return once(potential_, [&](double& out) { out = simulation_->potential_energy(); });
}

}  // namespace springnet
