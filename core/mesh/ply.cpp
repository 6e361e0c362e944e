// PLY, of scanners and point clouds: vertices, faces and edges, in text or binary form. A file of vertices alone gives
// a cell for each.
#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "mesh/builder.hpp"
#include "mesh/cursor.hpp"
#include "mesh/formats.hpp"

namespace springnet::meshes {
namespace {

enum class Type : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };
struct TypeName {
  std::string_view old, sized;
  Type type;
  std::size_t size;
};
constexpr std::array type_names{
    TypeName{"char", "int8", Type::i8, 1},      TypeName{"uchar", "uint8", Type::u8, 1},
    TypeName{"short", "int16", Type::i16, 2},   TypeName{"ushort", "uint16", Type::u16, 2},
    TypeName{"int", "int32", Type::i32, 4},     TypeName{"uint", "uint32", Type::u32, 4},
    TypeName{"float", "float32", Type::f32, 4}, TypeName{"double", "float64", Type::f64, 8}};

[[nodiscard]] std::size_t size_of(Type type) { return type_names[static_cast<std::size_t>(type)].size; }

class PlyReader {
 public:
  explicit PlyReader(const Source& source) : in_(source), builder_(source) {}

  Mesh read() {
    header();
    in_.set_binary(format_ != Format::text);
    for (const Element& element : elements_) read(element);
    if (!is_text() ? in_.left() > 0 : !in_.at_end()) builder_.note("What follows the last element is not read.");
    for (const Cell& cell : cells_) add(cell);
    if (builder_.cell_count() == 0)
      for (std::uint32_t k = 0; k < builder_.point_count(); ++k) builder_.add_cell(CellType::vertex, {&k, 1}, {});
    return std::move(builder_).finish();
  }

 private:
  enum class Format : std::uint8_t { text, little, big };
  struct Property {
    std::string name;
    Type type{};
    std::optional<Type> count{};  // of a list
  };
  struct Element {
    std::string name;
    std::uint64_t count = 0;
    Place place;
    std::vector<Property> properties{};
    [[nodiscard]] std::size_t find(std::string_view property) const {
      std::size_t k = 0;
      while (k < properties.size() && properties[k].name != property) ++k;
      return k;
    }
  };
  struct Cell {
    bool is_edge;
    std::size_t first_corner, end_corner;
    Place place;
  };

  [[nodiscard]] bool is_text() const { return format_ == Format::text; }

  // ---- header ----
  void header() {
    if (in_.word("'ply'") != "ply") in_.fail("a PLY file begins with 'ply'; this is another format, or damaged");
    bool has_format = false;
    for (;;) {
      const std::string_view keyword = in_.word("'end_header'");
      const Place place = in_.place();
      if (keyword == "end_header") {
        in_.line();
        break;
      }
      if (keyword == "format") {
        has_format = true;
        read_format();
      } else if (keyword == "element") {
        Element& element = elements_.emplace_back();
        element.name = in_.word("the name of an element");
        element.count = in_.integer<std::uint64_t>("the number of elements");
        element.place = place;
      } else if (keyword == "property") {
        read_property();
        continue;
      } else if (keyword != "comment" && keyword != "obj_info") {
        in_.fail("this is not a line of a PLY header: format, element, property, comment or end_header; correct it");
      }
      in_.line();
    }
    if (!has_format) in_.fail("the header has no 'format'; add one, as 'format ascii 1.0'");
    if (find_element("vertex") == nullptr) in_.fail("the header has no element 'vertex'; a mesh has points");
  }
  void read_format() {
    const std::string_view name = in_.word("the format");
    if (name == "ascii")
      format_ = Format::text;
    else if (name == "binary_little_endian")
      format_ = Format::little;
    else if (name == "binary_big_endian")
      format_ = Format::big;
    else
      in_.fail("the format is ascii, binary_little_endian or binary_big_endian; correct it");
    if (in_.word("the version") != "1.0") in_.fail("only version 1.0 of PLY is known; export the file again");
  }
  void read_property() {
    if (elements_.empty()) in_.fail("a property belongs to the element before it, and there is none; add one");
    Property property;
    const std::string_view first = in_.word("a type");
    if (first == "list") {
      property.count = type_of(in_.word("the type of a count"));
      if (*property.count == Type::f32 || *property.count == Type::f64)
        in_.fail("the number of items of a list is no whole number; correct its type");
      property.type = type_of(in_.word("the type of a list's items"));
    } else {
      property.type = type_of(first);
    }
    property.name = in_.word("the name of a property");
    elements_.back().properties.push_back(std::move(property));
    in_.line();
  }
  [[nodiscard]] Type type_of(std::string_view word) const {
    for (const TypeName& each : type_names)
      if (word == each.old || word == each.sized) return each.type;
    in_.fail("this is not a type of PLY: char, uchar, short, ushort, int, uint, float or double; correct it");
  }
  [[nodiscard]] const Element* find_element(std::string_view name) const {
    for (const Element& each : elements_)
      if (each.name == name) return &each;
    return nullptr;
  }

