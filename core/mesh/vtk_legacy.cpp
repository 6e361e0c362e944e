// VTK's legacy files, versions 1 to 5 ("VTK File Formats", section "Simple Legacy Formats").
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "mesh/builder.hpp"
#include "mesh/cursor.hpp"
#include "mesh/formats.hpp"
#include "mesh/vtk_cells.hpp"

namespace springnet::meshes {
namespace {

// Limit of implicit grid points, which take no bytes in the file: a file of a hundred bytes must not fill the memory.
constexpr std::uint64_t max_implied_points = 1'000'000;

struct NamedType {
  const char* name;
  Scalar type;
};
// vtkIdType is written as int; long has 8 bytes on the platforms that write VTK files.
constexpr std::array types{NamedType{"char", Scalar::i8},           NamedType{"unsigned_char", Scalar::u8},
                           NamedType{"short", Scalar::i16},         NamedType{"unsigned_short", Scalar::u16},
                           NamedType{"int", Scalar::i32},           NamedType{"unsigned_int", Scalar::u32},
                           NamedType{"long", Scalar::i64},          NamedType{"unsigned_long", Scalar::u64},
                           NamedType{"vtkidtype", Scalar::i32},     NamedType{"vtktypeint64", Scalar::i64},
                           NamedType{"vtktypeuint64", Scalar::u64}, NamedType{"float", Scalar::f32},
                           NamedType{"double", Scalar::f64}};

// Cells as the file lists them: cell i has the points [offsets[i], offsets[i + 1]).
struct Lists {
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int64_t> points;
  Place place;
  [[nodiscard]] std::size_t count() const { return offsets.size() - 1; }
  [[nodiscard]] std::span<const std::int64_t> cell(std::size_t i) const {
    return {points.data() + offsets[i], static_cast<std::size_t>(offsets[i + 1] - offsets[i])};
  }
};

class VtkLegacyReader {
 public:
  explicit VtkLegacyReader(const Source& source) : in_(source), builder_(source), cells_(builder_, 0) {}

  Mesh read() {
    header();
    while (!in_.at_end() && statement()) {
    }
    make_cells();
    for (const Groups& groups : groups_) add_groups(groups);
    return std::move(builder_).finish();
  }

 private:
  enum class Attributes { none, of_cells, of_points };
  struct Groups {
    Attributes of;
    std::string name;
    std::vector<std::int64_t> values;
    Place place;
  };

  void header() {
    constexpr std::string_view begin = "# vtk DataFile Version";
    const std::string_view first = in_.line();
    if (!equal_ignoring_case(first.substr(0, begin.size()), begin)) {
      in_.fail(
          "a legacy VTK file begins with '# vtk DataFile Version'; this is another format: give the file its own "
          "ending");
    }
    const std::string_view version = first.substr(begin.size());
    double number = 0.0;
    const std::size_t digits = std::min(version.find_first_not_of(' '), version.size());
    if (!parse_real(version.substr(digits, version.find_last_not_of(" \t\r") + 1 - digits), number) ||
        !(number < 6.0)) {
      in_.fail("this version of legacy VTK is not known; save it as version 5.1 or before");
    }
    with_offsets_ = number >= 5.0;
    in_.line();  // a title
    const std::string_view kind = in_.word("ASCII or BINARY");
    binary_ = equal_ignoring_case(kind, "BINARY");
    if (!binary_ && !equal_ignoring_case(kind, "ASCII")) {
      in_.fail("this should be ASCII or BINARY; export the mesh again");
    }
    in_.set_binary(binary_);
  }

  Scalar type() {
    const std::string_view name = in_.word("a type of numbers");
    for (const NamedType& known : types) {
      if (equal_ignoring_case(name, known.name)) return known.type;
    }
    in_.fail("this should be a type of numbers; export the mesh with float, double or int");
  }

  // Reads `count` values after checking that the file can hold them. In binary files they follow the line, big-endian.
  template <class To>
  std::vector<To> values(std::uint64_t count, Scalar type, std::string_view what) {
    if (std::is_same_v<To, std::int64_t> && !is_integer(type)) {
      in_.fail(fmt::format("{} must be whole numbers; export the mesh again", what));
    }
    in_.check_count(count, binary_ ? size_of(type) : 1, fmt::format("the number of {}", what));
    if (binary_) {
      in_.line();
      return decode<To>(type, in_.bytes(static_cast<std::size_t>(count) * size_of(type), what),
                        std::endian::native == std::endian::little);
    }
    std::vector<To> result;
    result.reserve(static_cast<std::size_t>(count));
    for (std::uint64_t i = 0; i < count; ++i) {
      if constexpr (std::is_same_v<To, double>) {
        result.push_back(in_.real(what));
      } else {
        result.push_back(in_.integer<std::int64_t>(what));
      }
    }
    return result;
  }
  std::uint64_t number(std::string_view what) { return in_.integer<std::uint64_t>(what); }

