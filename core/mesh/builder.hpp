// Builds a mesh for all formats: checks, groups, notes, removal of unused points.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <springnet/huge_pages.hpp>
#include <springnet/mesh.hpp>

#include "mesh/source.hpp"

namespace springnet::meshes {

class Builder {
 public:
  explicit Builder(const Source& source) : source_(source) {}

  [[nodiscard]] const Source& source() const noexcept { return source_; }
  [[nodiscard]] std::size_t point_count() const noexcept { return mesh_.points.size(); }
  [[nodiscard]] std::size_t cell_count() const noexcept { return mesh_.cell_count(); }

  // Grows at least by a factor of two: a file may have as many blocks as points.
  void reserve_points(std::size_t more) {
    const std::size_t wanted = mesh_.points.size() + more;
    if (wanted > mesh_.points.capacity()) reserve_huge(mesh_.points, std::max(wanted, 2 * mesh_.points.capacity()));
  }
  // The same for cells of a type.
  void reserve_cells(CellType type, std::size_t more) {
    const auto grow = [](auto& vector, std::size_t by) {
      const std::size_t wanted = vector.size() + by;
      if (wanted > vector.capacity()) reserve_huge(vector, std::max(wanted, 2 * vector.capacity()));
    };
    grow(mesh_.types, more);
    grow(mesh_.offsets, more);
    grow(mesh_.corners, more * corner_count(type));
  }
  // Throws Error(input) for coordinates that are not finite or beyond 1e100 m (their squares and volumes would not be
  // finite), and for too many points.
  std::uint32_t add_point(const Vector3& position, Place place);
  // Corners are points already added. Throws Error(input) if a point occurs twice.
  void add_cell(CellType type, std::span<const std::uint32_t> corners, Place place);
  // Three corners make a triangle, four a quadrilateral, more are divided into triangles around the first corner.
  void add_polygon(std::span<const std::uint32_t> corners, Place place);

  // Groups of the same name are merged.
  std::size_t group(const std::string& name);
  // Throws Error(input) if groups have implausibly many cells: a small malicious file could put all of its cells into
  // thousands of groups.
  void add_cells_to_group(std::size_t group, std::size_t first_cell, std::size_t end_cell);
  void add_point_to_group(std::size_t group, std::uint32_t point);

  // [point]: whether a cell uses it.
  [[nodiscard]] std::vector<bool> used_points() const;

  // Notes quote nothing from the file except names that its format defines, because an error may repeat them.
  void note(const std::string& sentence);
  // A note that is reported once with its count, as "1 `one`" or "5 `several`".
  void count_note(const std::string& one, const std::string& several, std::size_t times = 1);
  // The same with the first few names concerned. They may come from the file, so no error repeats them.
  void name_note(const std::string& one, const std::string& several, const std::string& name);

  // Throws Error(input) if there is no cell.
  [[nodiscard]] Mesh finish() &&;

 private:
  struct Counted {
    std::string one;
    std::size_t times = 0;
    std::vector<std::string> names{};  // different ones
    bool more_names = false;
  };
  using Range = std::pair<std::size_t, std::size_t>;  // first, one past the last

  // number_of() omits the names.
  [[nodiscard]] static std::string number_of(const std::string& several, const Counted& note);
  [[nodiscard]] static std::string sentence_of(const std::string& several, const Counted& note);
  void leave_out_unused_points();
  void fill_groups();

  const Source& source_;
  Mesh mesh_;
  std::map<std::string, std::size_t> group_of_name_;
  std::vector<std::vector<Range>> cells_of_group_;  // [group]
  std::size_t grouped_cells_ = 0;                   // of all groups
  std::set<std::string> notes_so_far_;
  std::map<std::string, Counted> counted_;  // by the sentence for several
};

}  // namespace springnet::meshes
