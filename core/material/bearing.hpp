// What masses and stiffnesses share: the volume of a cell.
#pragma once

#include <cmath>
#include <string>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/material.hpp>

#include "mesh/coordinates.hpp"

namespace springnet::material {

[[noreturn]] inline void fail(const std::string& message) { throw Error(ErrorKind::input, message); }

// m^3, with the section of surface and line cells. Throws Error(input) where that is missing or not above 0.
[[nodiscard]] double volume_of(const Mesh& mesh, std::size_t cell, const Section& section);

}  // namespace springnet::material