  // False if the rest of the file cannot be parsed and is not needed.
  bool statement() {
    const std::string_view word = in_.word("a keyword");
    const auto is = [&](std::string_view keyword) { return equal_ignoring_case(word, keyword); };
    if (is("DATASET")) {
      dataset_ = in_.word("the type of the data set");
      constexpr std::array known{"UNSTRUCTURED_GRID", "POLYDATA", "STRUCTURED_POINTS", "STRUCTURED_GRID",
                                 "RECTILINEAR_GRID"};
      if (std::none_of(known.begin(), known.end(), [&](const char* k) { return equal_ignoring_case(k, dataset_); })) {
        in_.fail("this kind of data set is not read; save it as UNSTRUCTURED_GRID");
      }
    } else if (is("POINTS")) {
      points();
    } else if (is("CELLS")) {
      lists(polygons_or_cells_);
    } else if (is("POLYGONS")) {
      lists(polygons_or_cells_);
    } else if (is("VERTICES")) {
      lists(vertices_);
    } else if (is("LINES")) {
      lists(lines_);
    } else if (is("TRIANGLE_STRIPS")) {
      lists(strips_);
    } else if (is("CELL_TYPES")) {
      const std::uint64_t count = number("the number of cell types");
      cell_types_ = values<std::int64_t>(count, Scalar::i32, "cell types");
    } else if (is("DIMENSIONS")) {
      for (std::uint64_t& value : dimensions_.emplace()) value = number("a number of points");
      dimensions_place_ = in_.place();
    } else if (is("ORIGIN")) {
      for (double& value : origin_) value = in_.real("a coordinate of the origin");
    } else if (is("SPACING") || is("ASPECT_RATIO")) {
      for (double& value : spacing_) value = in_.real("a spacing");
    } else if (is("X_COORDINATES") || is("Y_COORDINATES") || is("Z_COORDINATES")) {
      const auto axis = static_cast<std::size_t>((word[0] | 0x20) - 'x');
      const std::uint64_t count = number("the number of coordinates");
      coordinates_[axis] = values<double>(count, type(), "coordinates");
    } else if (is("CELL_DATA") || is("POINT_DATA")) {
      attributes_ = is("CELL_DATA") ? Attributes::of_cells : Attributes::of_points;
      attribute_count_ = number("the number of values");
    } else if (is("METADATA")) {
      in_.line();
      while (in_.left() > 0 && !in_.line().empty()) {
      }
    } else if (is("FIELD")) {
      return field();
    } else if (attributes_ != Attributes::none) {
      return attribute(word);
    } else {
      in_.fail(
          "this should be a VTK keyword; counts before it do not match the file, or it is damaged: export it "
          "again");
    }
    return true;
  }

  void points() {
    if (builder_.point_count() > 0) in_.fail("there are two POINTS sections; export the mesh again");
    const std::uint64_t count = number("the number of points");
    const Scalar scalar = type();
    in_.check_count(count, binary_ ? 3 * size_of(scalar) : 6, "the number of points");
    const Place place = in_.here();
    const auto coordinates = values<double>(3 * count, scalar, "coordinates");
    builder_.reserve_points(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3) {
      builder_.add_point({coordinates[i], coordinates[i + 1], coordinates[i + 2]}, place);
    }
  }

  void lists(Lists& lists) {
    const std::uint64_t first = number("the number of cells");
    const std::uint64_t second = number("the number of points of all cells");
    lists = {};
    lists.place = in_.place();
    if (with_offsets_) {
      if (first == 0) return;
      const auto part = [&](const char* keyword, std::uint64_t count) {
        if (!equal_ignoring_case(in_.word(keyword), keyword)) {
          in_.fail(fmt::format("this should be {}; export the mesh again", keyword));
        }
        return values<std::int64_t>(count, type(), keyword);
      };
      lists.offsets = part("OFFSETS", first);
      lists.points = part("CONNECTIVITY", second);
      if (lists.offsets.front() != 0 || lists.offsets.back() != static_cast<std::int64_t>(lists.points.size()) ||
          !std::is_sorted(lists.offsets.begin(), lists.offsets.end())) {
        in_.source().fail(lists.place,
                          "OFFSETS do not increase from 0 to the length of CONNECTIVITY; export the mesh again");
      }
      return;
    }
    const auto all = values<std::int64_t>(second, Scalar::i32, "cells");
    for (std::size_t at = 0; at < all.size();) {
      const std::int64_t size = all[at];
      if (size < 0 || static_cast<std::uint64_t>(size) > all.size() - at - 1) {
        in_.source().fail(lists.place,
                          fmt::format("cell {} has {} points, but the list of cells ends before that; export the "
                                      "mesh again",
                                      lists.count(), size));
      }
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(at) + 1;
      lists.points.insert(lists.points.end(), begin, begin + static_cast<std::ptrdiff_t>(size));
      lists.offsets.push_back(static_cast<std::int64_t>(lists.points.size()));
      at += static_cast<std::size_t>(size) + 1;
    }
    if (lists.count() != first) {
      in_.source().fail(lists.place, fmt::format("there are {} cells, but {} were declared; export the mesh again",
                                                 lists.count(), first));
    }
  }

