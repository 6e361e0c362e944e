#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <springnet/error.hpp>
#include <springnet/output.hpp>
#include <springnet/view.hpp>

#include "view/content.hpp"
#include "view/floors.hpp"
#include "files/whole_file.hpp"

namespace springnet {

namespace {

using view::Content;
using view::Frames;

// A run that diverges has numbers that no float holds.
float to_float(double number) {
  constexpr double most = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(number, -most, most));
}

// Frames that a motion should have at least to be seen as one, before springs are left out for their sake.
constexpr double wanted_frames = 60.0;

double expected_records(const Scene& scene) {
  return std::floor(scene.duration / std::max(scene.output.interval, scene.options.time_step)) + 2.0;
}

view::Selection select(const Scene& scene, double size) {
  const double frames = std::min(expected_records(scene), wanted_frames);
  return view::select(scene.network, frames, 0.75 * std::max(size - view::program_size(), 0.0));
}

view::FrameWidths widths_of(const Network& network, const view::Selection& selection, std::size_t elements,
                            const view::Forces& forces) {
  return {view::fixed_scalars + elements,
          selection.nodes.size(),
          selection.springs.size(),
          network.planes().size() + network.instruments().size(),
          forces.loads.size(),
          forces.arrows.size()};
}

Content make_content(const Scene& scene, double size) {
  Content content{scene, select(scene, size), view::plotted_elements(scene.network), {}, Frames({0, 0, 0, 0}, 2, 0), {},
                  {}};
  content.forces = view::forces_of(scene.network, content.selection);
  const double room = (size - view::size_once(content)) / view::size_of_frame(content, true);
  const auto capacity = static_cast<std::size_t>(std::clamp(room, 2.0, 1e9));
  content.frames = Frames(widths_of(scene.network, content.selection, content.elements.size(), content.forces),
                          capacity, static_cast<std::size_t>(std::min(expected_records(scene), 1e6)));
  return content;
}

constexpr std::string_view not_ended = R"(<!DOCTYPE html>
<meta charset="utf-8"><title>springnet: no page yet</title>
<p>The run that writes this page has not ended, or was ended from outside. The page is written when a run ends, also
when it fails; springnet run again makes it.</p>
)";

}  // namespace

struct ViewWriter::Impl {
  Impl(const OutputFile& path, const Scene& scene, const ViewOptions& options)
      : file(path), size(options.size), content(make_content(scene, size)) {
    content.plugins = options.plugins;
    left_out = content.selection.notes;
    left_out.insert(left_out.end(), content.forces.notes.begin(), content.forces.notes.end());
  }

  void take_events(const Simulation& simulation) {
    const std::vector<Event>& all = simulation.events();
    for (; seen < all.size(); ++seen) {
      const Event& event = all[seen];
      if (event.element) continue;  // of springs and nodes alone
      ++counts.at(static_cast<std::size_t>(event.kind));
      const bool ruptured = event.kind == Event::Kind::ruptured;
      if (ruptured || event.kind == Event::Kind::cut) {
        content.removed.push_back({event.index, event.time, content.frames.recorded() - 1, ruptured});
      }
    }
  }

  void take_scalars(const Simulation& simulation) {
    const auto row = content.frames.scalars.last();
    row[view::time] = simulation.time();
    row[view::kinetic] = simulation.kinetic_energy();
    row[view::potential] = simulation.potential_energy();
    row[view::steps] = static_cast<double>(simulation.steps());
    row[view::sweeps] = static_cast<double>(simulation.sweeps());
    for (std::size_t k = 0; k < counts.size(); ++k) row[view::events + k] = static_cast<double>(counts[k]);
    for (std::size_t k = 0; k < content.elements.size(); ++k) {
      row[view::fixed_scalars + k] = simulation.element_value(content.elements[k]);
    }
  }

  void take_nodes(const Simulation& simulation) {
    const auto positions = content.frames.positions.last();
    const auto speeds = content.frames.speeds.last();
    const auto contact = content.frames.contact.last();
    std::fill(contact.begin(), contact.end(), std::uint8_t{0});
    const ConstNodeMap all_positions = simulation.positions(), velocities = simulation.velocities();
    const bool surfaces = simulation.surface_count() > 0;
    for (std::size_t k = 0; k < content.selection.nodes.size(); ++k) {
      const NodeIndex node = content.selection.nodes[k];
      const auto column = static_cast<Eigen::Index>(simulation.columns()[node]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        positions[3 * k + axis] = to_float(all_positions(static_cast<Eigen::Index>(axis), column));
      }
      speeds[k] = to_float(velocities.col(column).norm());
      if (surfaces && simulation.touching(node)) {
        contact[k / 8] = static_cast<std::uint8_t>(contact[k / 8] | 1U << k % 8);
      }
    }
  }

