#include "mesh_scene.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <springnet/material.hpp>

namespace springnet::tool {

namespace {

constexpr double gravity = 9.81;    // m/s^2
constexpr double density = 1000.0;  // kg/m^3
// Young's modulus over the weight per area of a column as long as the body, which then sags by 1 / (2 * stiffness) of
// its length.
constexpr double stiffness = 25.0;
// Nodes within this fraction of the body's size from its top, or from one end, are fixed.
constexpr double fixed_fraction = 0.02;
// Groups that the scene offers; a mesh may have thousands.
constexpr std::size_t max_groups = 20;

// As a TOML string.
std::string toml_text(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      result += fmt::format("\\u{:04x}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      result += c;
    }
  }
  return result + '"';
}

// Rounded to one digit, as people choose numbers.
double rounded(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  return std::round(value / power) * power;
}

std::string line(const std::string& setting, const std::string& comment) {
  return fmt::format("{:<40}  # {}\n", setting, comment);
}

// Which cells need a thickness or cross section, and whether edges alone would leave the body without shear stiffness.
struct Needs {
  bool thickness = false, cross_section = false, diagonals = false;
};

Needs needs_of(const Mesh& mesh) {
  Needs needs;
  for (const std::size_t cell : bearing_cells(mesh)) {
    const CellType type = mesh.types[cell];
    needs.thickness = needs.thickness || dimension_of(type) == 2;
    needs.cross_section = needs.cross_section || dimension_of(type) == 1;
    needs.diagonals =
        needs.diagonals || (dimension_of(type) > 1 && type != CellType::triangle && type != CellType::tetrahedron);
  }
  return needs;
}

struct Body {
  std::string name;
  double size;  // m
  double scale;
  std::string text;
};

Body body_of(const std::string& file, const Mesh& mesh, const MeshSummary& summary) {
  const UnitGuess& unit = summary.unit;
  Body body{std::filesystem::path(file).stem().string(), summary.whole.size() * unit.scale, unit.scale, ""};
  const Needs needs = needs_of(mesh);
  body.text = fmt::format("# {}\n# So the mesh is assumed to be in {}{}; its coordinates times `scale` are metres.\n",
                          unit.reason, unit.unit, unit.sure ? "" : ", which may be wrong");
  body.text += "[[body]]\n";
  body.text += fmt::format("name      = {}\n", toml_text(body.name));
  body.text += fmt::format("mesh      = {{ file = {}, scale = {:g}{} }}\n", toml_text(file), body.scale,
                           needs.diagonals ? ", diagonals = \"all\"" : "");
  body.text += "neuron    = { type = \"point_mass\" }\n";
  body.text += line(fmt::format("density   = {:g}", density), "kg/m^3, about that of water and tissue");
  if (needs.thickness) {
    body.text += line(fmt::format("thickness = {:g}", rounded(0.02 * body.size)), "m, of surface cells");
  }
  if (needs.cross_section) {
    body.text += line(fmt::format("cross_section = {:g}", rounded(1e-4 * body.size * body.size)), "m^2, of line cells");
  }
  const double modulus = rounded(stiffness * density * gravity * body.size);
  body.text += line(fmt::format("material  = {{ youngs_modulus = {:g}, damping_time = {:g} }}", modulus,
                                rounded(0.05 * std::sqrt(body.size / gravity))),
                    "Pa, s; the body stretches by some per cent under its weight");
  return body;
}

// The vertical axis, or the longest one if the body lies flat, as a beam of 10 x 1 x 1.
int fixed_axis(const MeshSummary& summary) {
  const Vector3 sides = summary.whole.upper - summary.whole.lower;
  int axis = 2;
  if (sides.z() < 0.2 * sides.maxCoeff()) sides.maxCoeff(&axis);
  return axis;
}

// The lower corner of a box around the uppermost nodes or, if the body lies flat, those at one end.
std::string fixed_corner(const MeshSummary& summary, double scale) {
  const Vector3 sides = scale * (summary.whole.upper - summary.whole.lower);
  const int axis = fixed_axis(summary);
  std::string corner;
  for (int k = 0; k < 3; ++k) {
    const double bound = scale * summary.whole.upper[k] - fixed_fraction * sides[k];
    corner += fmt::format("{}{}", k == 0 ? "" : ", ", k == axis ? fmt::format("{:.6g}", bound) : "-inf");
  }
  return corner;
}

// Groups that [[fix]] can use: a body with all nodes fixed would not move.
std::vector<std::string> fixable_groups(const MeshSummary& summary) {
  std::vector<std::string> names;
  for (const MeshExtent& group : summary.groups) {
    if (group.points < summary.whole.points) names.push_back(group.name);
  }
  return names;
}

}  // namespace

