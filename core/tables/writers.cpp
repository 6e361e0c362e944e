#include <array>
#include <string_view>

#include <Eigen/Geometry>
#include <springnet/output.hpp>

#include "tables/csv_file.hpp"
#include "tables/table_file.hpp"

namespace springnet {

namespace {

// The name of a surface; its number if it has none.
std::string label_of(const Simulation& simulation, std::size_t surface) {
  const std::string& name = simulation.surface_name(surface);
  return name.empty() ? std::to_string(surface) : name;
}

// "floor", "floor;wall"
std::string labels_of(const Simulation& simulation, const std::vector<std::size_t>& surfaces) {
  std::string text;
  for (const std::size_t surface : surfaces) {
    if (!text.empty()) text += ';';
    text += label_of(simulation, surface);
  }
  return text;
}

}  // namespace

TrajectoryWriter::TrajectoryWriter(const OutputFile& file, const Network& network, const OutputOptions& options)
    : position_(options.position), velocity_(options.velocity), force_(options.force) {
  TableForm form = trajectory_form(network, options);
  nodes_ = form.numbers;
  values_.resize(nodes_.size() * form.columns.size());
  file_ = create_table(file, std::move(form), options);
}

TrajectoryWriter::~TrajectoryWriter() = default;

void TrajectoryWriter::record(const Simulation& simulation) {
  const std::vector<std::uint32_t>& columns = simulation.columns();
  const std::size_t width = nodes_.empty() ? 0 : values_.size() / nodes_.size();
  std::size_t first = 0;  // column of the quantity
  const auto fill = [&](const ConstNodeMap& quantity) {
    double* row = values_.data() + first;
    for (const NodeIndex node : nodes_) {
      const auto column = static_cast<Eigen::Index>(columns[node]);
      for (Eigen::Index axis = 0; axis < 3; ++axis) row[axis] = quantity(axis, column);
      row += width;
    }
    first += 3;
  };
  if (position_) fill(simulation.positions());
  if (velocity_) fill(simulation.velocities());
  if (force_) fill(simulation.forces());
  file_->record(simulation.time(), values_);
}

void TrajectoryWriter::close() { file_->close(); }

SpringWriter::SpringWriter(const OutputFile& file, const Network& network, const OutputOptions& options)
    : file_(create_table(file, spring_form(options), options)) {
  springs_.reserve(options.springs.size());
  for (const SpringIndex index : options.springs) {
    const Spring& spring = network.springs().at(index);
    springs_.push_back({index, spring.first, spring.second});
  }
  values_.resize(springs_.size() * 4);
}

SpringWriter::~SpringWriter() = default;

void SpringWriter::record(const Simulation& simulation) {
  simulation.tensions(tensions_);
  simulation.spring_energies(energies_);
  double* value = values_.data();
  for (const Ends& ends : springs_) {
    *value++ = (simulation.position(ends.second) - simulation.position(ends.first)).norm();
    *value++ = tensions_[ends.spring];
    *value++ = energies_[ends.spring];
    *value++ = simulation.alive(ends.spring) ? 1.0 : 0.0;
  }
  file_->record(simulation.time(), values_);
}

void SpringWriter::close() { file_->close(); }

ElementWriter::ElementWriter(const OutputFile& file, const Network& network, const OutputOptions& options) {
  TableForm form = element_form(network, options);
  elements_ = form.numbers;
  values_.resize(3 * elements_.size());
  file_ = create_table(file, std::move(form), options);
}

ElementWriter::~ElementWriter() = default;

void ElementWriter::record(const Simulation& simulation) {
  double* value = values_.data();
  for (const ElementIndex element : elements_) {
    *value++ = simulation.element_value(element);
    *value++ = simulation.element_force(element);
    *value++ = simulation.element_alive(element) ? 1.0 : 0.0;
  }
  file_->record(simulation.time(), values_);
}

void ElementWriter::close() { file_->close(); }

ReactionWriter::ReactionWriter(const OutputFile& file, const Network& network, const OutputOptions& options)
    : file_(std::make_unique<CsvFile>(file, "time,node,fx,fy,fz,tx,ty,tz,jx,jy,jz,surface")),
      nodes_(trajectory_form(network, options).numbers),
      impulses_(nodes_.size(), Vector3::Zero()) {
  fixed_.reserve(nodes_.size());
  for (const NodeIndex node : nodes_) fixed_.push_back(network.nodes().at(node).fixed);
}

ReactionWriter::~ReactionWriter() = default;

void ReactionWriter::record(const Simulation& simulation) {
  CsvFile& out = *file_;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const NodeIndex node = nodes_[k];
    const Vector3 impulse = simulation.contact_impulse(node);
    const bool bounced = impulse != impulses_[k];  // since the last record, though it may be free again
    impulses_[k] = impulse;
    if (!fixed_[k] && !bounced && !simulation.touching(node)) continue;
    const Vector3 reaction = simulation.reaction(node);
    const Vector3 torque = simulation.position(node).cross(reaction);
    out << simulation.time() << ',' << node << reaction << torque << impulse << ',';
    out << csv_cell(labels_of(simulation, simulation.surfaces_of(node))) << '\n';
  }
  out.end_record(simulation.time());
}