  void array(const std::string& name, std::uint64_t tuples, std::uint64_t components, Scalar scalar) {
    in_.check_count(tuples, 1, "the number of values");
    if (tuples > 0) in_.check_count(components, static_cast<std::size_t>(tuples), "the number of components");
    const Place place = in_.here();
    const bool gives_groups = attributes_ != Attributes::none && components == 1 && VtkCells::is_group_name(name);
    if (gives_groups && is_integer(scalar)) {
      groups_.push_back({attributes_, name, values<std::int64_t>(tuples, scalar, name), place});
      return;
    }
    if (gives_groups) builder_.note(fmt::format("array '{}' does not have whole numbers and gives no groups", name));
    if (binary_) {
      in_.check_count(tuples * components, size_of(scalar), "the number of values");
      in_.line();
      in_.bytes(static_cast<std::size_t>(tuples * components) * size_of(scalar), "values");
    } else {
      for (std::uint64_t i = 0; i < tuples * components; ++i) in_.word("a value");
    }
  }

  bool field() {
    in_.word("the name of a field");
    const std::uint64_t arrays = number("the number of arrays");
    for (std::uint64_t i = 0; i < arrays; ++i) {
      if (equal_ignoring_case(in_.peek(), "METADATA")) {
        in_.line();
        while (in_.left() > 0 && !in_.line().empty()) {
        }
      }
      const std::string name(in_.word("the name of an array"));
      const std::uint64_t components = number("the number of components"), tuples = number("the number of tuples");
      const auto scalar = data_type();
      if (!scalar) return false;
      array(name, tuples, components, *scalar);
    }
    return true;
  }

  // Type of an array that is skipped; empty for bits and strings, after which nothing more is read.
  std::optional<Scalar> data_type() {
    const std::string_view name = in_.peek();
    if (equal_ignoring_case(name, "bit") || equal_ignoring_case(name, "string") ||
        equal_ignoring_case(name, "variant")) {
      in_.word("a type");
      stop();
      return std::nullopt;
    }
    return type();
  }
  void stop() {
    if (attributes_ == Attributes::none) {
      in_.fail("an array of bits or strings before the mesh is not read; export the mesh without it");
    }
    builder_.note(fmt::format("data from {} on are not read", in_.source().description(in_.place())));
  }

  bool attribute(std::string_view keyword) {
    const auto is = [&](std::string_view other) { return equal_ignoring_case(keyword, other); };
    constexpr std::array known{
        "SCALARS",    "VECTORS",      "NORMALS",      "TENSORS",      "TENSORS6", "TEXTURE_COORDINATES",
        "GLOBAL_IDS", "PEDIGREE_IDS", "LOOKUP_TABLE", "COLOR_SCALARS"};
    if (std::none_of(known.begin(), known.end(), is)) {
      stop();
      return false;
    }
    const std::string name(in_.word("the name of an array"));
    if (is("LOOKUP_TABLE") || is("COLOR_SCALARS")) {
      const std::uint64_t length = number("a number of values");
      const bool table = is("LOOKUP_TABLE");
      array("", table ? length : attribute_count_, table ? 4 : length, binary_ ? Scalar::u8 : Scalar::f32);
      return true;
    }
    std::uint64_t components = is("VECTORS") || is("NORMALS") ? 3 : is("TENSORS") ? 9 : is("TENSORS6") ? 6 : 1;
    if (is("TEXTURE_COORDINATES")) components = number("the number of coordinates");
    const auto scalar = data_type();
    if (!scalar) return false;
    if (is("SCALARS")) {
      // The number of components is optional, as is the colour table, which has its own line.
      const std::string_view next = in_.peek();
      if (next.size() == 1 && next[0] >= '1' && next[0] <= '4') components = number("components");
      if (equal_ignoring_case(in_.peek(), "LOOKUP_TABLE")) {
        in_.word("LOOKUP_TABLE");
        in_.word("the name of a table");
      }
    }
    array(name, attribute_count_, components, *scalar);
    return true;
  }

