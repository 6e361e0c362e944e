// Gmsh's MSH 4.0 and 4.1 (Gmsh reference manual, "File formats").
#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "mesh/builder.hpp"
#include "mesh/cursor.hpp"
#include "mesh/formats.hpp"

namespace springnet::meshes {
namespace {

// Gmsh's Lagrange elements (GmshDefines.h), complete and incomplete, up to order 10. They begin with their corners,
// ordered as in the first element of their kind. Pairs of type number and node count.
constexpr std::array vertex_types{15, 1};
constexpr std::array line_types{1, 2, 8, 3, 26, 4, 27, 5, 28, 6, 62, 7, 63, 8, 64, 9, 65, 10, 66, 11};
constexpr std::array triangle_types{2,  3,  9,  6,  20, 9,  21, 10, 22, 12, 23, 15, 24, 15, 25, 21, 42, 28,
                                    43, 36, 44, 45, 45, 55, 46, 66, 52, 18, 53, 21, 54, 24, 55, 27, 56, 30};
constexpr std::array quadrilateral_types{3,  4,  10, 9,  16, 8,  36,  16, 37,  25, 38, 36, 39, 12, 40, 16, 41, 20, 47,
                                         49, 48, 64, 49, 81, 50, 100, 51, 121, 57, 24, 58, 28, 59, 32, 60, 36, 61, 40};
constexpr std::array tetrahedron_types{4,  4,   11, 10,  29, 20,  30, 35, 31, 56, 32, 22, 33, 28, 71, 84, 72,  120,
                                       73, 165, 74, 220, 75, 286, 79, 34, 80, 40, 81, 46, 82, 52, 83, 58, 137, 16};
constexpr std::array hexahedron_types{5,   8,  12,   27, 17, 20,  92, 64,  93, 125, 94, 216, 95, 343, 96, 512, 97,
                                      729, 98, 1000, 99, 32, 100, 44, 101, 56, 102, 68, 103, 80, 104, 92, 105, 104};
constexpr std::array wedge_types{6,   6,   13,  18,  18, 15,  90, 40,  91, 75,  106, 126, 107, 196, 108, 288, 109,
                                 405, 110, 550, 111, 24, 112, 33, 113, 42, 114, 51,  115, 60,  116, 69,  117, 78};
constexpr std::array pyramid_types{7,   5,   14,  14,  19, 13,  118, 30,  119, 55,  120, 91,  121, 140, 122, 204, 123,
                                   285, 124, 385, 125, 21, 126, 29,  127, 37,  128, 45,  129, 53,  130, 61,  131, 69};
struct Kind {
  CellType cell;
  std::span<const int> types;
};
constexpr std::array kinds{Kind{CellType::vertex, vertex_types},
                           Kind{CellType::line, line_types},
                           Kind{CellType::triangle, triangle_types},
                           Kind{CellType::quadrilateral, quadrilateral_types},
                           Kind{CellType::tetrahedron, tetrahedron_types},
                           Kind{CellType::hexahedron, hexahedron_types},
                           Kind{CellType::wedge, wedge_types},
                           Kind{CellType::pyramid, pyramid_types}};

struct ElementType {
  CellType cell;
  std::size_t nodes;
};
std::optional<ElementType> element_type(int number) {
  for (const auto& [cell, types] : kinds) {
    for (std::size_t k = 0; k < types.size(); k += 2) {
      if (types[k] == number) return ElementType{cell, static_cast<std::size_t>(types[k + 1])};
    }
  }
  return std::nullopt;
}
constexpr std::size_t max_nodes = 1000;

constexpr std::array dimension_names{"point", "curve", "surface", "volume"};

using EntityKey = std::pair<int, int>;  // dimension, number

// Maps the node numbers of the file, which may have gaps, to points.
class Tags {
 public:
  void add(std::uint64_t tag, std::uint32_t point) { entries_.emplace_back(tag, point); }
  // Sorts; returns the first duplicate tag, if any.
  std::optional<std::uint64_t> sort() {
    if (!std::is_sorted(entries_.begin(), entries_.end())) std::sort(entries_.begin(), entries_.end());
    for (std::size_t i = 1; i < entries_.size(); ++i) {
      if (entries_[i].first == entries_[i - 1].first) return entries_[i].first;
    }
    first_ = entries_.empty() ? 0 : entries_.front().first;
    if (entries_.empty() || entries_.back().first - first_ >= 8 * entries_.size()) return std::nullopt;
    dense_.assign(entries_.back().first - first_ + 1, none);
    for (const auto& [tag, point] : entries_) dense_[tag - first_] = point;
    return std::nullopt;
  }
  [[nodiscard]] std::optional<std::uint32_t> find(std::uint64_t tag) const {
    if (!dense_.empty()) {
      if (tag < first_ || tag - first_ >= dense_.size() || dense_[tag - first_] == none) return std::nullopt;
      return dense_[tag - first_];
    }
    const auto found = std::lower_bound(entries_.begin(), entries_.end(), std::pair{tag, std::uint32_t{0}});
    if (found == entries_.end() || found->first != tag) return std::nullopt;
    return found->second;
  }
  [[nodiscard]] bool empty() const { return entries_.empty(); }

