#include <algorithm>
#include <functional>
#include <memory>
#include <numeric>

#include <Eigen/Geometry>

#include "tables/names.hpp"
#include "tables/table.hpp"

namespace springnet::tables {

Table reactions();

namespace {

RowCount count_reaction_rows(const Network& network, const OutputOptions& options) {
  const std::vector<NodeIndex> nodes = chosen_or_all(options.nodes, network.nodes().size());
  // Any node may come to rest on a surface, and be in contact with this many at once.
  constexpr std::size_t max_surfaces = 3;
  const auto rows = static_cast<double>(std::count_if(nodes.begin(), nodes.end(), [&](NodeIndex node) {
    return surface_count(network) > 0 || network.nodes()[node].fixed;
  }));
  std::vector<double> labels = label_lengths(network);
  std::sort(labels.begin(), labels.end(), std::greater<>());
  labels.resize(std::min(labels.size(), max_surfaces));
  for (double& label : labels) label += 1.0;  // ';'
  return {rows, static_cast<double>(network.nodes().size()), rows * std::accumulate(labels.begin(), labels.end(), 0.0)};
}

class ReactionRows {
 public:
  ReactionRows(const Network& network, const OutputOptions& options)
      : nodes_(chosen_or_all(options.nodes, network.nodes().size())), impulses_(nodes_.size(), Vector3::Zero()) {
    fixed_.reserve(nodes_.size());
    for (const NodeIndex node : nodes_) fixed_.push_back(network.nodes()[node].fixed);
  }

  void operator()(const Record& record, TableFile& file) {
    const Simulation& simulation = record.simulation();
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const NodeIndex node = nodes_[k];
      const Vector3 impulse = simulation.contact_impulse(node);
      const bool struck = impulse != impulses_[k];  // since the last record, even if it is free again
      impulses_[k] = impulse;
      if (!fixed_[k] && !struck && !simulation.touching(node)) continue;
      const Vector3 reaction = simulation.reaction(node);
      const Vector3 torque = simulation.position(node).cross(reaction);
      file.row(record.time());
      file << node << reaction << torque << impulse << labels_of(simulation, simulation.surfaces_of(node));
    }
  }
  void archive(Archive& archive) { archive.vectors(impulses_, "impulses"); }

 private:
  std::vector<NodeIndex> nodes_;
  std::vector<bool> fixed_;        // of nodes_
  std::vector<Vector3> impulses_;  // N s, of nodes_ at the last record
};

}  // namespace

Table reactions() {
  return {
      .name = "reactions",
      .content = "forces that hold or move nodes, if output.reactions = true",
      .columns =
          {{{"node"}, "", "number of the node", Columns::Cell::count},
           {{"fx", "fy", "fz"}, "N", "reaction that holds or moves the node, without the forces of rigid connections"},
           {{"tx", "ty", "tz"}, "N m", "its torque about the origin"},
           {{"jx", "jy", "jz"}, "N s", "sum of the contact impulses that surfaces gave the node since the start"},
           {{"surface"},
            "",
            "the surfaces that the node is in contact with, as in `surfaces.csv`, joined by `;`",
            Columns::Cell::text}},
      .wanted = [](const Network&, const OutputOptions& options) { return options.reactions; },
      .leave_out_hint = "leave out {} (output.reactions = false)",
      .rows = count_reaction_rows,
      .writer = [](const Network& network, const OutputOptions& options) -> RowWriter {
        const auto rows = std::make_shared<ReactionRows>(network, options);
        return {[rows](const Record& record, TableFile& file) { (*rows)(record, file); },
                [rows](Archive& archive) { rows->archive(archive); }};
      },
  };
}

}  // namespace springnet::tables
