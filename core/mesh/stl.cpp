// STL: triangles by the coordinates of their corners, in text or binary form.
#include <array>
#include <cstring>
#include <unordered_map>

#include <fmt/format.h>

#include "mesh/builder.hpp"
#include "mesh/cursor.hpp"
#include "mesh/formats.hpp"

namespace springnet::meshes {
namespace {

constexpr std::size_t header_size = 80, triangle_size = 50;

struct Hash {
  std::size_t operator()(const std::array<double, 3>& position) const noexcept {
    std::uint64_t result = 0;
    for (const double coordinate : position) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &coordinate, sizeof(bits));
      result = (result ^ bits) * 0x9E3779B97F4A7C15U;
      result ^= result >> 29U;
    }
    return static_cast<std::size_t>(result);
  }
};

class StlReader {
 public:
  explicit StlReader(const Source& source) : in_(source), builder_(source) {}

  Mesh read() {
    if (is_binary()) {
      read_binary();
    } else {
      read_text();
    }
    return std::move(builder_).finish();
  }

 private:
  // Some programs append a line end or zeros: less than a triangle may follow the last one.
  [[nodiscard]] static bool fits(std::uint64_t bytes, std::uint64_t triangles) {
    return bytes >= triangle_size * triangles && bytes - triangle_size * triangles < triangle_size;
  }

  // Binary files may begin with "solid" too, so the test is whether the number of triangles matches the size.
  [[nodiscard]] bool is_binary() const {
    const std::string_view text = builder_.source().text();
    if (text.size() >= header_size + 4) {
      const auto count = from_bytes<std::uint32_t>(text.data() + header_size, !is_little);
      if (fits(text.size() - header_size - 4, count)) return true;
    }
    const std::string_view begin = text.substr(0, header_size);
    const std::size_t word = begin.find_first_not_of(" \t\r\n");
    if (word == std::string_view::npos || !equal_ignoring_case(begin.substr(word, 5), "solid")) return true;
    return text.find('\0') != std::string_view::npos;
  }

  void read_binary() {
    in_.set_binary(true);
    in_.bytes(header_size, "the header of a binary STL file");
    const auto count = in_.binary<std::uint32_t>(!is_little, "the number of triangles");
    if (!fits(in_.left(), count)) {
      in_.fail(
          fmt::format("the number of triangles does not match the {} bytes after it, {} for each; the file is cut off, "
                      "damaged or not STL, export it again",
                      in_.left(), triangle_size));
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      const Place place = in_.here();
      const std::string_view bytes = in_.bytes(triangle_size, "a triangle");
      std::array<Vector3, 3> corners;
      for (std::size_t k = 0; k < 9; ++k) {
        const std::size_t at = 12 + 4 * k;  // after the normal
        corners[k / 3][static_cast<Eigen::Index>(k % 3)] = from_bytes<float>(bytes.data() + at, !is_little);
      }
      triangle(corners, place);
    }
    if (in_.left() > 0)
      builder_.count_note("byte after the last triangle is not read", "bytes after the last triangle are not read",
                          in_.left());
  }

  void read_text() {
    while (!in_.at_end()) {
      expect("solid");
      const std::string_view rest = in_.line();
      const std::size_t begin = rest.find_first_not_of(" \t"), end = rest.find_last_not_of(" \t");
      const std::string name(begin == std::string_view::npos ? "" : rest.substr(begin, end - begin + 1));
      const std::size_t first = builder_.cell_count();
      while (equal_ignoring_case(in_.peek(), "facet")) facet();
      const std::string_view last = in_.word("'endsolid' or 'facet'");
      if (!equal_ignoring_case(last, "endsolid")) {
        in_.fail("this should be 'endsolid' or 'facet'; correct the line or export the mesh again");
      }
      in_.line();
      if (!name.empty()) builder_.add_cells_to_group(builder_.group(name), first, builder_.cell_count());
    }
  }

  void expect(std::string_view keyword) {
    const std::string_view found = in_.word(fmt::format("'{}'", keyword));
    if (equal_ignoring_case(found, keyword)) return;
    in_.fail(fmt::format("this should be '{}'; correct the line or export the mesh again", keyword));
  }

  void facet() {
    expect("facet");
    const Place place = in_.place();
    expect("normal");
    for (int k = 0; k < 3; ++k) in_.word("a normal");  // ignored: the corners define it, and files often have it wrong
    expect("outer");
    expect("loop");
    std::array<Vector3, 3> corners;
    for (Vector3& corner : corners) {
      expect("vertex");
      for (double& coordinate : corner) coordinate = in_.real("a coordinate");
    }
    expect("endloop");
    expect("endfacet");
    triangle(corners, place);
  }

  void triangle(const std::array<Vector3, 3>& corners, Place place) {
    std::array<std::uint32_t, 3> points{};
    for (std::size_t k = 0; k < 3; ++k) {
      // -0 + 0 is 0: both zeros make the same point.
      const std::array<double, 3> position{corners[k].x() + 0.0, corners[k].y() + 0.0, corners[k].z() + 0.0};
      const auto found = points_.find(position);
      if (found != points_.end()) {
        points[k] = found->second;
      } else {
        points[k] = builder_.add_point({position[0], position[1], position[2]}, place);
        points_.emplace(position, points[k]);
      }
    }
    if (points[0] == points[1] || points[1] == points[2] || points[2] == points[0]) {
      builder_.count_note("triangle with two equal corners is left out",
                          "triangles with two equal corners are left out");
      return;
    }
    builder_.add_cell(CellType::triangle, points, place);
  }

  static constexpr bool is_little = std::endian::native == std::endian::little;
  Cursor in_;
  Builder builder_;
  std::unordered_map<std::array<double, 3>, std::uint32_t, Hash> points_;
};

}  // namespace

Mesh read_stl(const Source& source) { return StlReader(source).read(); }

}  // namespace springnet::meshes
