#include <memory>

#include <fmt/format.h>
#include <springnet/inspection.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

constexpr const char* examples = R"(Examples:
  springnet inspect examples/cube/cube.toml
  springnet inspect cube.toml --set 'body.0.spring.stiffness=20' --json

Exit status:
  0 done   2 usage or scene   3 plugin)";

struct InspectArguments {
  SceneArguments scene;
  bool json = false;
};

std::string text_of(const std::optional<Range>& range, const char* unit) {
  if (!range) return "unknown";
  if (range->smallest == range->largest) return fmt::format("{:.6g} {}", range->smallest, unit);
  return fmt::format("{:.6g} to {:.6g} {}", range->smallest, range->largest, unit);
}

std::string text_of(const std::map<std::string, std::size_t>& counts) {
  std::string text;
  for (const auto& [id, count] : counts) text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", id, count);
  return text.empty() ? "none" : text;
}

void print(const Scene& scene, const Inspection& found, const std::string& name) {
  fmt::print("{}{}{}\n", name, scene.title.empty() ? "" : ": ", scene.title);
  const Vector3 extent = found.upper - found.lower;
  std::vector<std::vector<std::string>> rows{
      {"nodes", fmt::format("{}, {} of them fixed; in {} bod{}", found.nodes, found.fixed_nodes, found.bodies,
                            found.bodies == 1 ? "y" : "ies")},
      {"neurons", text_of(found.neurons)},
      {"springs",
       fmt::format("{}, {} of them not at rest length at the start", found.springs, found.springs_under_load)},
      {"spring functions", text_of(found.spring_functions)},
      {"viscosity functions", text_of(found.viscosity_functions)},
      {"connected parts", fmt::format("{}, nodes without springs: {}", found.parts, found.nodes_without_springs)},
      {"mass of a node", fmt::format("{}; {:.6g} kg in all", text_of(found.mass, "kg"), found.total_mass)},
      {"length", text_of(found.length, "m")},
      {"rest length", text_of(found.rest_length, "m")},
      {"stiffness", text_of(found.stiffness, "N/m at the start")},
      {"damping", text_of(found.damping, "N s/m at rest")},
      {"extent", fmt::format("{:.6g} x {:.6g} x {:.6g} m from ({:.6g}, {:.6g}, {:.6g})", extent.x(), extent.y(),
                             extent.z(), found.lower.x(), found.lower.y(), found.lower.z())},
      {"changes", fmt::format("loads {}, planes {}, cuts {}", found.loads, found.planes, found.cuts)},
      {"time step", fmt::format("{:g} s, {:.0f} of them in {:g} s", scene.options.time_step,
                                std::ceil(scene.duration / scene.options.time_step - 1e-9), scene.duration)},
      {"synchronous limit",
       found.synchronous_time_constant
           ? fmt::format(
                 "about {:.2g} s: the time step above which the synchronous update rule does not settle, linearised "
                 "at the start",
                 *found.synchronous_time_constant)
           : "unknown or none"},
      {"memory", fmt::format("about {}", readable_bytes(found.memory_bytes))},
      {"output of a run", fmt::format("about {}", readable_bytes(estimate_output(scene).bytes))},
  };
  fmt::print("{}", align_columns(rows));
}

int run(const InspectArguments& arguments) {
  const auto host = arguments.scene.plugins.load();
  const Scene scene = arguments.scene.load(*host);
  const Inspection found = inspect(scene.network, *host);
  if (arguments.json) {
    fmt::print("{}", to_json(found));
  } else {
    print(scene, found, arguments.scene.file.string());
  }
  return done;
}

}  // namespace

void add_inspect(CLI::App& app, Action& action) {
  const auto arguments = std::make_shared<InspectArguments>();
  CLI::App* const command = app.add_subcommand("inspect", "Say what a scene's network is made of, without simulating");
  arguments->scene.add_to(*command, false);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->footer(examples);
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace springnet::tool
