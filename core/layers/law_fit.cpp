#include "layers/law_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "network/corners.hpp"

namespace springnet::layers {
namespace {

// For messages.
std::string_view reading(std::uint32_t invariant) {
  switch (invariant) {
    case SPRINGNET_RELATIVE_SPEED:
      return "the relative speed of two nodes";
    case SPRINGNET_ANGLE:
      return "an angle";
    case SPRINGNET_AREA:
      return "an area";
    case SPRINGNET_VOLUME:
      return "a volume";
    case SPRINGNET_ENCLOSED_VOLUME:
      return "an enclosed volume";
    case SPRINGNET_SEVERAL:
      return "several scalars of an element";
    default:
      return "a length";
  }
}

bool reads_several_scalars(const Component& law) { return law.law().invariant == SPRINGNET_SEVERAL; }

// The elements that a law over several scalars is for.
Invariant shape_of(const Component& law) {
  switch (law.law().shape) {
    case SPRINGNET_CHAIN:
      return Invariant::chain;
    case SPRINGNET_TRIANGLE:
      return Invariant::triangle;
    case SPRINGNET_HINGE:
      return Invariant::hinge;
    default:
      return Invariant::tetrahedron;
  }
}

bool can(const Component& law, std::uint64_t capability) { return (law.description->capabilities & capability) != 0; }

// A law of a length is a formula in one scalar and its rate; its author says whether it may be used on any invariant.
bool fits(const Component& law, Invariant invariant) {
  switch (law.law().invariant) {
    case SPRINGNET_LENGTH:
      return can(law, SPRINGNET_FITS_ELEMENTS);
    case SPRINGNET_ANGLE:
      return invariant == Invariant::angle || invariant == Invariant::dihedral;
    case SPRINGNET_AREA:
      return invariant == Invariant::area;
    case SPRINGNET_VOLUME:
      return invariant == Invariant::volume || invariant == Invariant::enclosed_volume;
    case SPRINGNET_ENCLOSED_VOLUME:
      return invariant == Invariant::enclosed_volume;
    default:
      return false;
  }
}

// What is wrong with the shape of its nodes at rest: laws divide by its size.
std::string flatness(const Element& element) {
  double longest = 0.0;
  for (const Vector3& a : element.rest)
    for (const Vector3& b : element.rest) longest = std::max(longest, (a - b).norm());
  // Of the size of a regular one. Strains come from lengths, whose rounding they have 1e-16 / least^2 times: half of
  // the digits or more are lost in what is refused.
  constexpr double least = 1e-7;
  const auto flat = [&](double size, double dimension) {
    return !(std::abs(size) > least * std::pow(longest, dimension));
  };
  const auto area = [&](std::size_t a, std::size_t b, std::size_t c) {
    return 0.5 * (element.rest[b] - element.rest[a]).cross(element.rest[c] - element.rest[a]).norm();
  };
  if (element.invariant == Invariant::tetrahedron && flat(element.reference, 3.0))
    return "needs a volume at rest, and the four nodes lie (nearly) in a plane; move one, or leave the element out";
  if (element.invariant == Invariant::tetrahedron && element.reference < 0.0)
    return "needs a volume above 0 at rest; exchange two of its nodes";
  if (element.invariant == Invariant::triangle && flat(element.reference, 2.0))
    return "needs an area at rest, and the three nodes lie (nearly) on a line; move one, or leave the element out";
  if (element.invariant == Invariant::hinge && (flat(area(0, 1, 2), 2.0) || flat(area(0, 1, 3), 2.0)))
    return "needs two triangles at rest, and one has (nearly) no area; move a node, or leave the element out";
  return {};
}

}  // namespace

std::string misfit(const Component& law) {
  const std::uint32_t invariant = law.law().invariant;
  if (invariant == SPRINGNET_LENGTH || invariant == SPRINGNET_RELATIVE_SPEED) return {};
  if (reads_several_scalars(law))
    return fmt::format("is for elements ({}), not for springs; give it those, or use a law on the length",
                       name_of(shape_of(law)));
  return fmt::format("reads {}; use a law on the length or the relative speed of two nodes", reading(invariant));
}

std::string misfit(const Component& law, const Element& element) {
  const Invariant invariant = element.invariant;
  const springnet_law& description = law.law();
  if (reads_several_scalars(law)) {
    if (shape_of(law) != invariant)
      return fmt::format("is for elements of {}; give it those, or use another law", name_of(shape_of(law)));
    if (description.state_count > 0)
      return "has internal states, which laws over several scalars cannot have; use another law";
    if (description.reads_direction != 0 && element.direction == Vector3::Zero())
      return "reads a direction of the material; give the element one";
    return flatness(element);
  }
  if (reads_several(invariant))
    return fmt::format("reads {}; use a law over several scalars of a {}, or elements of {}",
                       reading(description.invariant), name_of(invariant), name_of(value_invariant(invariant)));
  if (!fits(law, invariant))
    return fmt::format("reads {}; use a law on the length that declares that it fits elements, or one made for this",
                       reading(description.invariant));
  if (can(law, SPRINGNET_DIVIDES_BY_REFERENCE) && !(element.reference > 0.0))
    return fmt::format("divides by the reference value, which is {} here; give one above 0, or use another law",
                       element.reference);
  return {};
}

}  // namespace springnet::layers
