#include "view/page_writer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <springnet/readable.hpp>

#include "files/whole_file.hpp"
#include "view/floors.hpp"
#include "view/learned.hpp"
#include "view/touches.hpp"

namespace springnet::view {

namespace {

// Fewer frames do not show a motion: springs are left out to have this many.
constexpr double min_frames = 60.0;

double expected_records(const Scene& scene) {
  return std::floor(scene.duration / std::max(scene.output.interval, scene.options.time_step)) + 2.0;
}

Selection select(const Scene& scene, const States& states, double size, const LearnedView* learned) {
  const double frames = std::min(expected_records(scene), min_frames);
  double more = 4.0 * mean_states(scene.network, states);
  if (learned != nullptr) more += learned_cost(*learned, scene.network, frames);
  return view::select(scene.network, frames, 0.75 * std::max(size - program_bytes(), 0.0), more);
}

FrameWidths widths_of(const Content& content) {
  const Network& network = content.scene.network;
  return {fixed_scalars + content.elements.size(),
          content.selection.nodes.size(),
          content.selection.springs.size(),
          network.planes().size() + network.instruments().size(),
          content.forces.loads.size(),
          content.forces.arrows.size(),
          content.states.numbers,
          content.learned ? content.selection.nodes.size() : 0,
          content.touches};
}

Content make_content(const Scene& scene, double size, const PluginHost* plugins,
                     const std::shared_ptr<const LearnedView>& learned = nullptr) {
  if (learned) check(*learned, scene.network);
  std::vector<LawStates> law_states =
      plugins != nullptr ? find_law_states(scene.network, *plugins) : scene.output.law_states;
  States states = states_of(scene.network, law_states);
  Content content{scene,
                  select(scene, states, size, learned.get()),
                  plotted_elements(scene.network),
                  {},
                  Frames({0, 0, 0, 0}, 2, 0),
                  {},
                  {}};
  content.law_states = std::move(law_states);
  content.states = std::move(states);
  content.learned = learned;
  count_states(scene.network, content.selection, content.states);
  content.forces = forces_of(scene.network, content.selection);
  content.touches = touch_capacity(scene.network);
  const double max_frames = (size - base_bytes(content)) / frame_bytes(content, true);
  const auto capacity = static_cast<std::size_t>(std::clamp(max_frames, 2.0, 1e9));
  content.frames =
      Frames(widths_of(content), capacity, static_cast<std::size_t>(std::min(expected_records(scene), 1e6)));
  return content;
}

constexpr std::string_view not_ended = R"(<!DOCTYPE html>
<meta charset="utf-8"><title>springnet: no page yet</title>
<p>The run has not ended, or was killed. The page is written when a run ends, even if it fails: reload it then, or run
springnet again.</p>
)";

}  // namespace

PageWriter::PageWriter(const OutputFile& file, const Scene& scene, const ViewOptions& options, bool resumes)
    : PageWriter(scene, options) {
  file_ = file;
  closed_ = resumes;
  if (!resumes) go_on();
}

PageWriter::PageWriter(const Scene& scene, const ViewOptions& options)
    : size_(program_bytes() + options.share * (options.size - program_bytes())),
      content_(make_content(scene, size_, options.plugins.get(), options.learned)) {
  content_.plugins = options.plugins;
  left_out_ = content_.selection.notes;
  left_out_.insert(left_out_.end(), content_.forces.notes.begin(), content_.forces.notes.end());
  if (content_.learned)
    left_out_.insert(left_out_.begin(), content_.learned->notes.begin(), content_.learned->notes.end());
}

void PageWriter::go_on() {
  CheckedFile out(*file_, CheckedFile::make_room);
  out.write(not_ended.data(), not_ended.size());
  out.close();
  closed_ = false;
}

PageWriter::~PageWriter() {
  try {
    close();
  } catch (...) {  // a destructor has nobody to report to
  }
}

