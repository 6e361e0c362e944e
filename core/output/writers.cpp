#include <array>
#include <string_view>

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
    out << time << ',' << node;
    const auto column = static_cast<Eigen::Index>(columns[node]);
    for (Eigen::Index axis = 0; axis < 3; ++axis) out << ',' << positions(axis, column);
    for (Eigen::Index axis = 0; axis < 3; ++axis) out << ',' << velocities(axis, column);
    out << '\n';
  }
}

void TrajectoryWriter::close() { file_->close(); }

ReactionWriter::ReactionWriter(const std::filesystem::path& file, const Network& network)
    : file_(std::make_unique<CsvFile>(file, "time,node,fx,fy,fz")) {
  fixed_.reserve(network.nodes().size());
  for (const Node& node : network.nodes()) fixed_.push_back(node.fixed);
}

ReactionWriter::~ReactionWriter() = default;

void ReactionWriter::record(const Simulation& simulation) {
  CsvFile& out = *file_;
  for (NodeIndex node = 0; node < fixed_.size(); ++node) {
    if (!fixed_[node] && !simulation.held(node)) continue;
    const Vector3 reaction = simulation.reaction(node);
    out << simulation.time() << ',' << node << ',' << reaction.x() << ',' << reaction.y() << ',' << reaction.z()
        << '\n';
  }
}

void ReactionWriter::close() { file_->close(); }

EventWriter::EventWriter(const std::filesystem::path& file)
    : file_(std::make_unique<CsvFile>(file, "time,event,element,index")) {}

EventWriter::~EventWriter() = default;

void EventWriter::record(const Simulation& simulation) {
  struct Words {
    std::string_view event, element;
  };
  static constexpr std::array<Words, 4> words{
      {{"cut", "spring"}, {"ruptured", "spring"}, {"touched", "node"}, {"released", "node"}}};
  const std::vector<Event>& events = simulation.events();
  CsvFile& out = *file_;
  for (; written_ < events.size(); ++written_) {
    const Event& event = events[written_];
    const Words& what = words.at(static_cast<std::size_t>(event.kind));
    out << event.time << ',' << what.event << ',' << what.element << ',' << event.index << '\n';
  }
}

void EventWriter::close() { file_->close(); }

}  // namespace springnet