  // ---- values ----
  [[nodiscard]] double number(Type type, std::string_view what) {
    if (is_text()) return in_.real(what);
    const bool swap = (format_ == Format::little) != is_little;
    switch (type) {
      case Type::i8:
        return in_.binary<std::int8_t>(swap, what);
      case Type::u8:
        return in_.binary<std::uint8_t>(swap, what);
      case Type::i16:
        return in_.binary<std::int16_t>(swap, what);
      case Type::u16:
        return in_.binary<std::uint16_t>(swap, what);
      case Type::i32:
        return in_.binary<std::int32_t>(swap, what);
      case Type::u32:
        return in_.binary<std::uint32_t>(swap, what);
      case Type::f32:
        return static_cast<double>(in_.binary<float>(swap, what));
      default:
        return in_.binary<double>(swap, what);
    }
  }
  // A count or a point's number.
  [[nodiscard]] std::uint64_t whole(Type type, std::string_view what) {
    const double value = number(type, what);
    if (!(value >= 0.0 && value <= 4294967295.0) || value != static_cast<double>(static_cast<std::uint64_t>(value)))
      in_.fail(fmt::format("{} is not a whole number of 0 or more; correct it or export the file again", what));
    return static_cast<std::uint64_t>(value);
  }
  [[nodiscard]] std::uint64_t count_of(const Property& property) {
    const std::uint64_t count = whole(*property.count, "the number of a list's items");
    in_.check_count(count, is_text() ? 2 : size_of(property.type), "the list");
    return count;
  }
  // Reads the properties in [from, until) without keeping them.
  void skip(const Element& element, std::size_t from, std::size_t until) {
    for (std::size_t k = from; k < until; ++k) {
      const Property& property = element.properties[k];
      std::uint64_t count = property.count ? count_of(property) : 1;
      for (; count > 0; --count) {
        if (is_text())
          in_.word("a value");
        else
          in_.bytes(size_of(property.type), "a value");
      }
    }
  }

  // ---- elements ----
  void read(const Element& element) {
    if (element.count == 0) return;
    std::size_t bytes = 0;  // at least
    for (const Property& each : element.properties)
      bytes += is_text() ? 2 : size_of(each.count ? *each.count : each.type);
    if (bytes == 0) builder_.source().fail(element.place, "an element without properties; remove it");
    // The last number of a text may end the file.
    in_.check_count(element.count, is_text() ? std::max<std::size_t>(1, bytes - 1) : bytes, "the elements");
    if (element.name == "vertex") return vertices(element);
    if (element.name == "face") return faces(element);
    if (element.name == "edge") return edges(element);
    builder_.name_note("element is not read", "elements are not read", fmt::format("'{}'", element.name));
    for (std::uint64_t i = 0; i < element.count; ++i) skip(element, 0, element.properties.size());
  }

  void vertices(const Element& element) {
    std::array<std::size_t, 3> places{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string_view name = std::string_view("xyz").substr(axis, 1);
      places[axis] = element.find(name);
      if (places[axis] == element.properties.size() || element.properties[places[axis]].count)
        builder_.source().fail(element.place,
                               fmt::format("the vertices have no property '{}'; export the file again", name));
    }
    builder_.reserve_points(static_cast<std::size_t>(element.count));
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Vector3 position;
      const Place place = in_.here();
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        std::size_t axis = 0;
        while (axis < 3 && places[axis] != k) ++axis;
        if (axis < 3)
          position[static_cast<Eigen::Index>(axis)] = number(element.properties[k].type, "a coordinate");
        else
          skip(element, k, k + 1);
      }
      builder_.add_point(position, place);
    }
  }

  void faces(const Element& element) {
    std::size_t corners = element.find("vertex_indices");
    if (corners == element.properties.size()) corners = element.find("vertex_index");
    if (corners == element.properties.size() || !element.properties[corners].count)
      builder_.source().fail(element.place, "the faces have no list 'vertex_indices'; export the file again");
    const Property& property = element.properties[corners];
    for (std::uint64_t i = 0; i < element.count; ++i) {
      skip(element, 0, corners);
      const Place place = in_.here();
      const std::uint64_t count = count_of(property);
      if (count < 3) in_.fail(fmt::format("a face has {} points and needs 3 or more; correct it", count));
      add_corners(property.type, count, false, place);
      skip(element, corners + 1, element.properties.size());
    }
  }

  void edges(const Element& element) {
    const std::size_t first = element.find("vertex1"), second = element.find("vertex2");
    if (first >= second || second == element.properties.size() || element.properties[first].count ||
        element.properties[second].count)
      builder_.source().fail(element.place,
                             "the edges have no properties 'vertex1' and 'vertex2'; export the file again");
    for (std::uint64_t i = 0; i < element.count; ++i) {
      skip(element, 0, first);
      const Place place = in_.here();
      add_corners(element.properties[first].type, 1, true, place);
      skip(element, first + 1, second);
      corners_.push_back(static_cast<std::uint32_t>(whole(element.properties[second].type, "a point's number")));
      cells_.back().end_corner = corners_.size();
      skip(element, second + 1, element.properties.size());
    }
  }

  void add_corners(Type type, std::uint64_t count, bool is_edge, Place place) {
    const std::size_t first = corners_.size();
    for (std::uint64_t k = 0; k < count; ++k)
      corners_.push_back(static_cast<std::uint32_t>(whole(type, "a point's number")));
    cells_.push_back({is_edge, first, corners_.size(), place});
  }

  // Cells may come before the points.
  void add(const Cell& cell) {
    const std::span<const std::uint32_t> corners(corners_.data() + cell.first_corner,
                                                 cell.end_corner - cell.first_corner);
    for (const std::uint32_t corner : corners)
      if (corner >= builder_.point_count())
        builder_.source().fail(cell.place,
                               fmt::format("there is no point {}: the file has {}, numbered from 0; correct "
                                           "the number",
                                           corner, builder_.point_count()));
    if (cell.is_edge)
      builder_.add_cell(CellType::line, corners, cell.place);
    else
      builder_.add_polygon(corners, cell.place);
  }

  static constexpr bool is_little = std::endian::native == std::endian::little;
  Cursor in_;
  Builder builder_;
  Format format_ = Format::text;
  std::vector<Element> elements_;
  std::vector<std::uint32_t> corners_;
  std::vector<Cell> cells_;
};

}  // namespace

Mesh read_ply(const Source& source) { return PlyReader(source).read(); }

}  // namespace springnet::meshes