  void make_cells() {
    if (dataset_.empty()) in_.fail("there is no DATASET; the file is cut off, export the mesh again");
    if (equal_ignoring_case(dataset_, "UNSTRUCTURED_GRID")) {
      const Lists& lists = polygons_or_cells_;
      if (cell_types_.size() != lists.count()) {
        builder_.source().fail(lists.place, fmt::format("there are {} CELLS but {} CELL_TYPES; export the mesh again",
                                                        lists.count(), cell_types_.size()));
      }
      for (std::size_t i = 0; i < lists.count(); ++i) {
        const auto type = static_cast<int>(std::clamp<std::int64_t>(cell_types_[i], -1, 1000));
        cells_.add(type, lists.cell(i), lists.place);
      }
    } else if (equal_ignoring_case(dataset_, "POLYDATA")) {
      add(vertices_, vtk::poly_vertex);  // VTK's numbers of cells are in this order
      add(lines_, vtk::poly_line);
      add(polygons_or_cells_, vtk::polygon);
      add(strips_, vtk::triangle_strip);
    } else {
      make_grid();
    }
  }
  void add(const Lists& lists, int type) {
    for (std::size_t i = 0; i < lists.count(); ++i) cells_.add(type, lists.cell(i), lists.place);
  }

  void make_grid() {
    if (!dimensions_) in_.fail("there are no DIMENSIONS; the file is cut off, export the mesh again");
    const auto& [nx, ny, nz] = *dimensions_;
    const auto check = [&](bool fine, std::string_view message) {
      if (!fine) builder_.source().fail(dimensions_place_, message);
    };
    check(nx > 0 && ny > 0 && nz > 0, "DIMENSIONS must be 1 or more; correct them");
    const std::uint64_t limit = std::max<std::uint64_t>(max_implied_points, builder_.source().text().size());
    check(nx <= limit && ny <= limit / nx && nz <= limit / (nx * ny),
          fmt::format(
              "DIMENSIONS are {} x {} x {}, more than the {} points that a file of {} bytes may have; use a coarser "
              "grid",
              nx, ny, nz, limit, builder_.source().text().size()));
    if (equal_ignoring_case(dataset_, "STRUCTURED_GRID")) {
      check(nx * ny * nz == builder_.point_count(),
            fmt::format("DIMENSIONS are {} x {} x {}, but there are {} POINTS; export the mesh again", nx, ny, nz,
                        builder_.point_count()));
    } else {
      check(builder_.point_count() == 0, "this kind of grid has no POINTS; export the mesh again");
      if (equal_ignoring_case(dataset_, "STRUCTURED_POINTS")) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto k = static_cast<Eigen::Index>(axis);
          check(spacing_[k] > 0.0 || (*dimensions_)[axis] == 1, "SPACING must be above 0; correct it");
          coordinates_[axis].clear();
          for (std::uint64_t i = 0; i < (*dimensions_)[axis]; ++i) {
            coordinates_[axis].push_back(origin_[k] + spacing_[k] * static_cast<double>(i));
          }
        }
      }
      const auto& [x, y, z] = coordinates_;
      check(x.size() == nx && y.size() == ny && z.size() == nz,
            "the numbers of X_, Y_ and Z_COORDINATES do not match DIMENSIONS; export the mesh again");
      builder_.reserve_points(static_cast<std::size_t>(nx * ny * nz));
      for (const double pz : z) {
        for (const double py : y) {
          for (const double px : x) builder_.add_point({px, py, pz}, dimensions_place_);
        }
      }
    }
    add_grid_cells(cells_, {static_cast<std::size_t>(nx), static_cast<std::size_t>(ny), static_cast<std::size_t>(nz)},
                   dimensions_place_);
  }

  void add_groups(const Groups& groups) {
    const bool of_cells = groups.of == Attributes::of_cells;
    const std::size_t wanted = of_cells ? cells_.count() : builder_.point_count();
    if (groups.values.size() != wanted) {
      builder_.source().fail(groups.place,
                             fmt::format("array '{}' has {} values for {} {}; export the mesh again", groups.name,
                                         groups.values.size(), wanted, of_cells ? "cells" : "points"));
    }
    if (of_cells) {
      cells_.groups_of_cells(groups.name, groups.values);
    } else {
      cells_.groups_of_points(groups.name, groups.values);
    }
  }

  Cursor in_;
  Builder builder_;
  VtkCells cells_;
  bool with_offsets_ = false;
  bool binary_ = false;
  std::string dataset_;
  Lists polygons_or_cells_, vertices_, lines_, strips_;
  std::vector<std::int64_t> cell_types_;
  std::optional<std::array<std::uint64_t, 3>> dimensions_;
  Place dimensions_place_;
  Vector3 origin_ = Vector3::Zero(), spacing_ = Vector3::Ones();
  std::array<std::vector<double>, 3> coordinates_;
  Attributes attributes_ = Attributes::none;
  std::uint64_t attribute_count_ = 0;
  std::vector<Groups> groups_;
};

}  // namespace

Mesh read_vtk_legacy(const Source& source) { return VtkLegacyReader(source).read(); }

}  // namespace springnet::meshes
