// Volume of a cell, for masses and stiffnesses.
#pragma once

#include <cmath>
#include <string>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/material.hpp>

#include "mesh/coordinates.hpp"

namespace springnet::material {

[[noreturn]] inline void fail(const std::string& message) { throw Error(ErrorKind::input, message); }

// Volume, m^3; for surface and line cells with their section. Throws Error(input) if that is missing or not above 0.
[[nodiscard]] double volume_of(const Mesh& mesh, std::size_t cell, const Section& section);

}  // namespace springnet::material