 private:
  static constexpr std::uint32_t none = UINT32_MAX;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> entries_;
  std::vector<std::uint32_t> dense_;  // [tag - first_], if there are few gaps
  std::uint64_t first_ = 0;
};

class GmshReader {
 public:
  explicit GmshReader(const Source& source) : in_(source), builder_(source) {}

  Mesh read() {
    format();
    bool has_elements = false;
    while (!in_.at_end()) {
      const std::string section(in_.word("a section"));
      if (section.size() < 2 || section[0] != '$' || section.starts_with("$End")) {
        in_.fail("this should be the beginning of a section, as $Nodes; export the mesh again");
      }
      in_.line();
      in_.set_binary(binary_);
      if (section == "$PhysicalNames") {
        in_.set_binary(false);
        physical_names();
      } else if (section == "$Entities") {
        entities();
      } else if (section == "$Nodes") {
        nodes();
      } else if (section == "$Elements") {
        elements();
        has_elements = true;
      } else {
        skip(section);
        continue;
      }
      end(section);
    }
    if (!has_nodes_) in_.fail("there is no $Nodes section; the file is cut off, export the mesh again");
    if (!has_elements) in_.fail("there is no $Elements section; the file is cut off, export the mesh again");
    single_points();
    return std::move(builder_).finish();
  }

 private:
  // Numbers in text or binary form.
  int small(std::string_view what) {
    return binary_ ? in_.binary<std::int32_t>(swap_, what) : in_.integer<std::int32_t>(what);
  }
  std::uint64_t large(std::string_view what) {
    return binary_ ? in_.binary<std::uint64_t>(swap_, what) : in_.integer<std::uint64_t>(what);
  }
  double real(std::string_view what) {
    if (!binary_) return in_.real(what);
    return in_.binary<double>(swap_, what);
  }
  std::size_t count(std::string_view what, std::size_t text_bytes, std::size_t binary_bytes) {
    const std::uint64_t value = large(what);
    in_.check_count(value, binary_ ? binary_bytes : text_bytes, what);
    return static_cast<std::size_t>(value);
  }
  // Node and element numbers have 64 bits since 4.1.
  std::uint64_t tag(std::string_view what) {
    if (!old_) return large(what);
    const int value = small(what);
    if (value < 0) in_.fail(fmt::format("{} is {}, below 0; export the mesh again", what, value));
    return static_cast<std::uint64_t>(value);
  }
  std::size_t tag_size() const { return old_ ? sizeof(std::int32_t) : sizeof(std::uint64_t); }

  void format() {
    if (in_.word("$MeshFormat") != "$MeshFormat") {
      in_.fail(
          "a Gmsh file begins with $MeshFormat; this is another format (give the file its own ending), or MSH 1: "
          "save it as version 4 (gmsh -save -format msh41)");
    }
    const std::string_view version = in_.word("the version");
    if (version != "4.1" && version != "4" && version != "4.0") {
      double number = 0.0;
      const bool is_number = version.size() <= 4 && parse_real(version, number);
      in_.fail(fmt::format(
          "this is {} of MSH, only 4.0 and 4.1 are supported; save it as version 4: gmsh FILE -save -format msh41 -o "
          "NEW.msh",
          is_number ? fmt::format("version {}", version) : "another version"));
    }
    old_ = version != "4.1";
    const int kind = in_.integer<std::int32_t>("the kind of file");
    if (kind != 0 && kind != 1)
      in_.fail(fmt::format("the kind of file is {}, not 0 (text) or 1 (binary); export the mesh again", kind));
    binary_ = kind == 1;
    const int size = in_.integer<std::int32_t>("the size of numbers");
    if (size != 8)
      in_.fail(fmt::format("numbers have {} bytes, only 8 are supported; save it with a 64-bit Gmsh", size));
    if (binary_) {
      in_.line();
      const std::string_view one = in_.bytes(sizeof(std::int32_t), "the byte order");
      swap_ = from_bytes<std::int32_t>(one.data(), false) != 1;
      if (from_bytes<std::int32_t>(one.data(), swap_) != 1) {
        in_.set_binary(true);
        in_.fail("the byte order cannot be determined; the file is damaged, export the mesh again");
      }
    }
    end("$MeshFormat");
  }

