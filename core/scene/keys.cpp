#include "scene/keys.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <springnet/scene.hpp>

namespace springnet {
namespace scene {
namespace {

struct Key {
  std::string_view path;
  std::string_view form;
};

// "select.…" are the keys of every table that selects nodes or springs: node.select, connect.from and so on. "motion.…"
// and "turn.…" are those of motion and turn of planes and instruments, "values.…" those of every list of numbers that
// may come from a file.
constexpr std::array keys{
    Key{"version", "a whole number, 1"},
    Key{"title", "a text"},
    Key{"rules", "the name of a rule base (FCL)"},
    Key{"simulation", "a table"},
    Key{"simulation.duration", "a number of at least 0, s"},
    Key{"simulation.time_step", "a number above 0, s"},
    Key{"simulation.integrator", "the name of an integrator, or a table with its name and options"},
    Key{"simulation.integrator.name", "the name of an integrator"},
    Key{"simulation.threads", "a whole number, 0 for as many as useful"},
    Key{"simulation.instruction_set", "'best', 'generic', 'avx2' or 'avx512'"},
    Key{"simulation.renumber", "true or false"},
    Key{"gravity", "a table"},
    Key{"gravity.acceleration", "three numbers [x, y, z], m/s^2"},
    Key{"output", "a table"},
    Key{"output.interval", "a number of at least 0, s"},
    Key{"output.trajectory", "true or false"},
    Key{"output.reactions", "true or false"},
    Key{"output.surfaces", "true or false"},
    Key{"output.rigid", "true or false"},
    Key{"output.contacts", "true or false"},
    Key{"output.elements", "true, false or a list of names of [[element]]"},
    Key{"output.energies", "true or false"},
    Key{"output.states", "true or false"},
    Key{"output.nodes", "a selection of nodes"},
    Key{"output.springs", "a selection of springs"},
    Key{"output.quantities", "a list of 'position', 'velocity', 'force'"},
    Key{"output.format", "'csv' or 'binary'"},
    Key{"output.precision", "'double' or 'single'"},
    Key{"output.vtk", "true or false"},
    Key{"output.vtk_interval", "a number of at least 0, s"},
    Key{"output.view", "true or false"},
    Key{"output.view_size", "a number above 0, bytes"},
    Key{"body", "tables [[body]]"},
    Key{"body.name", "a text"},
    Key{"body.mesh", "a table with a lattice, a file or points"},
    Key{"body.mesh.lattice", "three whole numbers [nx, ny, nz]"},
    Key{"body.mesh.spacing", "a number above 0, or three of them [x, y, z], m"},
    Key{"body.mesh.file", "the name of a mesh file"},
    Key{"body.mesh.points", "the name of a file with points"},
    Key{"body.mesh.radius", "a number above 0, m"},
    Key{"body.mesh.neighbours", "a whole number of at least 1"},
    Key{"body.mesh.start", "the name of a mesh file"},
    Key{"body.mesh.scale", "a number above 0"},
    Key{"body.mesh.rotation", "a table with axis and angle"},
    Key{"body.mesh.rotation.axis", "three numbers [x, y, z]"},
    Key{"body.mesh.rotation.angle", "a number, rad"},
    Key{"body.mesh.origin", "three numbers [x, y, z], m"},
    Key{"body.mesh.diagonals", "'none', 'face', 'space' or 'all'"},
    Key{"body.nodes", "a list of positions [x, y, z], m"},
    Key{"body.springs", "a list of pairs [i, j] of node numbers"},
    Key{"body.rest_lengths", "a list of numbers of at least 0, m, one for each spring"},
    Key{"body.masses", "a list of numbers above 0, kg, one for each node"},
    Key{"body.velocities", "a list of velocities [x, y, z], m/s, one for each node"},
    Key{"body.faces", "a list of three node numbers [i, j, k] each"},
    Key{"body.groups", "a list of tables with name and nodes"},
    Key{"body.groups.name", "a text"},
    Key{"body.groups.nodes", "a list of node numbers"},
    Key{"body.velocity", "three numbers [x, y, z], m/s"},
    Key{"body.neuron", "a table with type, mass (unless the body has a mass or a density) and parameters"},
    Key{"body.neuron.type", "the name of a neuron"},
    Key{"body.neuron.mass", "a number above 0, kg"},
    Key{"body.surface_thickness", "a number of at least 0, m"},
    Key{"body.radius", "a number of at least 0, m"},
    Key{"body.mass", "a number above 0, kg"},
    Key{"body.density", "a number above 0, kg/m^3"},
    Key{"body.thickness", "a number above 0, m"},
    Key{"body.cross_section", "a number above 0, m^2"},
    Key{"body.material", "a table with youngs_modulus, or words that stand for it"},
    Key{"body.material.youngs_modulus", "a number above 0, Pa"},
    Key{"body.material.poisson_ratio", "a number between -1 and 0.5"},
    Key{"body.material.damping_time", "a number of at least 0, s"},
    Key{"body.material.direction", "[x, y, z], of any length but 0"},
    Key{"body.material.bending", "true or false"},
    Key{"body.material.law", "the name of a spring function, or a table with its type and parameters"},
    Key{"body.material.law.type", "the name of a spring function"},
    Key{"body.spring", "a table with type and parameters"},
    Key{"body.spring.type", "the name of a spring function"},
    Key{"body.viscosity", "a table with type and parameters"},
    Key{"body.viscosity.type", "the name of a viscosity function"},
    Key{"body.rest_length_scale", "a number above 0"},
    Key{"connect", "tables [[connect]]"},
    Key{"connect.pairs", "a list of pairs [{ body = \"a\", node = 0 }, { body = \"b\", node = 0 }]"},
    Key{"connect.pairs.body", "the name of a body"},
    Key{"connect.pairs.node", "the number of a node"},
    Key{"connect.from", "a selection of nodes"},
    Key{"connect.to", "a selection of nodes"},
    Key{"connect.within", "a number above 0, m"},
    Key{"connect.nearest", "true or false"},
    Key{"connect.spring", "a table with type and parameters"},
    Key{"connect.spring.type", "the name of a spring function"},
    Key{"connect.viscosity", "a table with type and parameters"},
    Key{"connect.viscosity.type", "the name of a viscosity function"},
    Key{"connect.rest_length", "a number of at least 0, m"},
    Key{"connect.rest_lengths", "a list of numbers of at least 0, m, one for each pair"},
    Key{"connect.rest_length_scale", "a number above 0"},
    Key{"rigid", "tables [[rigid]]"},
    Key{"rigid.pairs", "a list of pairs [{ body = \"a\", node = 0 }, { body = \"b\", node = 0 }]"},
    Key{"rigid.pairs.body", "the name of a body"},
    Key{"rigid.pairs.node", "the number of a node"},
    Key{"rigid.from", "a selection of nodes"},
    Key{"rigid.to", "a selection of nodes"},
    Key{"rigid.within", "a number above 0, m"},
    Key{"rigid.nearest", "true or false"},
    Key{"rigid.springs", "a selection of springs"},
    Key{"rigid.length", "a number above 0, m"},
    Key{"rigid.lengths", "a list of numbers above 0, m, one for each pair"},
    Key{"element", "tables [[element]]"},
    Key{"element.name", "a text"},
    Key{"element.invariant",
        "'angle', 'dihedral', 'area', 'volume', 'enclosed_volume', 'chain', 'triangle', 'hinge' or 'tetrahedron'"},
    Key{"element.direction", "[x, y, z], of any length but 0"},
    Key{"element.select", "a selection of nodes"},
    Key{"element.nodes", "a list of lists of node numbers"},
    Key{"element.body", "the name of a body"},
    Key{"element.spring", "a table with type and parameters"},
    Key{"element.spring.type", "the name of a spring function"},
    Key{"element.viscosity", "a table with type and parameters"},
    Key{"element.viscosity.type", "the name of a viscosity function"},
    Key{"element.reference", "a number, rad, m^2 or m^3"},
    Key{"element.reference_scale", "a number"},
    Key{"element.references", "a list of numbers, rad, m^2 or m^3, one for each element"},
    Key{"element.rests", "a list of positions [x, y, z], m, of the nodes of each element"},
    Key{"element.directions", "a list of directions [x, y, z], one for each element"},
    Key{"element.values", "the name of a CSV file with a row for each element"},
    Key{"node", "tables [[node]]"},
    Key{"node.select", "a selection of nodes"},
    Key{"node.mass", "a number above 0, kg"},
    Key{"node.velocity", "three numbers [x, y, z], m/s"},
    Key{"node.neuron", "a table with type and parameters"},
    Key{"node.neuron.type", "the name of a neuron"},
    Key{"spring", "tables [[spring]]"},
    Key{"spring.select", "a selection of springs"},
    Key{"spring.spring", "a table with type and parameters, or 'none'"},
    Key{"spring.spring.type", "the name of a spring function"},
    Key{"spring.viscosity", "a table with type and parameters, or 'none'"},
    Key{"spring.viscosity.type", "the name of a viscosity function"},
    Key{"spring.rest_length", "a number of at least 0, m"},
    Key{"spring.rest_length_scale", "a number above 0"},
    Key{"spring.values", "the name of a CSV file with a row for each spring"},
    Key{"fix", "tables [[fix]]"},
    Key{"fix.select", "a selection of nodes"},
    Key{"force", "tables [[force]]"},
    Key{"force.select", "a selection of nodes"},
    Key{"force.faces", "a list of three node numbers [i, j, k] each"},
    Key{"force.areas", "a list of area vectors [x, y, z], m^2, one for each face"},
    Key{"force.force", "three numbers [x, y, z], N"},
    Key{"force.total", "three numbers [x, y, z], N"},
    Key{"force.share", "'area' or 'nodes'"},
    Key{"force.traction", "three numbers [x, y, z], Pa"},
    Key{"force.pressure", "a number, Pa"},
    Key{"force.follow", "true or false"},
    Key{"force.from", "a number, s"},
    Key{"force.until", "a number, s"},
    Key{"force.table", "a list of rows [t, factor], s and 1"},
    Key{"force.interpolation", "'smooth' or 'linear'"},
    Key{"force.sinusoid", "a table with frequency"},
    Key{"force.sinusoid.frequency", "a number above 0, Hz"},
    Key{"force.sinusoid.phase", "a number, rad"},
    Key{"force.sinusoid.amplitude", "a number"},
    Key{"force.sinusoid.mean", "a number"},
    Key{"force.ramp", "a number above 0, s"},
    Key{"input", "tables [[input]]"},
    Key{"input.input", "the name of an input of laws"},
    Key{"input.name", "a text"},
    Key{"input.select", "a selection of springs"},
    Key{"input.elements", "a list of names of [[element]]"},
    Key{"input.times", "a list of numbers, s"},
    Key{"input.values", "a list of numbers"},
    Key{"input.file", "the path of a CSV file"},
    Key{"input.column", "the name of a column"},
    Key{"input.interpolation", "'hold', 'linear' or 'cubic'"},
    Key{"input.sinusoid", "a table with frequency and amplitude"},
    Key{"input.sinusoid.frequency", "a number above 0, Hz"},
    Key{"input.sinusoid.amplitude", "a number"},
    Key{"input.sinusoid.mean", "a number"},
    Key{"input.sinusoid.phase", "a number, rad"},
    Key{"input.value", "a number"},
    Key{"move", "tables [[move]]"},
    Key{"move.select", "a selection of nodes"},
    Key{"move.tracks", "the name of a file with columns time, node, x, y, z"},
    Key{"move.body", "the name of a body"},
    Key{"move.table", "a list of rows [t, x, y, z], s and m"},
    Key{"move.interpolation", "'smooth' or 'linear'"},
    Key{"move.sinusoid", "a table with amplitude and frequency"},
    Key{"move.sinusoid.amplitude", "three numbers [x, y, z], m"},
    Key{"move.sinusoid.frequency", "a number above 0, Hz"},
    Key{"move.sinusoid.phase", "a number, rad"},
    Key{"move.from", "a number, s"},
    Key{"move.until", "a number, s"},
    Key{"contact", "tables [[contact]]"},
    Key{"contact.name", "a text"},
    Key{"contact.between", "a list of one or two selections of nodes"},
    Key{"contact.friction", "'held', 'none' or a number of at least 0"},
    Key{"contact.restitution", "a number from 0 to 1"},
    Key{"plane", "tables [[plane]]"},
    Key{"plane.name", "a text"},
    Key{"plane.point", "three numbers [x, y, z], m"},
    Key{"plane.normal", "three numbers [x, y, z]"},
    Key{"plane.friction", "'held', 'none' or a number of at least 0"},
    Key{"plane.motion", "a table with table or sinusoid"},
    Key{"plane.turn", "a table with axis, and rate or table"},
    Key{"plane.restitution", "a number from 0 to 1"},
    Key{"instrument", "tables [[instrument]]"},
    Key{"instrument.name", "a text"},
    Key{"instrument.sphere", "a table with center and radius"},
    Key{"instrument.sphere.center", "three numbers [x, y, z], m"},
    Key{"instrument.sphere.radius", "a number above 0, m"},
    Key{"instrument.capsule", "a table with from, to and radius"},
    Key{"instrument.capsule.from", "three numbers [x, y, z], m"},
    Key{"instrument.capsule.to", "three numbers [x, y, z], m"},
    Key{"instrument.capsule.radius", "a number above 0, m"},
    Key{"instrument.box", "a table with center and size"},
    Key{"instrument.box.center", "three numbers [x, y, z], m"},
    Key{"instrument.box.size", "three numbers above 0 [x, y, z], m"},
    Key{"instrument.box.rotation", "a table with axis and angle"},
    Key{"instrument.box.rotation.axis", "three numbers [x, y, z]"},
    Key{"instrument.box.rotation.angle", "a number, rad"},
    Key{"instrument.box.axes", "three directions [x, y, z], at right angles"},
    Key{"instrument.box.radius", "a number of at least 0, m"},
    Key{"instrument.friction", "'held', 'none' or a number of at least 0"},
    Key{"instrument.motion", "a table with table or sinusoid"},
    Key{"instrument.turn", "a table with axis, and rate or table"},
    Key{"instrument.restitution", "a number from 0 to 1"},
    Key{"cut", "tables [[cut]]"},
    Key{"cut.time", "a number of at least 0, s"},
    Key{"cut.select", "a selection of springs"},
    Key{"cut.polygon", "a list of three corners [x, y, z] or more, m"},
    Key{"change", "tables [[change]]"},
    Key{"change.time", "a number of at least 0, s"},
    Key{"change.select", "a selection of springs or nodes"},
    Key{"change.elements", "a list of names of [[element]] tables"},
    Key{"change.spring", "a table of parameters"},
    Key{"change.viscosity", "a table of parameters"},
    Key{"change.inputs", "a table of values"},
    Key{"change.viscosity_inputs", "a table of values"},
    Key{"change.rest_length", "a number of at least 0, m"},
    Key{"change.rest_length_scale", "a number above 0"},
    Key{"change.reference", "a number"},
    Key{"change.reference_scale", "a number above 0"},
    Key{"change.neuron", "a table of parameters"},
    Key{"change.mass", "a number above 0, kg"},
    Key{"change.remove", "'springs', 'elements' or 'nodes'"},
    Key{"change.integrator", "the name of an integrator, or a table with name and options"},
    Key{"change.integrator.name", "the name of an integrator"},
    Key{"select.body", "the name of a body, or a list of them"},
    Key{"select.group", "the name of a group, or a list of them"},
    Key{"select.nodes", "a list of node numbers"},
    Key{"select.springs", "a list of spring numbers"},
    Key{"select.box", "a table with min, max or both"},
    Key{"select.box.min", "three numbers [x, y, z], m"},
    Key{"select.box.max", "three numbers [x, y, z], m"},
    Key{"select.sphere", "a table with center and radius"},
    Key{"select.sphere.center", "three numbers [x, y, z], m"},
    Key{"select.sphere.radius", "a number above 0, m"},
    Key{"values.file", "the name of a CSV file"},
    Key{"values.column", "the name of a column"},
    Key{"motion.table", "a list of rows [t, x, y, z], s and m"},
    Key{"motion.interpolation", "'smooth' or 'linear'"},
    Key{"motion.sinusoid", "a table with amplitude and frequency"},
    Key{"motion.sinusoid.amplitude", "three numbers [x, y, z], m"},
    Key{"motion.sinusoid.frequency", "a number above 0, Hz"},
    Key{"motion.sinusoid.phase", "a number, rad"},
    Key{"motion.from", "a number, s"},
    Key{"motion.until", "a number, s"},
    Key{"turn.axis", "three numbers [x, y, z]"},
    Key{"turn.through", "three numbers [x, y, z], m"},
    Key{"turn.rate", "a number other than 0, rad/s"},
    Key{"turn.from", "a number, s"},
    Key{"turn.until", "a number, s"},
    Key{"turn.table", "a list of rows [t, angle], s and rad"},
    Key{"turn.interpolation", "'smooth' or 'linear'"},
};

const Key* find_key(std::string_view path) {
  const auto* found = std::find_if(keys.begin(), keys.end(), [&](const Key& key) { return key.path == path; });
  return found == keys.end() ? nullptr : found;
}

}  // namespace

std::string_view form_of(std::string_view key) {
  const Key* found = find_key(key);
  if (found == nullptr) throw std::logic_error("the scene reader asks for the unlisted key " + std::string(key));
  return found->form;
}

std::string_view form_of_table(std::string_view table) {
  if (table == "select") return "a table with a selection";
  if (table == "motion") return "a table with table or sinusoid";
  if (table == "values") return "a list of numbers, or a table with file and column";
  if (table == "turn") return "a table with axis, and rate or table";
  const Key* found = find_key(table);
  return found != nullptr && found->form.starts_with("a table") ? found->form : "a table";
}

std::vector<std::string> keys_in(std::string_view table) {
  const std::string prefix = table.empty() ? "" : std::string(table) + ".";
  std::vector<std::string> names;
  for (const Key& key : keys) {
    if (!key.path.starts_with(prefix)) continue;
    const std::string_view name = key.path.substr(prefix.size());
    if (name.find('.') == std::string_view::npos) names.emplace_back(name);
  }
  return names;
}

std::vector<KeyForm> keys_named(std::string_view name) {
  std::vector<KeyForm> found;
  for (const Key& key : keys)
    if (key.path.substr(key.path.rfind('.') + 1) == name) found.push_back({key.path, key.form});
  return found;
}

}  // namespace scene

const std::vector<std::string>& scene_keys() {
  static const std::vector<std::string> paths = [] {
    std::vector<std::string> result;
    result.reserve(scene::keys.size());
    for (const scene::Key& key : scene::keys) result.emplace_back(key.path);
    return result;
  }();
  return paths;
}

}  // namespace springnet