void PageWriter::record(const Record& record) {
  content_.frames.begin();
  take_events(record.simulation());
  take_scalars(record);
  const std::vector<BodyTouch> touches = record.simulation().body_touches();
  take_nodes(record.simulation(), touches);
  take_springs(record);
  take_surfaces(record.simulation());
  take_forces(content_.forces, content_.scene.network, record.simulation(), content_.frames.resultants.last(),
              content_.frames.forces.last());
  const std::uint64_t with_force = take_touches(touches, content_.selection, content_.frames.touches.last());
  most_touches_ = std::max(most_touches_, with_force);
  take_states(content_.states, content_.scene.network, content_.selection, record.simulation(),
              content_.frames.states.last());
}

void PageWriter::archive(Archive& archive) {
  content_.frames.archive(archive);
  std::vector<Removal>& removed = content_.removed;
  constexpr std::size_t least = sizeof(SpringIndex) + sizeof(double) + sizeof(std::uint64_t) + 1;
  removed.resize(archive.count(removed.size(), least, "removed springs"));
  for (Removal& each : removed) {
    archive.below(each.spring, content_.scene.network.springs().size(), "a removed spring");
    archive.number(each.time);
    archive.number(each.record);
    archive.flag(each.ruptured);
  }
  archive.numbers(counts_.data(), counts_.size());
  archive.number(events_read_);
  archive.number(most_touches_);
}

void PageWriter::take_events(const Simulation& simulation) {
  const std::vector<Event>& all = simulation.events();
  for (; events_read_ < all.size(); ++events_read_) {
    const Event& event = all[events_read_];
    if (event.element) continue;  // only springs and nodes are counted
    ++counts_.at(static_cast<std::size_t>(event.kind));
    const bool ruptured = event.kind == Event::Kind::ruptured;
    if (ruptured || event.kind == Event::Kind::cut) {
      content_.removed.push_back({event.index, event.time, content_.frames.recorded() - 1, ruptured});
    }
  }
}

void PageWriter::take_scalars(const Record& record) {
  const Simulation& simulation = record.simulation();
  const auto row = content_.frames.scalars.last();
  row[time] = record.time();
  row[kinetic] = record.kinetic_energy();
  row[potential] = record.potential_energy();
  row[steps] = static_cast<double>(simulation.steps());
  row[sweeps] = static_cast<double>(simulation.sweeps());
  for (std::size_t k = 0; k < counts_.size(); ++k) row[events + k] = static_cast<double>(counts_[k]);
  for (std::size_t k = 0; k < content_.elements.size(); ++k) {
    row[fixed_scalars + k] = record.element_value(content_.elements[k]);
  }
}

void PageWriter::record_start(const Simulation& simulation) {
  if (content_.learned) take_positions(simulation, content_.frames.start_positions.last());
}

