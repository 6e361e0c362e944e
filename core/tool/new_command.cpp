#include <memory>
#include <system_error>

#include <fmt/format.h>
#include <springnet/mesh_summary.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "examples.hpp"
#include "mesh_scene.hpp"
#include "new_files.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

constexpr const char* examples_text =
    R"(For a mesh it writes a scene that runs as it is: the body hangs from its uppermost nodes under its weight. Comments in
the scene explain what was guessed (the unit of the mesh, a density, a stiffness) and what could be added: groups to fix,
a floor, bending stiffness, a filling. The mesh is copied to the same folder. Existing files are never replaced.

Examples:
  springnet new --example                       lists the examples
  springnet new --example cube                  copies one of them into the folder cube
  springnet new --example tube -o my_tube
  springnet new my_tube/tube.msh -o hanging     a scene for a mesh: hanging/tube.toml

Exit status:
  0 done   1 a file cannot be written   2 usage, a mesh that cannot be read, or a file that already exists   3 plugin)";

struct NewArguments {
  std::filesystem::path mesh;
  std::string example;
  bool from_example = false;
  std::filesystem::path folder;
};

int list_examples() {
  std::vector<std::vector<std::string>> rows;
  for (const Example& example : installed_examples()) rows.push_back({example.name, printable(example.summary, 100)});
  fmt::print("Examples, for 'springnet new --example NAME':\n{}", align_columns(rows));
  return done;
}

int copy_example(const NewArguments& arguments) {
  const std::vector<Example> all = installed_examples();
  std::vector<std::string> names;
  for (const Example& example : all) {
    names.push_back(example.name);
    if (example.name != arguments.example) continue;
    const auto folder = arguments.folder.empty() ? std::filesystem::path(example.name) : arguments.folder;
    std::vector<Planned> files;
    for (const std::filesystem::path& file : example.files) files.push_back({folder / file.filename(), file, ""});
    write_all(folder, files);
    if (!example.scene.empty()) {
      fmt::print("Next: springnet run {}\n", printable_message((folder / example.scene.filename()).string()));
    }
    return done;
  }
  const std::string near = suggestion(arguments.example, names);
  throw Error(ErrorKind::input, fmt::format("there is no example '{}'; {}'springnet new --example' lists them",
                                            printable(arguments.example), near.empty() ? near : near + " "));
}

int scene_for_mesh(const NewArguments& arguments) {
  if (!has_mesh_ending(arguments.mesh)) {
    throw Error(
        ErrorKind::input,
        fmt::format(
            "{}: is not a mesh file; its name must end in .msh, .vtk, .vtu, .vtp, .obj, .stl or .ply. To copy an "
            "example, use --example NAME",
            printable_message(arguments.mesh.string())));
  }
  const Mesh mesh = read_mesh(arguments.mesh);
  const MeshSummary summary = summarise(mesh);
  if (!(summary.whole.size() > 0.0)) {
    throw Error(ErrorKind::input, fmt::format("{}: all points coincide; a body needs an extent",
                                              printable_message(arguments.mesh.string())));
  }
  const std::filesystem::path stem = arguments.mesh.stem(), name = arguments.mesh.filename();
  const std::filesystem::path folder = arguments.folder.empty() ? stem : arguments.folder;
  std::filesystem::path scene = folder / stem;
  scene += ".toml";
  const std::string text = scene_of(name.string(), mesh, summary).scene;
  // Write only what can be loaded.
  const std::filesystem::path beside =
      arguments.mesh.has_parent_path() ? arguments.mesh.parent_path() : std::filesystem::path(".");
  const PluginHost plugins = PluginHost::with_default_search();
  static_cast<void>(parse_scene(text, scene.string(), plugins, {}, beside, OutsideFiles::allowed));

  std::vector<Planned> files{{scene, "", text}};
  std::error_code unknown;
  if (!std::filesystem::equivalent(folder / name, arguments.mesh, unknown)) {
    files.push_back({folder / name, arguments.mesh, ""});
  }
  write_all(folder, files);
  fmt::print("The mesh is assumed to be in {}{}.\nNext: springnet run {}\n", summary.unit.unit,
             summary.unit.sure ? "" : ", which may be wrong", printable_message(scene.string()));
  return done;
}

int run(const NewArguments& arguments) {
  if (arguments.from_example && !arguments.mesh.empty()) {
    throw Error(ErrorKind::input, "both '--example' and a mesh are given; 'springnet new' takes only one of them");
  }
  if (arguments.from_example) return arguments.example.empty() ? list_examples() : copy_example(arguments);
  if (arguments.mesh.empty()) {
    throw Error(ErrorKind::input, "a mesh file or '--example' is missing; see 'springnet new --help'");
  }
  return scene_for_mesh(arguments);
}

}  // namespace

void add_new(CLI::App& app, Action& action) {
  const auto arguments = std::make_shared<NewArguments>();
  CLI::App* const command = app.add_subcommand("new", "Write a scene to start from, for a mesh or from an example");
  command->add_option("MESH", arguments->mesh, "Mesh file: .msh, .vtk, .vtu, .vtp, .obj, .stl, .ply")->type_name("");
  command->add_option("--example", arguments->example, "Copy this example; without a name, list the examples")
      ->type_name("[NAME]")
      ->expected(0, 1);
  command->add_option("-o,--output", arguments->folder, "Folder for the files [the name of the mesh or example]")
      ->type_name("DIR");
  command->footer(examples_text);
  command->callback([arguments, command, &action] {
    arguments->from_example = command->count("--example") > 0;
    action = [arguments] { return run(*arguments); };
  });
}

}  // namespace springnet::tool
