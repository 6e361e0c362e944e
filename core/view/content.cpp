#include "view/content.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "view/base64.hpp"
#include "view/blocks.hpp"
#include "view/description.hpp"
#include "view/learned.hpp"
#include "view/page.hpp"
#include "view/pair.hpp"

namespace springnet::view {

namespace {

constexpr std::uint32_t never = not_shown;

void write_frames(std::ostream& out, const Frames& frames, const std::optional<Ranges>& ranges) {
  write_block(out, "scalars", frames.scalars.numbers());
  write_block(out, "surface_poses", frames.surfaces.numbers());
  write_block(out, "contact", frames.contact.numbers());
  write_block(out, "load_resultants", frames.resultants.numbers());
  write_block(out, "arrow_forces", frames.forces.numbers());
  write_block(out, "touches", frames.touches.numbers());
  write_block(out, "states", frames.states.numbers());
  if (ranges) {
    write_rounded(out, "positions", frames.positions.numbers(), ranges->positions);
    write_rounded(out, "start_positions", frames.start_positions.numbers(), ranges->positions);
    write_rounded(out, "speeds", frames.speeds.numbers(), ranges->speeds);
    write_rounded(out, "tensions", frames.tensions.numbers(), ranges->tensions);
  } else {
    write_block(out, "positions", frames.positions.numbers());
    write_block(out, "start_positions", frames.start_positions.numbers());
    write_block(out, "speeds", frames.speeds.numbers());
    write_block(out, "tensions", frames.tensions.numbers());
  }
}

// The first frame at or after a record.
std::uint32_t frame_of(std::uint64_t record, const Frames& frames) {
  const std::uint64_t frame = (record + frames.stride() - 1) / frames.stride();
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(frame, frames.count() - 1));
}

void write_nodes(std::ostream& out, const Content& content) {
  const Network& network = content.scene.network;
  std::vector<float> masses;
  std::vector<std::uint8_t> kinds;
  for (const NodeIndex node : content.selection.nodes) {
    masses.push_back(static_cast<float>(network.nodes()[node].mass));
    kinds.push_back(network.nodes()[node].fixed ? 1 : 0);
  }
  for (const Move& move : network.moves()) {
    for (const NodeIndex node : move.nodes) {
      const std::uint32_t place = content.selection.node_place[node];
      if (place != not_shown) kinds[place] = 2;
    }
  }
  write_block(out, "node_numbers", content.selection.nodes);
  write_block(out, "node_masses", masses);
  write_block(out, "node_kinds", kinds);
}

void write_springs(std::ostream& out, const Content& content) {
  const Network& network = content.scene.network;
  const std::vector<std::uint32_t>& place = content.selection.node_place;
  std::vector<std::uint32_t> ends, materials, rigids;
  std::vector<float> rest_lengths;
  for (const SpringIndex k : content.selection.springs) {
    const Spring& spring = network.springs()[k];
    ends.insert(ends.end(), {place[spring.first], place[spring.second]});
    rest_lengths.push_back(static_cast<float>(spring.rest_length));
    materials.push_back(spring.material);
  }
  for (const Rigid& rigid : network.rigids()) rigids.insert(rigids.end(), {place[rigid.first], place[rigid.second]});
  write_block(out, "spring_numbers", content.selection.springs);
  write_block(out, "spring_ends", ends);
  write_block(out, "spring_rest_lengths", rest_lengths);
  write_block(out, "spring_materials", materials);
  write_block(out, "rigid_ends", rigids);

  std::vector<std::uint32_t> removed, frames;
  std::vector<double> times;
  std::vector<std::uint8_t> kinds;
  for (const Removal& removal : content.removed) {
    if (content.selection.spring_place[removal.spring] == not_shown) continue;
    removed.push_back(content.selection.spring_place[removal.spring]);
    frames.push_back(frame_of(removal.record, content.frames));
    times.push_back(removal.time);
    kinds.push_back(removal.ruptured ? 1 : 0);
  }
  write_block(out, "removed_springs", removed);
  write_block(out, "removed_frames", frames);
  write_block(out, "removed_times", times);
  write_block(out, "removed_kinds", kinds);
}

void write_arrows(std::ostream& out, const Forces& forces) {
  std::vector<std::uint32_t> nodes;
  for (const Arrow& arrow : forces.arrows) nodes.push_back(arrow.node);
  write_block(out, "arrow_nodes", nodes);
}

// A triangle is torn once a spring along one of its edges is removed.
void write_faces(std::ostream& out, const Content& content) {
  const Network& network = content.scene.network;
  std::vector<std::uint32_t> corners, torn;
  if (content.selection.faces) {
    std::unordered_map<std::uint64_t, std::uint32_t> removal_frames;  // by the ends of the spring
    for (const Removal& removal : content.removed) {
      const Spring& spring = network.springs()[removal.spring];
      removal_frames.try_emplace(pair_of(spring.first, spring.second), frame_of(removal.record, content.frames));
    }
    for (const Face& face : network.faces()) {
      std::uint32_t frame = never;
      for (std::size_t k = 0; k < 3; ++k) {
        corners.push_back(content.selection.node_place[face[k]]);
        const auto edge = removal_frames.find(pair_of(face[k], face[(k + 1) % 3]));
        if (edge != removal_frames.end()) frame = std::min(frame, edge->second);
      }
      torn.push_back(frame);
    }
  }
  write_block(out, "faces", corners);
  write_block(out, "face_frames", torn);
}

void write_motion(std::ostream& out, const Motion& motion, const std::vector<std::string>& titles) {
  const Content& content = motion.content;
  out << "<script type=\"application/json\" id=\"description\">"
      << describe(content, motion.rounded.has_value(), titles) << "</script>\n";
  write_nodes(out, content);
  write_springs(out, content);
  write_arrows(out, content.forces);
  write_faces(out, content);
  write_frames(out, content.frames, motion.rounded);
  if (content.learned) write_learned(out, content);
}

// Before base64.
double raw_frame_bytes(const Content& content, bool rounded) {
  const auto nodes = static_cast<double>(content.selection.nodes.size());
  const auto springs = static_cast<double>(content.selection.springs.size());
  const auto surfaces =
      static_cast<double>(content.scene.network.planes().size() + content.scene.network.instruments().size());
  const auto arrows = static_cast<double>(content.forces.loads.size() + content.forces.arrows.size());
  const double start = content.learned ? 3.0 * nodes : 0.0;
  return (rounded ? 2.0 : 4.0) * (4.0 * nodes + start + springs) + std::ceil(nodes / 8.0) + 28.0 * surfaces +
         12.0 * arrows + 4.0 * static_cast<double>(touch_numbers * content.touches) +
         4.0 * static_cast<double>(content.states.numbers) +
         8.0 * static_cast<double>(fixed_scalars + content.elements.size()) + observed_bytes(content.learned.get());
}

}  // namespace

