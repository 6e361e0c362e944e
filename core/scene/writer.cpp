#include <springnet/scene_writer.hpp>

#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/output_folder.hpp>
#include <springnet/printable.hpp>

#include "scene/writing.hpp"

namespace springnet {
namespace scene {
namespace {

using namespace toml_text;

constexpr std::size_t longest_scene = 64'000'000;  // bytes, as they are read

std::string flag(bool value) { return value ? "true" : "false"; }

void write_simulation(const Scene& scene, const PluginHost& plugins, Document& out) {
  const SimulationOptions& options = scene.options;
  out.begin("[simulation]");
  out.add("duration", number(scene.duration));
  out.add("time_step", number(options.time_step));
  out.add("integrator", text_of(options.integrator, ComponentKind::integrator, plugins, "name"));
  if (options.threads != 0) out.add("threads", std::to_string(options.threads));
  const char* const sets[] = {"best", "generic", "avx2", "avx512"};
  if (options.instruction_set != InstructionSet::best)
    out.add("instruction_set", in_quotes(sets[static_cast<std::size_t>(options.instruction_set)]));
  if (!options.renumber) out.add("renumber", "false");
}

void write_output(const Scene& scene, const WrittenElements& elements, Document& out) {
  const OutputOptions& output = scene.output;
  out.begin("[output]");
  out.add("interval", number(output.interval));
  out.add("trajectory", flag(output.trajectory));
  out.add("reactions", flag(output.reactions));
  out.add("surfaces", flag(output.surfaces));
  out.add("rigid", flag(output.rigid));
  out.add("contacts", flag(output.contacts));
  out.add("energies", flag(output.energies));
  out.add("states", flag(output.states));
  if (output.elements && !output.element_numbers.empty())
    out.add("elements", elements.names_of(output.element_numbers, "output.elements"));
  else
    out.add("elements", flag(output.elements));
  if (!output.nodes.empty()) out.add("nodes", Inline().add("nodes", whole_numbers(output.nodes)).text());
  if (!output.springs.empty()) out.add("springs", Inline().add("springs", whole_numbers(output.springs)).text());
  std::vector<std::string> quantities;
  if (output.position) quantities.push_back(in_quotes("position"));
  if (output.velocity) quantities.push_back(in_quotes("velocity"));
  if (output.force) quantities.push_back(in_quotes("force"));
  if (!quantities.empty()) out.add("quantities", list(quantities.size(), [&](std::size_t k) { return quantities[k]; }));
  out.add("format", in_quotes(output.format == OutputOptions::Format::binary ? "binary" : "csv"));
  out.add("precision", in_quotes(output.precision == OutputOptions::Precision::float32 ? "single" : "double"));
  out.add("vtk", flag(output.vtk));
  out.add("vtk_interval", number(output.vtk_interval));
  out.add("view", flag(output.view));
  out.add("view_size", number(output.view_size));
}

}  // namespace
}  // namespace scene

namespace scene {
namespace {

std::string text_of_scene(const Scene& scene, const PluginHost& plugins, ValueFiles& values) {
  const Network& network = scene.network;
  if (network.nodes().empty()) throw Error(ErrorKind::input, "a scene needs a network with nodes; this one has none");
  Document out;
  if (!scene.title.empty()) out.add("title", in_quotes(scene.title));
  write_simulation(scene, plugins, out);
  if (!same_bits(network.gravity(), Vector3::Zero())) {
    out.begin("[gravity]");
    out.add("acceleration", vector(network.gravity()));
  }
  const WrittenElements elements(scene, plugins, values);
  write_output(scene, elements, out);
  write_bodies(network, plugins, values, out);
  elements.write(out);
  write_node_changes(network, plugins, values, out);
  write_loads(network, out);
  write_surroundings(network, out);
  write_inputs(network, elements, out);
  write_changes(network, plugins, elements, out);
  if (out.text().size() > longest_scene)
    throw Error(ErrorKind::input,
                fmt::format("the network is too large for a scene: its text has {} bytes, at most {} are read",
                            out.text().size(), longest_scene));
  return out.text();
}

}  // namespace
}  // namespace scene

std::string to_scene(const Scene& scene, const PluginHost& plugins) {
  scene::ValueFiles none(scene.network);
  return scene::text_of_scene(scene, plugins, none);
}

SceneWithTables to_scene_with_tables(const Scene& scene, const PluginHost& plugins, const std::string& stem) {
  scene::ValueFiles values(scene.network, plugins, stem);
  std::string text = scene::text_of_scene(scene, plugins, values);
  return {std::move(text), std::move(values.files())};
}

void write_scene(const Scene& scene, const PluginHost& plugins, const std::filesystem::path& file) {
  const std::string text = to_scene(scene, plugins);
  try {
    write_whole(OutputFile(file), text);
  } catch (const Error& error) {
    throw Error(ErrorKind::input,
                fmt::format("the scene '{}' cannot be written: {}", printable(file.string()), error.what()));
  }
}

}  // namespace springnet
