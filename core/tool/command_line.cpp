#include <fmt/format.h>
#include <springnet/version.hpp>

#include "commands.hpp"

namespace springnet::tool {

namespace {

constexpr const char* footer = R"(Examples:
  springnet new --example cube                 copies the paper's cube into the folder cube
  springnet run cube/cube.toml                 simulate; files go to results/cube
  springnet validate cube/cube.toml            compare with CVODE
  springnet inspect cube/cube.toml             what the network is made of
  springnet plugin show linear                 what a law does, its parameters and bounds

Exit status:
  0 done   1 the simulation failed or a tolerance was not met   2 usage or scene   3 plugin

'springnet COMMAND --help' says more about a command. The pages of the documentation are in share/doc/springnet of the
installation, core/docs of the sources; scene.md describes every key of a scene.)";

}  // namespace

void add_all(CLI::App& app, Action& action) {
  app.name("springnet");
  app.description(
      "springnet simulates dynamic spring models: as recurrent neural networks whose neurons, spring laws and\n"
      "integrators are plugins, and in CVODE as a reference.");
  app.set_version_flag("--version", fmt::format("springnet {}", version()));
  app.require_subcommand(1);
  app.footer(footer);
  add_new(app, action);
  add_run(app, action);
  add_validate(app, action);
  add_inspect(app, action);
  add_convert(app, action);
  add_plugin(app, action);
}

}  // namespace springnet::tool