void ReactionWriter::close() { file_->close(); }

SurfaceWriter::SurfaceWriter(const OutputFile& file)
    : file_(std::make_unique<CsvFile>(file, "time,surface,x,y,z,fx,fy,fz,tx,ty,tz,nodes,jx,jy,jz")) {}

SurfaceWriter::~SurfaceWriter() = default;

void SurfaceWriter::record(const Simulation& simulation) {
  CsvFile& out = *file_;
  for (std::size_t surface = 0; surface < simulation.surface_count(); ++surface) {
    out << simulation.time() << ',' << csv_cell(label_of(simulation, surface));
    out << simulation.surface_position(surface) << simulation.surface_force(surface)
        << simulation.surface_torque(surface) << ',' << static_cast<std::uint32_t>(simulation.nodes_touching(surface))
        << simulation.surface_impulse(surface) << '\n';
  }
  out.end_record(simulation.time());
}

void SurfaceWriter::close() { file_->close(); }

RigidWriter::RigidWriter(const OutputFile& file, const Network& network)
    : file_(std::make_unique<CsvFile>(file, "time,rigid,force")),
      count_(static_cast<RigidIndex>(network.rigids().size())) {}

RigidWriter::~RigidWriter() = default;

void RigidWriter::record(const Simulation& simulation) {
  for (RigidIndex rigid = 0; rigid < count_; ++rigid) {
    *file_ << simulation.time() << ',' << rigid << ',' << simulation.rigid_force(rigid) << '\n';
  }
  file_->end_record(simulation.time());
}

void RigidWriter::close() { file_->close(); }

EventWriter::EventWriter(const OutputFile& file)
    : file_(std::make_unique<CsvFile>(file, "time,event,element,index,surface,jx,jy,jz")) {}

EventWriter::~EventWriter() = default;

void EventWriter::record(const Simulation& simulation) {
  struct Words {
    std::string_view event, element;
  };
  static constexpr std::array<Words, 7> words{{{"cut", "spring"},
                                               {"ruptured", "spring"},
                                               {"touched", "node"},
                                               {"released", "node"},
                                               {"slipped", "node"},
                                               {"stuck", "node"},
                                               {"jammed", "node"}}};
  const std::vector<Event>& events = simulation.events();
  CsvFile& out = *file_;
  for (; written_ < events.size(); ++written_) {
    const Event& event = events[written_];
    const Words& what = words.at(static_cast<std::size_t>(event.kind));
    out << event.time << ',' << what.event << ',' << (event.element ? "element" : what.element) << ',' << event.index
        << ',';
    if (event.surface >= 0) out << csv_cell(label_of(simulation, static_cast<std::size_t>(event.surface)));
    out << event.impulse << '\n';
  }
  out.end_record(simulation.time());
}

void EventWriter::close() { file_->close(); }

}  // namespace springnet
