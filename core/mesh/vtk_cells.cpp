#include "mesh/vtk_cells.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "mesh/cursor.hpp"

namespace springnet::meshes {
namespace {

struct VtkType {
  int number;
  std::size_t points;
  CellType cell;  // its corners are the first points
};
constexpr std::array vtk_types{VtkType{1, 1, CellType::vertex},         VtkType{3, 2, CellType::line},
                               VtkType{5, 3, CellType::triangle},       VtkType{9, 4, CellType::quadrilateral},
                               VtkType{10, 4, CellType::tetrahedron},   VtkType{12, 8, CellType::hexahedron},
                               VtkType{13, 6, CellType::wedge},         VtkType{14, 5, CellType::pyramid},
                               VtkType{21, 3, CellType::line},          VtkType{22, 6, CellType::triangle},
                               VtkType{23, 8, CellType::quadrilateral}, VtkType{24, 10, CellType::tetrahedron},
                               VtkType{25, 20, CellType::hexahedron},   VtkType{26, 15, CellType::wedge},
                               VtkType{27, 13, CellType::pyramid},      VtkType{28, 9, CellType::quadrilateral},
                               VtkType{29, 27, CellType::hexahedron},   VtkType{30, 6, CellType::quadrilateral},
                               VtkType{31, 12, CellType::wedge},        VtkType{32, 18, CellType::wedge},
                               VtkType{33, 24, CellType::hexahedron},   VtkType{34, 7, CellType::triangle},
                               VtkType{37, 19, CellType::pyramid}};

constexpr int empty_cell = 0, pixel = 8, voxel = 11;
constexpr std::array<std::size_t, 4> pixel_order{0, 1, 3, 2};
constexpr std::array<std::size_t, 8> voxel_order{0, 1, 3, 2, 4, 5, 7, 6};

constexpr std::array group_names{"group",         "groups",      "material",     "materials",
                                 "CellEntityIds", "PhysicalIds", "gmsh:physical"};
constexpr std::size_t max_groups = 1000;  // more are not groups but a number for each cell

template <class From, class To>
void decode_as(std::string_view bytes, bool swap, std::vector<To>& values) {
  for (std::size_t at = 0; at + sizeof(From) <= bytes.size(); at += sizeof(From)) {
    values.push_back(static_cast<To>(from_bytes<From>(bytes.data() + at, swap)));
  }
}

// Groups of the builder by value; empty if there are too many values for groups.
std::optional<std::map<std::int64_t, std::size_t>> groups_for(Builder& builder, const std::string& name,
                                                              std::span<const std::int64_t> values) {
  std::map<std::int64_t, std::size_t> groups;
  for (const std::int64_t value : values) {
    groups.emplace(value, 0);
    if (groups.size() <= max_groups) continue;
    builder.note(fmt::format("array '{}' has more than {} values and gives no groups", name, max_groups));
    return std::nullopt;
  }
  for (auto& [value, group] : groups) group = builder.group(fmt::format("{} {}", name, value));
  return groups;
}

}  // namespace

std::size_t size_of(Scalar type) noexcept {
  constexpr std::array<std::size_t, 10> sizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

bool is_integer(Scalar type) noexcept { return type < Scalar::f32; }

template <class To>
std::vector<To> decode(Scalar type, std::string_view bytes, bool swap) {
  std::vector<To> values;
  values.reserve(bytes.size() / size_of(type));
  switch (type) {
    case Scalar::i8:
      decode_as<std::int8_t>(bytes, swap, values);
      break;
    case Scalar::u8:
      decode_as<std::uint8_t>(bytes, swap, values);
      break;
    case Scalar::i16:
      decode_as<std::int16_t>(bytes, swap, values);
      break;
    case Scalar::u16:
      decode_as<std::uint16_t>(bytes, swap, values);
      break;
    case Scalar::i32:
      decode_as<std::int32_t>(bytes, swap, values);
      break;
    case Scalar::u32:
      decode_as<std::uint32_t>(bytes, swap, values);
      break;
    case Scalar::i64:
      decode_as<std::int64_t>(bytes, swap, values);
      break;
    case Scalar::u64:
      decode_as<std::uint64_t>(bytes, swap, values);
      break;
    case Scalar::f32:
      if constexpr (std::is_same_v<To, double>) decode_as<float>(bytes, swap, values);
      break;
    case Scalar::f64:
      if constexpr (std::is_same_v<To, double>) decode_as<double>(bytes, swap, values);
      break;
  }
  return values;
}
template std::vector<double> decode(Scalar, std::string_view, bool);
template std::vector<std::int64_t> decode(Scalar, std::string_view, bool);

void VtkCells::add(int type, std::span<const std::int64_t> points, Place place) {
  const Source& source = builder_.source();
  begins_.push_back(builder_.cell_count());
  const std::size_t point_count = builder_.point_count() - first_point_;
  corners_.clear();
  for (const std::int64_t point : points) {
    if (point < 0 || static_cast<std::uint64_t>(point) >= point_count) {
      source.fail(place, fmt::format("cell {} has point {}, but there are {} (0 to {}); export the mesh again",
                                     count() - 1, point, point_count, static_cast<std::int64_t>(point_count) - 1));
    }
    corners_.push_back(first_point_ + static_cast<std::uint32_t>(point));
  }
  const auto need = [&](std::size_t min_count, bool exactly) {
    if (exactly ? corners_.size() == min_count : corners_.size() >= min_count) return;
    source.fail(place, fmt::format("cell {} of VTK's type {} has {} points and needs {}{}; export the mesh again",
                                   count() - 1, type, corners_.size(), min_count, exactly ? "" : " or more"));
  };
  const std::span<const std::uint32_t> corners(corners_);
  switch (type) {
    case empty_cell:
      builder_.count_note("empty cell is left out", "empty cells are left out");
      return;
    case vtk::poly_vertex:
      for (std::size_t k = 0; k < corners.size(); ++k)
        builder_.add_cell(CellType::vertex, corners.subspan(k, 1), place);
      return;
    case vtk::poly_line:
      need(2, false);
      for (std::size_t k = 1; k < corners.size(); ++k)
        builder_.add_cell(CellType::line, corners.subspan(k - 1, 2), place);
      return;
    case vtk::triangle_strip:
      need(3, false);
      for (std::size_t k = 2; k < corners.size(); ++k) {  // every second triangle is reversed
        const std::size_t odd = k % 2;
        builder_.add_cell(CellType::triangle, std::array{corners[k - 2 + odd], corners[k - 1 - odd], corners[k]},
                          place);
      }
      return;
    case vtk::polygon:
      need(3, false);
      builder_.add_polygon(corners, place);
      return;
    case pixel:
    case voxel: {
      need(type == pixel ? 4 : 8, true);
      std::array<std::uint32_t, 8> ordered{};
      for (std::size_t k = 0; k < corners.size(); ++k)
        ordered[k] = corners[type == pixel ? pixel_order[k] : voxel_order[k]];
      builder_.add_cell(type == pixel ? CellType::quadrilateral : CellType::hexahedron,
                        std::span(ordered.data(), corners.size()), place);
      return;
    }
    default:
      break;
  }
  const auto known =
      std::find_if(vtk_types.begin(), vtk_types.end(), [&](const VtkType& t) { return t.number == type; });
  if (known == vtk_types.end()) {
    builder_.name_note("cell of another type is left out", "cells of other types are left out",
                       fmt::format("VTK's type {}", type));
    return;
  }
  need(known->points, true);
  const std::size_t used = corner_count(known->cell);
  builder_.add_cell(known->cell, corners.first(used), place);
  if (known->points > used)
    builder_.count_note("cell of second order is read without its middle points",
                        "cells of second order are read without their middle points");
}

bool VtkCells::is_group_name(std::string_view name) {
  return std::any_of(group_names.begin(), group_names.end(),
                     [&](const char* known) { return equal_ignoring_case(name, known); });
}

void VtkCells::groups_of_cells(const std::string& name, std::span<const std::int64_t> values) {
  const auto groups = groups_for(builder_, name, values);
  if (!groups) return;
  for (std::size_t cell = 0; cell < std::min(values.size(), count()); ++cell) {
    const std::size_t end = cell + 1 < count() ? begins_[cell + 1] : builder_.cell_count();
    builder_.add_cells_to_group(groups->at(values[cell]), begins_[cell], end);
  }
}

void VtkCells::groups_of_points(const std::string& name, std::span<const std::int64_t> values) {
  const auto groups = groups_for(builder_, name, values);
  if (!groups) return;
  for (std::size_t point = 0; point < values.size(); ++point) {
    builder_.add_point_to_group(groups->at(values[point]), first_point_ + static_cast<std::uint32_t>(point));
  }
}

void add_grid_cells(VtkCells& cells, const std::array<std::size_t, 3>& dimensions, Place place) {
  // In a direction with one point cells have no extent: one layer, and no step along it.
  std::array<std::size_t, 3> layers{};
  for (std::size_t k = 0; k < 3; ++k) layers[k] = dimensions[k] > 1 ? dimensions[k] - 1 : 1;
  std::vector<std::array<std::size_t, 3>> steps{{0, 0, 0}};  // to the corners, in the order of pixels and voxels
  for (std::size_t k = 0; k < 3; ++k) {
    if (dimensions[k] < 2) continue;
    for (std::size_t i = 0, size = steps.size(); i < size; ++i) {
      steps.push_back(steps[i]);
      steps.back()[k] = 1;
    }
  }
  constexpr std::array types_by_corners{0, vtk::vertex, vtk::line, 0, pixel, 0, 0, 0, voxel};
  std::vector<std::int64_t> corners(steps.size());
  for (std::size_t z = 0; z < layers[2]; ++z) {
    for (std::size_t y = 0; y < layers[1]; ++y) {
      for (std::size_t x = 0; x < layers[0]; ++x) {
        for (std::size_t i = 0; i < steps.size(); ++i) {
          const auto& [dx, dy, dz] = steps[i];
          corners[i] = static_cast<std::int64_t>(x + dx + dimensions[0] * (y + dy + dimensions[1] * (z + dz)));
        }
        cells.add(types_by_corners[steps.size()], corners, place);
      }
    }
  }
}

}  // namespace springnet::meshes