std::vector<ElementIndex> plotted_elements(const Network& network) {
  constexpr std::size_t max_curves = 8;  // that the eye can distinguish
  std::vector<ElementIndex> chosen;
  for (ElementIndex k = 0; k < network.elements().size() && chosen.size() < max_curves; ++k) {
    if (network.elements().size() <= max_curves || network.elements()[k].invariant == Invariant::enclosed_volume) {
      chosen.push_back(k);
    }
  }
  return chosen;
}

double program_bytes() { return static_cast<double>(before_data.size() + after_data.size()); }

double base_bytes(const Content& content) {
  const Network& network = content.scene.network;
  constexpr double words = 4000.0;  // the description's keys, the blocks' elements
  double text = words + static_cast<double>(content.scene.title.size());
  text += 200.0 * static_cast<double>(network.bodies().size() + network.materials().size() + content.elements.size());
  text += 400.0 * static_cast<double>(network.planes().size() + network.instruments().size());
  text += 60.0 * static_cast<double>(content.forces.loads.size());
  text += 200.0 * static_cast<double>(content.states.all.size());
  double bytes = cost_of(static_cast<double>(content.selection.nodes.size()),
                         static_cast<double>(content.selection.springs.size()))
                     .once;
  bytes += 8.0 * static_cast<double>(network.rigids().size());
  if (content.selection.faces) bytes += 16.0 * static_cast<double>(network.faces().size());
  bytes += 17.0 * static_cast<double>(content.removed.size());
  bytes += 4.0 * static_cast<double>(content.forces.arrows.size());
  if (content.learned) {
    text += static_cast<double>(content.learned->below.size());
    bytes += values_bytes(content);
  }
  return program_bytes() + text + base64_size(bytes);
}

double frame_bytes(const Content& content, bool rounded) { return base64_size(raw_frame_bytes(content, rounded)); }

bool must_round(const Content& content, double size) {
  const double frames = static_cast<double>(content.frames.count());
  return base_bytes(content) + frames * frame_bytes(content, false) > size;
}

void write_page(std::ostream& out, const std::vector<Motion>& motions) {
  std::vector<std::string> titles;
  for (const Motion& each : motions) titles.push_back(each.content.scene.title);
  out << before_data;
  write_motion(out, motions.front(), titles);
  if (motions.front().content.learned) out << motions.front().content.learned->below;
  // What is in a template is not part of the page until its program looks for it, so names do not clash.
  for (std::size_t k = 1; k < motions.size(); ++k) {
    out << "<template id=\"motion" << k + 1 << "\">\n";
    write_motion(out, motions[k], titles);
    out << "</template>\n";
  }
  out << after_data;
}

}  // namespace springnet::view