  void take_springs(const Simulation& simulation) {
    simulation.tensions(tensions);
    const auto row = content.frames.tensions.last();
    for (std::size_t k = 0; k < row.size(); ++k) row[k] = to_float(tensions[content.selection.springs[k]]);
  }

  void take_surfaces(const Simulation& simulation) {
    const auto row = content.frames.surfaces.last();
    for (std::size_t k = 0; k < simulation.surface_count(); ++k) {
      Eigen::Vector<double, view::surface_numbers> pose;
      pose << simulation.surface_position(k), Eigen::Quaterniond(simulation.surface_rotation(k)).coeffs();
      for (std::size_t i = 0; i < view::surface_numbers; ++i) {
        row[view::surface_numbers * k + i] = to_float(pose[static_cast<Eigen::Index>(i)]);
      }
    }
  }

  void tell_what_is_missing(const std::optional<view::Ranges>& rounded) {
    const Frames& frames = content.frames;
    if (frames.count() < frames.recorded()) {
      left_out.push_back(
          fmt::format("{} of {} records are shown, one in {} and the last; a larger "
                      "output.view_size shows more",
                      frames.count(), frames.recorded(), frames.stride()));
    }
    const double least = view::size_once(content) + 2.0 * view::size_of_frame(content, true);
    if (least > size) {
      left_out.push_back(fmt::format(
          "the page is larger than output.view_size, {}: its program alone takes {}, the network and its "
          "first and last record {}",
          readable_bytes(size), readable_bytes(view::program_size()), readable_bytes(least - view::program_size())));
    }
    if (!rounded) return;
    const std::vector<std::string> notes = view::notes_of(*rounded);
    left_out.insert(left_out.end(), notes.begin(), notes.end());
  }

  OutputFile file;
  double size;
  Content content;
  std::array<std::uint64_t, 7> counts{};  // of each kind of event
  std::size_t seen = 0;                   // events
  std::vector<double> tensions;           // N, by the user's spring
  std::vector<std::string> left_out;
  bool closed = false;
};

ViewWriter::ViewWriter(const OutputFile& file, const Scene& scene, const ViewOptions& options)
    : impl_(std::make_unique<Impl>(file, scene, options)) {
  CheckedFile out(file, CheckedFile::make_room);
  out.write(not_ended.data(), not_ended.size());
  out.close();
}

ViewWriter::~ViewWriter() {
  try {
    close();
  } catch (...) {  // nobody is there to hear of it
  }
}

void ViewWriter::record(const Simulation& simulation) {
  Impl& impl = *impl_;
  impl.content.frames.begin();
  impl.take_events(simulation);
  impl.take_scalars(simulation);
  impl.take_nodes(simulation);
  impl.take_springs(simulation);
  impl.take_surfaces(simulation);
  view::take_forces(impl.content.forces, impl.content.scene.network, simulation, impl.content.frames.resultants.last(),
                    impl.content.frames.forces.last());
}

void ViewWriter::failed(const std::string& reason) { impl_->content.failure = reason; }

void ViewWriter::close() {
  Impl& impl = *impl_;
  if (impl.closed || impl.content.frames.count() == 0) return;
  impl.closed = true;
  view::drop_rounding(view::floors_of(impl.content.scene, impl.content.selection, impl.content.plugins.get()),
                      impl.content.frames);
  std::optional<view::Ranges> rounded;
  if (view::must_round(impl.content, impl.size)) rounded = view::ranges_of(impl.content.frames);
  impl.tell_what_is_missing(rounded);
  impl.content.notes = impl.left_out;
  try {
    WholeFile page(impl.file);
    view::write_page(page.stream(), impl.content, rounded);
    page.finish();
  } catch (...) {
    remove_output(impl.file);  // the page that stands there says that the run goes on
    throw;
  }
}

const std::vector<std::string>& ViewWriter::left_out() const noexcept { return impl_->left_out; }

double estimate_view(const Scene& scene) {
  if (!scene.output.view) return 0.0;
  const Content content = make_content(scene, scene.output.view_size);
  const double all = view::size_once(content) + expected_records(scene) * view::size_of_frame(content, false);
  // The first and the last record stand in the page whatever its size.
  const double least = view::size_once(content) + 2.0 * view::size_of_frame(content, true);
  return std::min(all, std::max(least, scene.output.view_size));
}

}  // namespace springnet
