#include <fmt/format.h>
#include <springnet/version.hpp>

#include "commands.hpp"

namespace springnet::tool {

namespace {

constexpr const char* footer = R"(Examples:
  springnet new --example cube                 copies the paper's cube into the folder cube
  springnet run cube/cube.toml                 simulates it; files go to results/cube
  springnet validate cube/cube.toml            compares it with CVODE
  springnet inspect cube/cube.toml             describes the network
  springnet plugin show linear                 describes a law, its parameters and bounds
  springnet plugin new my_law --kind spring    writes a plugin with a law of its own

Exit status:
  0 done   1 the simulation failed or a tolerance was not met   2 usage or scene   3 plugin

'springnet COMMAND --help' describes a command. The documentation is in share/doc/springnet of the installation and in
core/docs of the sources; scene.md describes every key of a scene.)";

}  // namespace

void add_all(CLI::App& app, Action& action) {
  app.name("springnet");
  app.description(
      "springnet simulates dynamic spring models as recurrent neural networks, and in CVODE as a reference. Neurons,\n"
      "spring laws and integrators are plugins.");
  app.set_version_flag("--version", fmt::format("springnet {}", version()));
  app.require_subcommand(1);
  app.footer(footer);
  add_new(app, action);
  add_run(app, action);
  add_validate(app, action);
  add_learn(app, action);
  add_sensitivity(app, action);
  add_inspect(app, action);
  add_convert(app, action);
  add_plugin(app, action);
}

}  // namespace springnet::tool
