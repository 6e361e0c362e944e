#include "mesh/builder.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <springnet/printable.hpp>

#include "text/counted.hpp"

namespace springnet::meshes {
namespace {

constexpr std::size_t max_count = std::numeric_limits<std::uint32_t>::max();

constexpr std::size_t tell_every = std::size_t{1} << 16;  // points or cells

// m. Volumes, its third powers, stay far within the range of a double.
constexpr double largest_coordinate = 1e100;

// Limit of the cells in all groups together: base_limit + max_groups_per_cell times the cells of the mesh.
constexpr std::size_t max_groups_per_cell = 100, base_cell_limit = 1'000'000;

constexpr std::size_t max_names = 5, max_notes = 20, max_name_length = 40;

void sort_unique(std::vector<std::uint32_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

std::uint32_t Builder::add_point(const Vector3& position, Place place) {
  if (!position.allFinite()) {
    source_.fail(place, "a coordinate of this point is not finite; correct the mesh where it was made");
  }
  if (position.cwiseAbs().maxCoeff() > largest_coordinate) {
    source_.fail(place, fmt::format("this point is farther away than {} m; correct the mesh where it was made",
                                    largest_coordinate));
  }
  if (mesh_.points.size() % tell_every == 0) source_.tell(place);
  if (mesh_.points.size() >= max_count) source_.fail(place, fmt::format("a mesh has at most {} points", max_count));
  mesh_.points.push_back(position);
  return static_cast<std::uint32_t>(mesh_.points.size() - 1);
}

void Builder::add_cell(CellType type, std::span<const std::uint32_t> corners, Place place) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (corners[i] != corners[j]) continue;
      source_.fail(place, fmt::format("corners {} and {} of this {} are the same point; correct or remove the cell",
                                      j + 1, i + 1, name_of(type)));
    }
  }
  if (mesh_.cell_count() % tell_every == 0) source_.tell(place);
  if (mesh_.cell_count() >= max_count) source_.fail(place, fmt::format("a mesh has at most {} cells", max_count));
  mesh_.add_cell(type, corners);
}

void Builder::add_polygon(std::span<const std::uint32_t> corners, Place place) {
  if (corners.size() < 3) {
    source_.fail(place, fmt::format("a polygon of {} corners; it needs three or more", corners.size()));
  }
  if (corners.size() <= 4) {
    add_cell(corners.size() == 3 ? CellType::triangle : CellType::quadrilateral, corners, place);
    return;
  }
  std::vector<std::uint32_t> sorted(corners.begin(), corners.end());
  sort_unique(sorted);
  if (sorted.size() != corners.size()) {
    source_.fail(place, "this polygon has a point twice; correct or remove it");
  }
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    add_cell(CellType::triangle, std::array{corners[0], corners[i], corners[i + 1]}, place);
  }
  count_note("polygon of more than four corners is divided into triangles around its first corner",
             "polygons of more than four corners are divided into triangles around their first corner");
}

std::size_t Builder::group(const std::string& name) {
  const auto [entry, is_new] = group_of_name_.emplace(name, mesh_.groups.size());
  if (is_new) {
    mesh_.groups.push_back({name, {}, {}});
    cells_of_group_.emplace_back();
  }
  return entry->second;
}

void Builder::add_cells_to_group(std::size_t group, std::size_t first_cell, std::size_t end_cell) {
  if (first_cell == end_cell) return;
  grouped_cells_ += end_cell - first_cell;
  if (grouped_cells_ > base_cell_limit + max_groups_per_cell * mesh_.cell_count()) {
    source_.fail(
        fmt::format("groups have {} cells in total, of {} cells so far; the file is damaged or has too many groups: "
                    "save it with fewer",
                    grouped_cells_, mesh_.cell_count()));
  }
  std::vector<Range>& ranges = cells_of_group_[group];
  if (!ranges.empty() && ranges.back().second == first_cell) {
    ranges.back().second = end_cell;
  } else {
    ranges.emplace_back(first_cell, end_cell);
  }
}

void Builder::add_point_to_group(std::size_t group, std::uint32_t point) {
  mesh_.groups[group].points.push_back(point);
}

std::vector<bool> Builder::used_points() const {
  std::vector<bool> used(mesh_.points.size(), false);
  for (const std::uint32_t corner : mesh_.corners) used[corner] = true;
  return used;
}