  void end(std::string_view section) {
    const std::string_view word = in_.word("the end of a section");
    if (word.substr(0, 4) == "$End" && word.substr(4) == section.substr(1)) return in_.set_binary(false);
    in_.fail(
        fmt::format("this should be $End{}; counts in this section do not match its contents, export the mesh again",
                    section.substr(1)));
  }

  void skip(const std::string& section) {
    const std::string wanted = "$End" + section.substr(1);
    const std::size_t found = in_.source().text().find(wanted, in_.offset());
    if (found == std::string_view::npos) {
      in_.fail("this section has no end; the file is cut off, export the mesh again");
    }
    in_.skip_to(found + wanted.size());
    in_.set_binary(false);
    if (section == "$PartitionedEntities") {
      builder_.note(
          "the mesh is divided into partitions: their physical groups are not read (save it without partitions)");
    } else if (section != "$Comments") {
      builder_.name_note("section is not read", "sections are not read", section);
    }
  }

  void physical_names() {
    const std::size_t names = in_.count("the number of physical names", 6);
    for (std::size_t i = 0; i < names; ++i) {
      const int dimension = in_.integer<std::int32_t>("the dimension of a physical name");
      if (dimension < 0 || dimension > 3)
        in_.fail(fmt::format("dimension {} of a physical name is not 0 to 3; export the mesh again", dimension));
      const int number = in_.integer<std::int32_t>("the number of a physical name");
      const std::string_view rest = in_.line();
      const std::size_t open = rest.find('"'), close = rest.rfind('"');
      if (open == std::string_view::npos || close < open + 2) {
        in_.fail(fmt::format("physical group {} has no name in quotes; write it as {} {} \"name\"", number, dimension,
                             number));
      }
      names_[{dimension, number}] = rest.substr(open + 1, close - open - 1);
    }
  }

  void entities() {
    std::array<std::uint64_t, 4> counts{};
    for (std::uint64_t& value : counts) value = count("a number of entities", 8, 12);
    for (int dimension = 0; dimension < 4; ++dimension) {
      for (std::uint64_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) {
        const int number = small("the number of an entity");
        const int reals = dimension == 0 && !old_ ? 3 : 6;
        for (int k = 0; k < reals; ++k) real("a bound of an entity");
        const std::size_t physicals = count("the number of physical groups", 2, 4);
        for (std::size_t k = 0; k < physicals; ++k) {
          // Negative numbers mark entities of reversed orientation.
          const std::int64_t physical = small("the number of a physical group");
          physicals_[{dimension, number}].push_back(static_cast<int>(std::abs(physical) & INT32_MAX));
        }
        if (dimension == 0) continue;
        const std::size_t bounds = count("the number of bounding entities", 2, 4);
        for (std::size_t k = 0; k < bounds; ++k) small("the number of a bounding entity");
      }
    }
    for (auto& [entity, physicals] : physicals_) {
      std::sort(physicals.begin(), physicals.end());
      physicals.erase(std::unique(physicals.begin(), physicals.end()), physicals.end());
    }
  }

  struct Block {
    int dimension;
    int entity;
    int kind;  // parametric flag of nodes, or type of elements
  };
  Block block(std::string_view what) {
    int dimension = small("the dimension of an entity"), entity = 0;
    if (old_) {
      entity = dimension;
      dimension = small("the dimension of an entity");
    } else {
      entity = small("the number of an entity");
    }
    if (dimension < 0 || dimension > 3) {
      in_.fail(fmt::format("dimension {} of an entity is not 0 to 3; the file is damaged, export it again", dimension));
    }
    return {dimension, entity, small(what)};
  }

  struct Totals {
    std::size_t blocks;
    std::uint64_t things;
  };
  Totals totals(std::string_view what) {
    const Totals result{count("the number of blocks", 8, 20), large(what)};
    if (!old_) {
      large("the lowest number");
      large("the highest number");
    }
    return result;
  }
  void check_total(std::string_view what, std::uint64_t promised, std::uint64_t found) const {
    if (promised == found) return;
    in_.fail(fmt::format("there are {} {}, but {} were declared; the file is damaged, export it again", found, what,
                         promised));
  }

