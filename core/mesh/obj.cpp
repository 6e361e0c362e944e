// Wavefront OBJ: points, faces, lines and groups.
#include <algorithm>
#include <array>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mesh/builder.hpp"
#include "mesh/cursor.hpp"
#include "mesh/formats.hpp"

namespace springnet::meshes {
namespace {

// Statements without geometry: texture, normals, materials, smoothing, levels of detail.
constexpr std::array without_geometry{"vt",         "vn",        "vp",     "s",        "usemtl",
                                      "mtllib",     "lod",       "bevel",  "c_interp", "d_interp",
                                      "shadow_obj", "trace_obj", "maplib", "usemap",   "mg"};

class ObjReader {
 public:
  explicit ObjReader(const Source& source) : in_(source), builder_(source) {}

  Mesh read() {
    while (!in_.at_end()) {
      words_of_line();
      if (!words_.empty()) statement();
    }
    if (farthest_ > builder_.point_count()) {
      builder_.source().fail(
          farthest_place_,
          fmt::format("a point number on this line is greater than {}, the number of points; correct it or add points",
                      builder_.point_count()));
    }
    // Cells may refer to points later in the file, so they are added at the end.
    for (const Cell& cell : cells_) add(cell);
    return std::move(builder_).finish();
  }

 private:
  struct Cell {
    char kind;  // f, l, p
    std::size_t first_corner;
    std::size_t end_corner;
    Place place;
    std::size_t object;  // index into objects_
    std::size_t groups;  // index into groups_
  };

  // The words up to a comment or the end of the line; a backslash at the end continues the line.
  void words_of_line() {
    words_.clear();
    line_ = in_.here();
    bool continues = true;
    while (continues) {
      std::string_view line = in_.line();
      line = line.substr(0, line.find('#'));
      const std::size_t last = line.find_last_not_of(" \t");
      continues = last != std::string_view::npos && line[last] == '\\' && in_.left() > 0;
      if (last != std::string_view::npos && line[last] == '\\') line = line.substr(0, last);
      for (std::size_t begin = 0; (begin = line.find_first_not_of(" \t\r\v\f", begin)) != std::string_view::npos;) {
        const std::size_t end = std::min(line.find_first_of(" \t\r\v\f", begin), line.size());
        words_.push_back(line.substr(begin, end - begin));
        begin = end;
      }
    }
  }

  [[noreturn]] void fail(std::string_view message) const { builder_.source().fail(line_, message); }

  void statement() {
    const std::string_view keyword = words_[0];
    if (keyword == "v") {
      point();
    } else if (keyword == "f" || keyword == "l" || keyword == "p") {
      cell(keyword[0]);
    } else if (keyword == "g" || keyword == "o") {
      name(keyword[0]);
    } else if (std::find(without_geometry.begin(), without_geometry.end(), keyword) == without_geometry.end()) {
      if (keyword.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") != std::string_view::npos) {
        fail("this is not an OBJ statement; correct the line");
      }
      builder_.name_note("statement is not read", "statements are not read", fmt::format("'{}'", keyword));
    }
  }

  void point() {
    if (words_.size() < 4) fail("a point needs three coordinates; write it as v x y z");
    Vector3 position;
    for (std::size_t k = 0; k < 3; ++k) {
      if (parse_real(words_[k + 1], position[static_cast<Eigen::Index>(k)])) continue;
      fail(
          fmt::format("coordinate {} of this point is not a number; correct the line or export the mesh again", k + 1));
    }
    builder_.add_point(position, line_);
  }

  void cell(char kind) {
    Cell cell{kind, corners_.size(), 0, line_, objects_.size() - 1, groups_.size() - 1};
    for (std::size_t k = 1; k < words_.size(); ++k) {
      const std::string_view word = words_[k].substr(0, words_[k].find('/'));
      std::int64_t number = 0;
      if (!parse_integer(word, number) || number == 0) {
        fail(
            fmt::format("'{}' needs point numbers, 1 or more, or below 0 to count back from the last point: word {} is "
                        "neither; correct the line",
                        kind, k));
      }
      const auto count = static_cast<std::int64_t>(builder_.point_count());
      if (number < -count) {
        fail(fmt::format("only {} points precede this line, and word {} counts farther back; correct the number", count,
                         k));
      }
      if (number < 0) number += count + 1;
      if (static_cast<std::uint64_t>(number) > farthest_) {
        farthest_ = static_cast<std::uint64_t>(number);
        farthest_place_ = line_;
      }
      corners_.push_back(static_cast<std::uint32_t>(number - 1));
    }
    cell.end_corner = corners_.size();
    const std::size_t min_points = kind == 'f' ? 3 : kind == 'l' ? 2 : 1;
    if (cell.end_corner - cell.first_corner < min_points) {
      fail(fmt::format("'{}' has {} points and needs {} or more; correct the line", kind,
                       cell.end_corner - cell.first_corner, min_points));
    }
    cells_.push_back(cell);
  }

  void name(char kind) {
    std::vector<std::size_t> named;
    if (kind == 'g') {
      for (std::size_t k = 1; k < words_.size(); ++k) named.push_back(builder_.group(std::string(words_[k])));
      std::sort(named.begin(), named.end());
      named.erase(std::unique(named.begin(), named.end()), named.end());
    } else if (words_.size() > 1) {
      named.push_back(builder_.group(fmt::format("{}", fmt::join(words_.begin() + 1, words_.end(), " "))));
    }
    (kind == 'g' ? groups_ : objects_).push_back(std::move(named));
  }

  void add(const Cell& cell) {
    const std::size_t first = builder_.cell_count();
    const std::span<const std::uint32_t> corners(corners_.data() + cell.first_corner,
                                                 cell.end_corner - cell.first_corner);
    if (cell.kind == 'f') {
      builder_.add_polygon(corners, cell.place);
    } else if (cell.kind == 'l') {
      for (std::size_t k = 1; k < corners.size(); ++k)
        builder_.add_cell(CellType::line, corners.subspan(k - 1, 2), cell.place);
    } else {
      for (std::size_t k = 0; k < corners.size(); ++k)
        builder_.add_cell(CellType::vertex, corners.subspan(k, 1), cell.place);
    }
    const auto add_to = [&](std::size_t group) { builder_.add_cells_to_group(group, first, builder_.cell_count()); };
    const std::vector<std::size_t>&groups = groups_[cell.groups], &object = objects_[cell.object];
    for (const std::size_t group : groups) add_to(group);
    for (const std::size_t group : object) {
      if (!std::binary_search(groups.begin(), groups.end(), group)) add_to(group);
    }
  }

  Cursor in_;
  Builder builder_;
  std::vector<std::string_view> words_;
  Place line_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> corners_;
  std::uint64_t farthest_ = 0;  // greatest point number that occurred, counted from 1
  Place farthest_place_;
  // Groups of the builder after each g, ascending, and after each o, at most one, whose name may contain spaces.
  std::vector<std::vector<std::size_t>> groups_{{}}, objects_{{}};
};

}  // namespace

Mesh read_obj(const Source& source) { return ObjReader(source).read(); }

}  // namespace springnet::meshes