void Builder::note(const std::string& sentence) {
  if (notes_so_far_.insert(sentence).second) mesh_.notes.push_back(sentence);
}

void Builder::count_note(const std::string& one, const std::string& several, std::size_t times) {
  Counted& note = counted_[several];
  note.one = one;
  note.times += times;
}

void Builder::name_note(const std::string& one, const std::string& several, const std::string& name) {
  count_note(one, several);
  Counted& note = counted_[several];
  if (std::find(note.names.begin(), note.names.end(), name) != note.names.end()) return;
  if (note.names.size() < max_names) {
    note.names.push_back(name);
  } else {
    note.more_names = true;
  }
}

std::string Builder::number_of(const std::string& several, const Counted& note) {
  return counted(note.times, note.one, several);
}

std::string Builder::sentence_of(const std::string& several, const Counted& note) {
  std::string result = number_of(several, note);
  for (const std::string& name : note.names) {
    result += fmt::format("{}{}", &name == note.names.data() ? ": " : ", ", printable(name, max_name_length));
  }
  return note.more_names ? result + " and others" : result;
}

void Builder::leave_out_unused_points() {
  const std::vector<bool> used = used_points();
  std::vector<std::uint32_t> number(mesh_.points.size());
  std::uint32_t count = 0;
  for (std::size_t point = 0; point < number.size(); ++point) {
    if (!used[point]) continue;
    number[point] = count;
    mesh_.points[count++] = mesh_.points[point];
  }
  const std::size_t left_out = mesh_.points.size() - count;
  mesh_.points.resize(count);
  for (std::uint32_t& corner : mesh_.corners) corner = number[corner];
  for (MeshGroup& group : mesh_.groups) {
    std::erase_if(group.points, [&](std::uint32_t point) { return !used[point]; });
    for (std::uint32_t& point : group.points) point = number[point];
  }
  if (left_out > 0)
    count_note("point that no cell uses is left out", "points that no cell uses are left out", left_out);
}

// Fills in cells and points of groups; removes empty groups.
void Builder::fill_groups() {
  for (std::size_t k = 0; k < mesh_.groups.size(); ++k) {
    MeshGroup& group = mesh_.groups[k];
    std::vector<Range>& ranges = cells_of_group_[k];
    std::sort(ranges.begin(), ranges.end());
    std::size_t next = 0;  // the first cell that is not yet in the group
    for (const auto& [first, end] : ranges) {
      for (std::size_t cell = std::max(first, next); cell < end; ++cell) {
        group.cells.push_back(static_cast<std::uint32_t>(cell));
        const auto corners = mesh_.cell(cell);
        group.points.insert(group.points.end(), corners.begin(), corners.end());
      }
      next = std::max(next, end);
    }
    sort_unique(group.points);
    if (group.points.empty()) {
      name_note("group without a used cell or point is left out", "groups without a used cell or point are left out",
                fmt::format("'{}'", group.name));
    }
  }
  std::erase_if(mesh_.groups, [](const MeshGroup& group) { return group.points.empty(); });
}

Mesh Builder::finish() && {
  if (mesh_.cell_count() == 0 && (source_.wants_cells() || mesh_.points.empty())) {
    std::string why;
    for (const auto& [several, note] : counted_)
      why += fmt::format("{}{}", why.empty() ? " (" : "; ", number_of(several, note));
    mesh_.notes.resize(std::min(mesh_.notes.size(), max_notes));
    for (const std::string& sentence : mesh_.notes) why += fmt::format("{}{}", why.empty() ? " (" : "; ", sentence);
    if (!why.empty()) why += ")";
    source_.fail(
        fmt::format("it has no usable cell{}; export lines, triangles, quadrilaterals, tetrahedra, hexahedra, "
                    "wedges or pyramids",
                    why));
  }
  if (source_.wants_cells()) leave_out_unused_points();
  fill_groups();
  for (const auto& [several, note] : counted_) mesh_.notes.push_back(sentence_of(several, note));
  if (mesh_.notes.size() > max_notes) {
    const std::size_t more = mesh_.notes.size() - max_notes;
    mesh_.notes.resize(max_notes);
    mesh_.notes.push_back(fmt::format("{} more notes are left out", more));
  }
  return std::move(mesh_);
}

}  // namespace springnet::meshes