  void nodes() {
    if (has_nodes_) in_.fail("there are two $Nodes sections; export the mesh again");
    has_nodes_ = true;
    const auto [blocks, promised] = totals("the number of nodes");
    std::uint64_t found = 0;
    std::vector<std::uint64_t> tags;
    for (std::size_t i = 0; i < blocks; ++i) {
      const auto [dimension, entity, parametric] = block("whether nodes are parametric");
      const std::size_t more = parametric == 0 ? 0 : static_cast<std::size_t>(dimension);
      const std::size_t size = count("the number of nodes of a block", 8 + 2 * more, tag_size() + 8 * (3 + more));
      builder_.reserve_points(size);
      if (!old_) {
        tags.clear();
        tags.reserve(size);
        for (std::size_t k = 0; k < size; ++k) tags.push_back(tag("the number of a node"));
      }
      for (std::size_t k = 0; k < size; ++k) {
        const std::uint64_t number = old_ ? tag("the number of a node") : tags[k];
        const Place place = in_.here();
        Vector3 position;
        for (double& coordinate : position) coordinate = real("a coordinate");
        for (std::size_t p = 0; p < more; ++p) real("a parameter of a node");
        tags_.add(number, builder_.add_point(position, place));
      }
      found += size;
    }
    check_total("nodes", promised, found);
    if (const auto twice = tags_.sort())
      in_.fail(fmt::format("two nodes have the number {}; export the mesh again", *twice));
  }

  // Groups of the entity, without duplicates; creates new ones.
  const std::vector<std::size_t>& groups_of(int dimension, int entity) {
    const auto [known, is_new] = groups_.try_emplace({dimension, entity});
    std::vector<std::size_t>& groups = known->second;
    const auto found = physicals_.find({dimension, entity});
    if (!is_new || found == physicals_.end()) return groups;
    for (const int number : found->second) {
      const auto name = names_.find({dimension, number});
      groups.push_back(builder_.group(
          name != names_.end() ? name->second
                               : fmt::format("{} {}", dimension_names[static_cast<std::size_t>(dimension)], number)));
    }
    std::sort(groups.begin(), groups.end());  // two numbers may have one name
    groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
    return groups;
  }

  void elements() {
    if (!has_nodes_) in_.fail("$Elements comes before $Nodes; export the mesh again");
    const auto [blocks, promised] = totals("the number of elements");
    std::uint64_t found = 0;
    for (std::size_t i = 0; i < blocks; ++i) {
      const auto [dimension, entity, number] = block("the type of elements");
      const auto type = element_type(number);
      if (!type) {
        in_.fail(
            fmt::format("elements are of the unknown type {}; save the mesh with elements of first order "
                        "(gmsh -order 1)",
                        number));
      }
      const std::size_t size =
          count("the number of elements of a block", 2 * (type->nodes + 1), tag_size() * (type->nodes + 1));
      element_block(*type, size, groups_of(dimension, entity));
      found += size;
    }
    check_total("elements", promised, found);
  }

  void element_block(const ElementType& type, std::size_t size, const std::vector<std::size_t>& groups) {
    const std::size_t first = builder_.cell_count();
    std::array<std::uint32_t, max_nodes> points{};
    if (type.cell != CellType::vertex) builder_.reserve_cells(type.cell, size);
    for (std::size_t k = 0; k < size; ++k) {
      tag("the number of an element");
      const Place place = in_.place();
      for (std::size_t n = 0; n < type.nodes; ++n) {
        const std::uint64_t number = tag("a node of an element");
        const auto point = tags_.find(number);
        if (!point) {
          in_.fail(fmt::format("an element has node {}, which is not in $Nodes; export the mesh again", number));
        }
        points[n] = *point;
      }
      if (type.cell == CellType::vertex && groups.empty()) {
        singles_.emplace_back(points[0], place);
      } else {
        builder_.add_cell(type.cell, std::span(points.data(), corner_count(type.cell)), place);
      }
    }
    // Skip empty blocks: there may be as many as groups of an entity.
    if (builder_.cell_count() > first) {
      for (const std::size_t group : groups) builder_.add_cells_to_group(group, first, builder_.cell_count());
    }
    if (size > 0 && type.nodes > corner_count(type.cell)) {
      builder_.count_note("element of second or higher order is read without the nodes between its corners",
                          "elements of second or higher order are read without the nodes between their corners", size);
    }
  }

  // Point elements without a group: Gmsh writes one for each point of the geometry, even for centres of arcs, which are
  // not part of the body.
  void single_points() {
    const bool alone = builder_.cell_count() == 0;
    const std::vector<bool> used = builder_.used_points();
    for (const auto& [point, place] : singles_) {
      if (alone || used[point]) builder_.add_cell(CellType::vertex, std::array{point}, place);
    }
  }

  Cursor in_;
  Builder builder_;
  bool old_ = false;  // 4.0
  bool binary_ = false;
  bool swap_ = false;
  bool has_nodes_ = false;
  Tags tags_;
  std::map<EntityKey, std::string> names_;                // [dimension, number of the physical group]
  std::map<EntityKey, std::vector<int>> physicals_;       // [entity] physical groups; ascending, unique
  std::map<EntityKey, std::vector<std::size_t>> groups_;  // [entity] groups of the builder
  std::vector<std::pair<std::uint32_t, Place>> singles_;
};

}  // namespace

Mesh read_gmsh(const Source& source) { return GmshReader(source).read(); }

}  // namespace springnet::meshes
