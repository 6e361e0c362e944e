// Moved nodes from a table of their places over time, as cameras track them.
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "network/checks.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"
#include "scene/time_table.hpp"

namespace springnet::scene {
namespace {

// As for points of a mesh: squares have to be finite.
constexpr double farthest = 1e100;

void read_track(const Table& table, const Value& file, const Files& files, Network& network) {
  refuse_beside(table, {"select", "table", "sinusoid", "from", "until"}, "tracks");
  NodeIndex first = 0;
  std::size_t count = network.nodes().size();
  if (const auto name = table.find("body")) {
    const Body& body = find_body(*name, network);
    first = body.first_node;
    count = body.node_count;
  }
  const CsvColumns rows = files.csv_columns(file, {"time", "node", "x", "y", "z"});
  std::map<NodeIndex, Motion> tracks;
  for (std::size_t row = 0; row < rows.lines.size(); ++row) {
    const auto fail = [&](const std::string& what) { file.fail(fmt::format("{}: {}", rows.place(row), what)); };
    const double time = rows.values[0][row], number = rows.values[1][row];
    if (!(number >= 0.0 && number < static_cast<double>(count)) || number != std::floor(number))
      fail(fmt::format("there is no node {:g}, the {} has {}, numbered from 0", number,
                       table.has("body") ? "body" : "scene", count));
    const NodeIndex node = first + static_cast<NodeIndex>(number);
    Motion& motion = tracks[node];
    if (!motion.times.empty() && !(motion.times.back() < time))
      fail(fmt::format("times of a node must increase, but {} follows {}; sort the rows, and give each time once",
                       checks::seconds(time), checks::seconds(motion.times.back())));
    const Vector3 place(rows.values[2][row], rows.values[3][row], rows.values[4][row]);
    if (!(place.cwiseAbs().maxCoeff() <= farthest))
      fail(fmt::format("the place is farther than {:g} m away", farthest));
    const Vector3 displacement = place - network.nodes()[node].position;
    if (!motion.times.empty() &&
        !((displacement - motion.displacements.back()).norm() / (time - motion.times.back()) <= farthest))
      fail(fmt::format("the node would move faster than {:g} m/s to get here from its row before", farthest));
    motion.times.push_back(time);
    motion.displacements.push_back(displacement);
  }
  if (tracks.empty()) file.fail("has no rows; give time,node,x,y,z for each place");
  const Motion::Interpolation interpolation = read_interpolation(table);
  for (auto& [node, motion] : tracks) {
    if (motion.times.size() < 2) file.fail(fmt::format("node {} has one row; a track needs two or more", node - first));
    motion.interpolation = interpolation;
    file.at_this_place([&, node = node, &motion = motion] { network.add_move({{node}, std::move(motion)}); });
  }
}

}  // namespace

void read_tracks(const Table& root, const Files& files, Network& network) {
  for (const Value& value : root.tables("move")) {
    const Table table = value.table("move");
    if (const auto file = table.find("tracks")) read_track(table, *file, files, network);
  }
}

}  // namespace springnet::scene
