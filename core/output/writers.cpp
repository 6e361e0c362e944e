#include <array>
#include <string_view>

#include <Eigen/Geometry>
#include <springnet/output.hpp>

#include "output/csv_file.hpp"

namespace springnet {

TrajectoryWriter::TrajectoryWriter(const std::filesystem::path& file)
    : file_(std::make_unique<CsvFile>(file, "time,node,x,y,z,vx,vy,vz")) {}

TrajectoryWriter::~TrajectoryWriter() = default;

void TrajectoryWriter::record(const Simulation& simulation) {
  const double time = simulation.time();
  const ConstNodeMap positions = simulation.positions();
  const ConstNodeMap velocities = simulation.velocities();
  const std::vector<std::uint32_t>& columns = simulation.columns();
  CsvFile& out = *file_;
  for (NodeIndex node = 0; node < columns.size(); ++node) {
    const auto column = static_cast<Eigen::Index>(columns[node]);
    out << time << ',' << node << Vector3(positions.col(column)) << Vector3(velocities.col(column)) << '\n';
  }
}

void TrajectoryWriter::close() { file_->close(); }

ReactionWriter::ReactionWriter(const std::filesystem::path& file, const Network& network)
    : file_(std::make_unique<CsvFile>(file, "time,node,fx,fy,fz,tx,ty,tz")) {
  fixed_.reserve(network.nodes().size());
  for (const Node& node : network.nodes()) fixed_.push_back(node.fixed);
}

ReactionWriter::~ReactionWriter() = default;

void ReactionWriter::record(const Simulation& simulation) {
  CsvFile& out = *file_;
  for (NodeIndex node = 0; node < fixed_.size(); ++node) {
    if (!fixed_[node] && !simulation.touching(node)) continue;
    const Vector3 reaction = simulation.reaction(node);
    const Vector3 torque = simulation.position(node).cross(reaction);
    out << simulation.time() << ',' << node << reaction << torque << '\n';
  }
}

void ReactionWriter::close() { file_->close(); }

SurfaceWriter::SurfaceWriter(const std::filesystem::path& file)
    : file_(std::make_unique<CsvFile>(file, "time,surface,x,y,z,fx,fy,fz,tx,ty,tz,nodes")) {}

SurfaceWriter::~SurfaceWriter() = default;

void SurfaceWriter::record(const Simulation& simulation) {
  CsvFile& out = *file_;
  for (std::size_t surface = 0; surface < simulation.surface_count(); ++surface) {
    const std::string& name = simulation.surface_name(surface);
    out << simulation.time() << ',';
    if (name.empty()) {
      out << static_cast<std::uint32_t>(surface);
    } else {
      out << csv_cell(name);
    }
    out << simulation.surface_position(surface) << simulation.surface_force(surface)
        << simulation.surface_torque(surface) << ',' << static_cast<std::uint32_t>(simulation.nodes_touching(surface))
        << '\n';
  }
}

void SurfaceWriter::close() { file_->close(); }

RigidWriter::RigidWriter(const std::filesystem::path& file, const Network& network)
    : file_(std::make_unique<CsvFile>(file, "time,rigid,force")),
      count_(static_cast<RigidIndex>(network.rigids().size())) {}

RigidWriter::~RigidWriter() = default;

void RigidWriter::record(const Simulation& simulation) {
  for (RigidIndex rigid = 0; rigid < count_; ++rigid) {
    *file_ << simulation.time() << ',' << rigid << ',' << simulation.rigid_force(rigid) << '\n';
  }
}

void RigidWriter::close() { file_->close(); }

EventWriter::EventWriter(const std::filesystem::path& file)
    : file_(std::make_unique<CsvFile>(file, "time,event,element,index")) {}

EventWriter::~EventWriter() = default;

void EventWriter::record(const Simulation& simulation) {
  struct Words {
    std::string_view event, element;
  };
  static constexpr std::array<Words, 6> words{{{"cut", "spring"},
                                               {"ruptured", "spring"},
                                               {"touched", "node"},
                                               {"released", "node"},
                                               {"slipped", "node"},
                                               {"stuck", "node"}}};
  const std::vector<Event>& events = simulation.events();
  CsvFile& out = *file_;
  for (; written_ < events.size(); ++written_) {
    const Event& event = events[written_];
    const Words& what = words.at(static_cast<std::size_t>(event.kind));
    out << event.time << ',' << what.event << ',' << (event.element ? "element" : what.element) << ',' << event.index
        << '\n';
  }
}

void EventWriter::close() { file_->close(); }

}  // namespace springnet