void PageWriter::take_positions(const Simulation& simulation, std::span<float> out) const {
  const ConstNodeMap positions = simulation.positions();
  for (std::size_t k = 0; k < content_.selection.nodes.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(simulation.columns()[content_.selection.nodes[k]]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[3 * k + axis] = to_float(positions(static_cast<Eigen::Index>(axis), column));
  }
}

void PageWriter::take_nodes(const Simulation& simulation, const std::vector<BodyTouch>& touches) {
  take_positions(simulation, content_.frames.positions.last());
  if (content_.learned) record_start(simulation);  // until it is told
  const auto speeds = content_.frames.speeds.last();
  const auto contact = content_.frames.contact.last();
  std::fill(contact.begin(), contact.end(), std::uint8_t{0});
  const ConstNodeMap velocities = simulation.velocities();
  const bool surfaces = simulation.surface_count() > 0;
  std::set<NodeIndex> of_bodies;
  for (const BodyTouch& touch : touches) of_bodies.insert(touch.nodes.begin(), touch.nodes.begin() + touch.count);
  for (std::size_t k = 0; k < content_.selection.nodes.size(); ++k) {
    const NodeIndex node = content_.selection.nodes[k];
    const auto column = static_cast<Eigen::Index>(simulation.columns()[node]);
    speeds[k] = to_float(velocities.col(column).norm());
    if ((surfaces && simulation.touching(node)) || of_bodies.contains(node)) {
      contact[k / 8] = static_cast<std::uint8_t>(contact[k / 8] | 1U << k % 8);
    }
  }
}

void PageWriter::take_springs(const Record& record) {
  const std::vector<double>& tensions = record.tensions();
  const auto row = content_.frames.tensions.last();
  for (std::size_t k = 0; k < row.size(); ++k) row[k] = to_float(tensions[content_.selection.springs[k]]);
}

void PageWriter::take_surfaces(const Simulation& simulation) {
  const auto row = content_.frames.surfaces.last();
  for (std::size_t k = 0; k < simulation.surface_count(); ++k) {
    Eigen::Vector<double, surface_numbers> pose;
    pose << simulation.surface_position(k), Eigen::Quaterniond(simulation.surface_rotation(k)).coeffs();
    for (std::size_t i = 0; i < surface_numbers; ++i) {
      row[surface_numbers * k + i] = to_float(pose[static_cast<Eigen::Index>(i)]);
    }
  }
}

void PageWriter::note_omissions(const std::optional<Ranges>& rounded) {
  const Frames& frames = content_.frames;
  if (frames.count() < frames.recorded()) {
    left_out_.push_back(
        fmt::format("{} of {} records are shown: one in {}, and the last; a larger output.view_size shows more",
                    frames.count(), frames.recorded(), frames.stride()));
  }
  if (most_touches_ > content_.touches) {
    left_out_.push_back(
        fmt::format("of up to {} pairs in contact at a time, the {} with the largest forces have arrows", most_touches_,
                    content_.touches));
  }
  const double min_bytes = base_bytes(content_) + 2.0 * frame_bytes(content_, true);
  if (min_bytes > size_) {
    left_out_.push_back(fmt::format(
        "the page is larger than output.view_size, {}: its program alone takes {}, the network with its first and last "
        "record {}",
        readable_bytes(size_), readable_bytes(program_bytes()), readable_bytes(min_bytes - program_bytes())));
  }
  if (!rounded) return;
  const std::vector<std::string> notes = notes_of(*rounded);
  left_out_.insert(left_out_.end(), notes.begin(), notes.end());
}

Motion PageWriter::finished() {
  drop_rounding(floors_of(content_.scene, content_.selection, content_.plugins.get()), content_.frames);
  std::optional<Ranges> rounded;
  if (must_round(content_, size_)) rounded = ranges_of(content_.frames);
  note_omissions(rounded);
  content_.notes = left_out_;
  return {content_, rounded};
}

void PageWriter::close() {
  if (!file_ || closed_ || content_.frames.count() == 0) return;
  closed_ = true;
  std::vector<Motion> motions{finished()};
  for (PageWriter* const each : others_)
    if (each->content_.frames.count() > 0) motions.push_back(each->finished());
  try {
    WholeFile page(*file_);
    write_page(page.stream(), motions);
    page.finish();
  } catch (...) {
    remove_output(*file_);  // the page written at the start, which says that the run has not ended
    throw;
  }
}

}  // namespace springnet::view

namespace springnet {

double estimate_view(const Scene& scene) {
  if (!scene.output.view) return 0.0;
  const view::Content content = view::make_content(scene, scene.output.view_size, nullptr);
  const double base = view::base_bytes(content);
  const double all = base + view::expected_records(scene) * view::frame_bytes(content, false);
  // The first and the last record are always there, whatever the size.
  const double min_bytes = base + 2.0 * view::frame_bytes(content, true);
  return std::min(all, std::max(min_bytes, scene.output.view_size));
}

}  // namespace springnet