MeshScene scene_of(const std::string& file, const Mesh& mesh, const MeshSummary& summary) {
  const Body body = body_of(file, mesh, summary);
  const std::string name = toml_text(body.name);
  // About the period of its longitudinal vibration: 4 L sqrt(density / modulus) for a hanging column.
  const double period = 4.0 * std::sqrt(body.size / (stiffness * gravity));
  const double time_step = rounded(period / 40.0);
  std::string text = fmt::format(
      "# A scene to start from; it runs as it is. All quantities are in SI units. The page scene.md of the "
      "documentation\n"
      "# describes every key.\n"
      "title = {}\n\n[simulation]\n",
      toml_text(body.name + " hangs under its weight"));
  text += line(fmt::format("duration   = {:g}", 400.0 * time_step), "s");
  text += line(fmt::format("time_step  = {:g}", time_step),
               "s; `springnet inspect` reports limits and the slowest vibration");
  text += "integrator = { name = \"recurrent\", theta = 0.5 }\n\n[output]\n";
  text += line(fmt::format("interval = {:g}", 4.0 * time_step), "s between records");
  text += fmt::format("\n[gravity]\nacceleration = [0, 0, {:g}]  # m/s^2\n\n{}", -gravity, body.text);
  text +=
      fmt::format("\n# Fixed: {}.\n[[fix]]\nselect = {{ body = {}, box = {{ min = [{}] }} }}  # m\n",
                  fixed_axis(summary) == 2 ? "the uppermost nodes"
                                           : "the nodes at one end, because the body lies flat; the rest bends down",
                  name, fixed_corner(summary, body.scale));
  const std::vector<std::string> groups = fixable_groups(summary);
  if (!groups.empty()) text += "\n# The mesh has groups. To fix one of them instead:\n";
  const std::size_t offered = std::min(groups.size(), max_groups);
  for (std::size_t k = 0; k < offered; ++k) {
    text += fmt::format("# [[fix]]\n# select = {{ body = {}, group = {} }}\n", name, toml_text(groups[k]));
  }
  if (offered < groups.size()) {
    text += fmt::format("# There are {} more groups; `springnet inspect` of the mesh lists them.\n",
                        groups.size() - offered);
  }
  text += fmt::format(
      "\n# A floor for a body that falls; remove [[fix]], too.\n# [[plane]]\n# name   = \"floor\"\n"
      "# point  = [0, 0, {:.6g}]\n# normal = [0, 0, 1]\n",
      body.scale * summary.whole.lower.z() - 0.1 * body.size);
  if (summary.whole.dimension == 2) {
    text += fmt::format(
        "\n# Bending stiffness of the surface.\n# [[element]]\n# name      = \"wall\"\n# invariant = \"dihedral\"\n"
        "# select    = {{ body = {} }}\n# spring    = {{ type = \"linear\", stiffness = 1e-5 }}  # N m/rad\n",
        name);
  }
  if (summary.whole.dimension == 2 && summary.whole.enclosed) {
    const double volume = *summary.whole.enclosed * std::pow(body.scale, 3);
    text += fmt::format(
        "\n# The surface is closed; a filling keeps its volume.\n# [[element]]\n# name      = \"filling\"\n"
        "# invariant = \"enclosed_volume\"\n# select    = {{ body = {} }}\n"
        "# spring    = {{ type = \"linear\", stiffness = {:.1g} }}  # Pa/m^3: 1 kPa at a hundredth of {:.3g} m^3\n",
        name, 1e5 / volume, volume);
  }
  return {body.text, text};
}

}  // namespace springnet::tool
