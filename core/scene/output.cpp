#include <algorithm>

#include <fmt/format.h>

#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "scene/element_sets.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"

namespace springnet::scene {
namespace {

void read_quantities(const Value& value, OutputOptions& output) {
  output.position = output.velocity = output.force = false;
  for (const Value& quantity : value.elements()) {
    bool* const wanted[] = {&output.position, &output.velocity, &output.force};
    *wanted[quantity.choice({"position", "velocity", "force"})] = true;
  }
  if (!output.position && !output.velocity && !output.force) {
    value.fail(
        "names no quantity; write 'position', 'velocity', 'force', or leave out the file: output.trajectory = false");
  }
}

void read_recorded_elements(const Value& value, const std::vector<ElementSet>& sets, OutputOptions& output) {
  if (value.is_boolean()) {
    output.elements = value.boolean();
    return;
  }
  if (!value.is_list()) value.wrong_type("true, false or a list of names of [[element]]");
  output.element_numbers = select_elements(value, sets);
  if (output.element_numbers.empty()) value.fail("names no element; leave out the file: output.elements = false");
}

}  // namespace

void read_output(const Table& root, Scene& scene) {
  const Network& network = scene.network;
  OutputOptions& output = scene.output;
  const auto value = root.find("output");
  if (!value) return;
  const Table table = value->table("output");
  if (const auto interval = table.find("interval")) output.interval = interval->number_from_0("s");
  const auto read_flag = [&](const char* key, bool& flag) {
    if (const auto wanted = table.find(key)) flag = wanted->boolean();
  };
  read_flag("trajectory", output.trajectory);
  read_flag("reactions", output.reactions);
  read_flag("surfaces", output.surfaces);
  read_flag("rigid", output.rigid);
  read_flag("vtk", output.vtk);
  read_flag("view", output.view);
  if (const auto elements = table.find("elements")) read_recorded_elements(*elements, scene.elements, output);
  if (const auto size = table.find("view_size")) output.view_size = size->number_above_0("bytes");
  if (const auto nodes = table.find("nodes")) output.nodes = select_nodes(*nodes, network);
  if (const auto springs = table.find("springs")) output.springs = select_springs(*springs, network);
  if (const auto quantities = table.find("quantities")) read_quantities(*quantities, output);
  if (const auto format = table.find("format")) {
    output.format = static_cast<OutputOptions::Format>(format->choice({"csv", "binary"}));
  }
  if (const auto precision = table.find("precision")) {
    output.precision = static_cast<OutputOptions::Precision>(precision->choice({"double", "single"}));
  }
  if (const auto interval = table.find("vtk_interval")) output.vtk_interval = interval->number_from_0("s");
}

}  // namespace springnet::scene
