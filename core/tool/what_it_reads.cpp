#include "what_it_reads.hpp"

#include <string_view>

#include <fmt/format.h>

namespace springnet::tool {
namespace {

// "of a tetrahedron of nodes 0 to 3: lengths 01 02 03 12 13 23, volume 0123"
std::string scalars_of(const springnet_law& law) {
  static constexpr const char* shapes[] = {"a chain of nodes 0 to 2", "a triangle of nodes 0 to 2",
                                           "a hinge of nodes 0 to 3", "a tetrahedron of nodes 0 to 3"};
  std::string text = fmt::format("of {}:", shapes[law.shape - SPRINGNET_CHAIN]);
  std::string_view last;
  for (std::uint32_t i = 0; i < law.invariant_count; ++i) {
    const springnet_invariant& one = *law.invariants[i];
    std::string_view name = "dihedral";
    std::size_t count = 4;
    if (one.kind == SPRINGNET_VOLUME) name = "volume";
    if (one.kind == SPRINGNET_LENGTH) name = "lengths", count = 2;
    if (one.kind == SPRINGNET_ANGLE) name = "angles", count = 3;
    if (one.kind == SPRINGNET_AREA) name = "areas", count = 3;
    if (name != last) text += fmt::format("{} {}", last.empty() ? "" : ",", name);
    last = name;
    text += ' ';
    for (std::size_t c = 0; c < count; ++c) text += static_cast<char>('0' + one.corners[c]);
    if ((one.flags & SPRINGNET_REFERENCE_ONLY) != 0) text += " (at rest)";
  }
  return law.reads_direction != 0 ? text + ", and a direction of the material" : text;
}

}  // namespace

std::string what_it_reads(const springnet_law& law) {
  switch (law.invariant) {
    case SPRINGNET_RELATIVE_SPEED:
      return "the relative speed of two nodes, m/s";
    case SPRINGNET_ANGLE:
      return "an angle, rad";
    case SPRINGNET_AREA:
      return "the area of a triangle, m^2";
    case SPRINGNET_VOLUME:
      return "a volume, m^3";
    case SPRINGNET_ENCLOSED_VOLUME:
      return "the volume in a closed surface, m^3";
    case SPRINGNET_SEVERAL:
      return scalars_of(law);
    default:
      return "the distance of two nodes, m";
  }
}

}  // namespace springnet::tool
