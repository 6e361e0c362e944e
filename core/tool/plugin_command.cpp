#include <algorithm>
#include <array>
#include <memory>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/printable.hpp>
#include <springnet/scene_formulas.hpp>
#include <springnet/suggestion.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "component_text.hpp"
#include "kind_word.hpp"
#include "law_plot.hpp"
#include "sample_scene.hpp"
#include "text_table.hpp"
#include "what_it_reads.hpp"

namespace springnet::tool {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* plugin_list_examples =
    R"(Plugins are files <name>.springnet.so in the folders of --plugins, of SPRINGNET_PLUGIN_PATH and of the
installation. Files that were refused are listed with the reason.

Exit status:
  0 done   2 usage)";

constexpr const char* plugin_show_examples = R"(Examples:
  springnet plugin show linear                    every component of that name
  springnet plugin show linear --kind viscosity   one kind of it
  springnet plugin show recurrent --json
  springnet plugin show maxwell --sample > maxwell.toml    a scene that runs
  springnet plugin show nonlinear --plot curve.svg --set stiffness=3 --range 0.8:2
  springnet plugin show plastic --plot loop.html --set yield_tension=0.2 --period 10
  springnet plugin show nonlinear --at 0.9,1.1 --set stiffness=3 --rate 0.5    its force at 0.9 m and 1.1 m
  springnet plugin show maxwell.toml --plot laws.html      all laws of a scene, formulas too

Exit status:
  0 done   1 the plot cannot be written   2 usage or scene   3 there is no such component)";

struct Capability {
  std::uint64_t bit;
  const char* text;
};
constexpr std::array<Capability, 22> capabilities{
    {{SPRINGNET_HAS_ENERGY, "energy"},
     {SPRINGNET_HAS_DERIVATIVES, "derivatives"},
     {SPRINGNET_HAS_PARAMETER_DERIVATIVES, "derivatives with respect to parameters"},
     {SPRINGNET_HAS_ALL_DERIVATIVES, "all first derivatives"},
     {SPRINGNET_HAS_RUPTURE, "rupture"},
     {SPRINGNET_ACTS_IN_COMPRESSION, "acts in compression"},
     {SPRINGNET_READS_RATE, "reads the rate"},
     {SPRINGNET_INTEGRATES_STATES, "integrates the internal state of laws"},
     {SPRINGNET_LOCATES_EVENTS, "locates events in time"},
     {SPRINGNET_CHOOSES_STEPS, "chooses its steps"},
     {SPRINGNET_HAS_DENSE_OUTPUT, "dense output"},
     {SPRINGNET_KEEPS_BODIES_APART, "keeps bodies apart"},
     {SPRINGNET_KEEPS_RIGID_BODIES_APART, "keeps rigid bodies apart"},
     {SPRINGNET_WITHOUT_CONTACT, "without contact"},
     {SPRINGNET_WITHOUT_RIGID, "without rigid connections"},
     {SPRINGNET_MONOTONE, "monotone"},
     {SPRINGNET_NOT_ZERO_AT_REST, "not zero at rest"},
     {SPRINGNET_ADDS_POWER, "adds power"},
     {SPRINGNET_READS_TIME, "reads the time"},
     {SPRINGNET_CALLING_THREAD_ONLY, "on the calling thread only"},
     {SPRINGNET_FITS_ELEMENTS, "fits elements"},
     {SPRINGNET_DIVIDES_BY_REFERENCE, "needs a reference value above 0"}}};

std::vector<std::string> capabilities_of(const Component& component) {
  std::vector<std::string> result;
  for (const Capability& capability : capabilities) {
    if ((component.description->capabilities & capability.bit) != 0) result.emplace_back(capability.text);
  }
  return result;
}

std::string file_of(const Component& component) {
  return component.file.empty() ? "(linked into the program)" : shown(component.file);
}

// "above 0", "0 to 1", "one of a, b", "any".
std::string bounds_text(const springnet_parameter& parameter) {
  if (parameter.type == SPRINGNET_CHOICE) {
    std::string text;
    for (std::uint32_t k = 0; k < parameter.choice_count; ++k) {
      text += fmt::format("{}{}", k == 0 ? "" : " | ", shown(parameter.choices[k]));
    }
    return text;
  }
  if (parameter.type == SPRINGNET_BOOLEAN) return "true | false";
  const bool open = (parameter.flags & SPRINGNET_EXCLUDES_SMALLEST) != 0;
  // The largest numbers mean no bound.
  const bool bounded_below = parameter.smallest > -1e300, bounded_above = parameter.largest < 1e300;
  const char* const what = parameter.type == SPRINGNET_INTEGER ? "whole, " : "";
  if (bounded_below && bounded_above) {
    return fmt::format("{}{}{:g} to {:g}", what, open ? "above " : "", parameter.smallest, parameter.largest);
  }
  if (bounded_below) return fmt::format("{}{} {:g}", what, open ? "above" : "at least", parameter.smallest);
  if (bounded_above) return fmt::format("{}at most {:g}", what, parameter.largest);
  return parameter.type == SPRINGNET_INTEGER ? "whole" : "any";
}

Json json_of(const springnet_parameter& parameter) {
  Json choices = Json::array();
  for (std::uint32_t k = 0; k < parameter.choice_count; ++k) choices.push_back(parameter.choices[k]);
  constexpr std::array<const char*, 4> types{"number", "integer", "boolean", "choice"};
  return {{"name", parameter.name},
          {"type", types.at(parameter.type)},
          {"unit", parameter.unit},
          {"summary", parameter.summary},
          {"required", required(parameter)},
          {"default", required(parameter) ? Json(nullptr) : Json(parameter.default_value)},
          {"smallest", parameter.smallest},
          {"excludes_smallest", (parameter.flags & SPRINGNET_EXCLUDES_SMALLEST) != 0},
          {"largest", parameter.largest},
          {"scale", parameter.scale},
          {"learnable", (parameter.flags & SPRINGNET_LEARNABLE) != 0},
          {"choices", choices}};
}

// The table that has as many values, or null.
const springnet_table* as_long_as(const Component& component, std::size_t table) {
  const std::uint32_t other = tables_of(component)[table]->as_long_as;
  return other == table ? nullptr : tables_of(component)[other];
}

Json json_of_tables(const Component& component) {
  Json tables = Json::array();
  for (const springnet_table* table : tables_of(component)) {
    const springnet_table* const other = as_long_as(component, tables.size());
    tables.push_back({{"name", table->name},
                      {"unit", table->unit},
                      {"summary", table->summary},
                      {"required", (table->flags & SPRINGNET_OPTIONAL) == 0},
                      {"increasing", (table->flags & SPRINGNET_INCREASING) != 0},
                      {"least", std::max(table->least, 1u)},
                      {"as_long_as", other == nullptr ? Json(nullptr) : Json(other->name)},
                      {"smallest", table->smallest},
                      {"largest", table->largest}});
  }
  return tables;
}

Json json_of(const Component& component) {
  const springnet_plugin& plugin = *component.plugin;
  Json parameters = Json::array();
  for (const springnet_parameter* parameter : parameters_of(component)) parameters.push_back(json_of(*parameter));
  Json states = Json::array();
  for (const springnet_parameter* state : states_of(component)) states.push_back(json_of(*state));
  Json inputs = Json::array();
  for (const springnet_parameter* input : inputs_of(component)) inputs.push_back(json_of(*input));
  return {
      {"id", component.id()},
      {"kind", name_of(component.kind())},
      {"version", plugin.version},
      {"summary", component.description->summary},
      {"file", component.file.string()},
      {"plugin", plugin.id},
      {"author", plugin.author},
      {"licence", plugin.licence},
      {"abi", fmt::format("{}.{}", plugin.abi_major, plugin.abi_minor)},
      {"reference", component.description->reference},
      {"capabilities", capabilities_of(component)},
      {"reads", is_law(component) ? Json(what_it_reads(component.law())) : Json(nullptr)},
      {"stretch", is_law(component) ? Json::array({component.law().smallest_stretch, component.law().largest_stretch})
                                    : Json(nullptr)},
      {"parameters", parameters},
      {"states", states},
      {"inputs", inputs},
      {"tables", json_of_tables(component)}};
}

void print_json(const Json& document) {
  fmt::print("{}\n", document.dump(2, ' ', false, Json::error_handler_t::replace));
}

std::string folder_of(const Component& component) {
  return component.file.empty() ? file_of(component) : shown(component.file.parent_path());
}

// In search order.
std::vector<std::string> folders_of(const PluginHost& host) {
  std::vector<std::string> folders;
  for (const auto& component : host.components()) {
    std::string folder = folder_of(*component);
    if (std::find(folders.begin(), folders.end(), folder) == folders.end()) folders.push_back(std::move(folder));
  }
  return folders;
}

void print_folder(const PluginHost& host, const std::string& folder) {
  std::vector<std::vector<std::string>> rows{{"KIND", "ID", "VERSION", "SUMMARY", "FILE"}};
  for (const KindWord& kind : kind_words) {
    for (const auto& component : host.components()) {
      if (component->kind() != kind.kind || folder_of(*component) != folder) continue;
      rows.push_back({std::string(name_of(kind.kind)), std::string(component->id()), shown(component->plugin->version),
                      shown(component->description->summary), shown(component->file.filename())});
    }
  }
  fmt::print("{}\n{}", folder, align_columns(rows));
}

int list(const PluginArguments& plugins, bool json) {
  const auto host = plugins.load();
  if (json) {
    Json components = Json::array(), refused = Json::array();
    for (const auto& component : host->components()) components.push_back(json_of(*component));
    for (const Refusal& refusal : host->refusals()) {
      refused.push_back({{"file", refusal.file.string()}, {"reason", refusal.reason}});
    }
    print_json({{"components", components}, {"refused", refused}, {"notes", plugins.empty_folders()}});
    return done;
  }
  if (host->components().empty()) {
    fmt::print("no plugin was found; give a folder with --plugins or SPRINGNET_PLUGIN_PATH\n");
  }
  for (const std::string& folder : folders_of(*host)) print_folder(*host, folder);
  for (const std::string& note : plugins.empty_folders()) fmt::print("\n{}\n", note);
  if (!host->refusals().empty()) fmt::print("\nrefused:\n");
  for (const Refusal& refusal : host->refusals()) fmt::print("  {}\n    {}\n", shown(refusal.file), refusal.reason);
  return done;
}

void print_parameters(const Component& component) {
  if (component.description->parameter_count == 0) {
    fmt::print("  no parameters\n");
    return;
  }
  std::vector<std::vector<std::string>> rows{{"PARAMETER", "UNIT", "DEFAULT", "VALUES", ""}};
  for (const springnet_parameter* parameter : parameters_of(component)) {
    const bool learnable = (parameter->flags & SPRINGNET_LEARNABLE) != 0;
    rows.push_back({parameter->name, shown(parameter->unit),
                    required(*parameter) ? "required" : value_text(*parameter, parameter->default_value),
                    bounds_text(*parameter),
                    fmt::format("{}{}", shown(parameter->summary), learnable ? " (learnable)" : "")});
  }
  fmt::print("{}", align_columns(rows));
}

// Internal states or inputs.
void print_quantities(const char* what, const char* value, const std::vector<const springnet_parameter*>& quantities) {
  if (quantities.empty()) return;
  std::vector<std::vector<std::string>> rows{{what, "UNIT", value, "VALUES", ""}};
  for (const springnet_parameter* each : quantities)
    rows.push_back({each->name, shown(each->unit), value_text(*each, each->default_value), bounds_text(*each),
                    shown(each->summary)});
  fmt::print("\n{}", align_columns(rows));
}

void print_tables(const Component& component) {
  const std::span<const springnet_table* const> tables = tables_of(component);
  if (tables.empty()) return;
  std::vector<std::vector<std::string>> rows{{"TABLE", "UNIT", "LENGTH", "VALUES", ""}};
  for (std::size_t k = 0; k < tables.size(); ++k) {
    const springnet_table& table = *tables[k];
    const springnet_table* const other = as_long_as(component, k);
    springnet_parameter bounds{};
    bounds.type = SPRINGNET_NUMBER;
    bounds.smallest = table.smallest;
    bounds.largest = table.largest;
    const bool increasing = (table.flags & SPRINGNET_INCREASING) != 0;
    const bool optional = (table.flags & SPRINGNET_OPTIONAL) != 0;
    std::string length =
        other == nullptr ? fmt::format("at least {}", std::max(table.least, 1u)) : fmt::format("as {}", other->name);
    if (optional) length += ", or none";
    rows.push_back({table.name, shown(table.unit), length, bounds_text(bounds) + (increasing ? ", increasing" : ""),
                    shown(table.summary)});
  }
  fmt::print("\n{}", align_columns(rows));
}

// What the component reads and can do.
std::vector<std::vector<std::string>> abilities_of(const Component& component) {
  std::vector<std::vector<std::string>> rows;
  const std::string reference = shown(component.description->reference);
  if (!reference.empty()) rows.push_back({"reference", reference});
  if (is_law(component)) {
    const springnet_law& law = component.law();
    rows.push_back({"reads", what_it_reads(law)});
    const bool is_bounded = law.smallest_stretch != 0.0 || law.largest_stretch < 1e300;
    if (is_bounded) rows.push_back({"stretch", fmt::format("{:g} to {:g}", law.smallest_stretch, law.largest_stretch)});
  }
  const std::vector<std::string> can = capabilities_of(component);
  if (!can.empty()) rows.push_back({"can", fmt::format("{}", fmt::join(can, ", "))});
  return rows;
}

// name: of the component, or where it stands.
void print_head(const Component& component, std::string_view name) {
  fmt::print("{} ({})\n  {}\n\n", name, name_of(component.kind()), shown(component.description->summary));
}

void print_numbers(const Component& component) {
  print_parameters(component);
  print_quantities("INTERNAL STATE", "AT START", states_of(component));
  print_quantities("INPUT", "WITHOUT A SIGNAL", inputs_of(component));
  print_tables(component);
}

void print_component(const PluginHost& host, const Component& component) {
  const springnet_plugin& plugin = *component.plugin;
  print_head(component, component.id());
  std::vector<std::vector<std::string>> rows = abilities_of(component);
  rows.push_back(
      {"plugin", fmt::format("{} {}, {}, {}; ABI {}.{}", shown(plugin.id), shown(plugin.version), shown(plugin.author),
                             shown(plugin.licence), plugin.abi_major, plugin.abi_minor)});
  rows.push_back({"file", file_of(component)});
  fmt::print("{}\n", align_columns(rows));
  print_numbers(component);
  fmt::print("\n  in a scene:\n    {}\n", scene_line(component, name_in_scenes(host, component)));
}

// Those of a scene, with what they declare.
int show_formulas(const std::filesystem::path& file, const PluginHost& host, bool as_json) {
  const std::vector<SceneFormula> formulas = find_formulas(file, host);
  if (formulas.empty())
    throw Error(ErrorKind::input,
                fmt::format("{}: no law of the scene is a formula; '--plot FILE' draws its laws", shown(file)));
  Json list = Json::array();
  for (const SceneFormula& each : formulas) {
    const Component& component = *each.law.component;
    if (as_json) {
      list.push_back(json_of(component));
      list.back()["id"] = each.key;
      continue;
    }
    if (&each != &formulas.front()) fmt::print("\n");
    print_head(component, each.key);
    fmt::print("{}\n", align_columns(abilities_of(component)));
    print_numbers(component);
  }
  if (as_json) print_json(list);
  return done;
}

struct ShowArguments {
  PluginArguments plugins;
  std::string id, kind;
  bool json = false, sample = false;
  PlotArguments plot;
};

void print_plotted(const std::vector<std::string>& notes, const std::filesystem::path& file) {
  for (const std::string& note : notes) fmt::print("note: {}\n", note);
  fmt::print("{}\n", shown(file));
}

int show(const ShowArguments& arguments) {
  const auto& [plugins, id, only_kind, json, sample, plot] = arguments;
  if (plot.file.empty() && plot.at.empty() && !plot.sets.empty())
    throw Error(ErrorKind::input, "--set is for --plot and --at; add one of them");
  const auto host = plugins.load();
  if (id.ends_with(".toml") && !plot.at.empty()) {
    const std::vector<ShownLaw> laws = laws_of_scene(id, *host, plot).laws;
    if (json)
      print_json(values_json(laws, plot));
    else
      fmt::print("{}", values_text(laws, plot));
    return done;
  }
  if (id.ends_with(".toml") && !plot.file.empty()) {
    print_plotted(plot_scene(id, *host, plot), plot.file);
    return done;
  }
  if (id.ends_with(".toml") && sample)
    throw Error(ErrorKind::input, "--sample prints a scene that uses a component; this is a scene already");
  if (id.ends_with(".toml")) return show_formulas(id, *host, json);
  std::vector<std::shared_ptr<const Component>> found;
  for (const KindWord& kind : kind_words) {
    if (!only_kind.empty() && only_kind != kind.word) continue;
    for (const auto& component : host->components()) {
      const bool named = component->id() == id || fmt::format("{}@{}", component->id(), component->plugin->id) == id;
      if (component->kind() == kind.kind && named) found.push_back(component);
    }
    if (!only_kind.empty() && found.empty()) static_cast<void>(host->require(kind.kind, id));  // throws
  }
  if (found.empty()) {
    std::vector<std::string> known;
    for (const auto& component : host->components()) known.emplace_back(component->id());
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    const std::string near = suggestion(id, known);
    std::string message = fmt::format("there is no component '{}'{}{}; 'springnet plugin list' lists all components",
                                      printable(id), near.empty() ? "" : "; ", near);
    if (!host->refusals().empty()) message += "\nRefused plugins:";
    for (const Refusal& refusal : host->refusals())
      message += fmt::format("\n  {}: {}", shown(refusal.file), refusal.reason);
    throw Error(ErrorKind::plugin, message);
  }
  if (!plot.at.empty()) {
    const std::vector<ShownLaw> laws = laws_of_components(found, plot);
    if (json)
      print_json(values_json(laws, plot));
    else
      fmt::print("{}", values_text(laws, plot));
    return done;
  }
  if (!plot.file.empty()) {
    plot_components(found, plot);
    print_plotted({}, plot.file);
    return done;
  }
  if (sample) {
    fmt::print("{}", sample_scene(*found.front(), name_in_scenes(*host, *found.front())));
    return done;
  }
  if (json) {
    Json components = Json::array();
    for (const auto& component : found) components.push_back(json_of(*component));
    print_json(components);
    return done;
  }
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (k > 0) fmt::print("\n");
    print_component(*host, *found[k]);
  }
  return done;
}

void add_list(CLI::App& parent, Action& action) {
  struct Arguments {
    PluginArguments plugins;
    bool json = false;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const command =
      parent.add_subcommand("list", "List the available laws, neurons and integrators, and refused files");
  arguments->plugins.add_to(*command);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->footer(plugin_list_examples);
  command->callback(
      [arguments, &action] { action = [arguments] { return list(arguments->plugins, arguments->json); }; });
}

void add_show(CLI::App& parent, Action& action) {
  const auto arguments = std::make_shared<ShowArguments>();
  CLI::App* const command =
      parent.add_subcommand("show", "Describe a component, its parameters and bounds, or draw a law");
  command->add_option("ID", arguments->id, "Name of the component in a scene; or a scene, NAME.toml, for its formulas")
      ->type_name("")
      ->required();
  command->add_option("--kind", arguments->kind, "Only this kind: spring, viscosity, neuron or integrator")
      ->type_name("KIND")
      ->check(CLI::IsMember({"spring", "viscosity", "neuron", "integrator"}));
  arguments->plugins.add_to(*command);
  command->add_flag("--json", arguments->json, "Print JSON");
  CLI::Option* const json = command->get_option("--json");
  CLI::Option* const sample =
      command->add_flag("--sample", arguments->sample, "Print a whole scene that uses the component")->excludes(json);
  arguments->plot.add_to(*command);
  command->get_option("--plot")->excludes(json)->excludes(sample);
  command->get_option("--at")->excludes("--plot")->excludes(sample);
  command->get_option("--rate")->needs("--at");
  for (const char* option : {"--range", "--period"}) command->get_option(option)->needs("--plot");
  command->footer(plugin_show_examples);
  command->callback([arguments, &action] { action = [arguments] { return show(*arguments); }; });
}

}  // namespace

void add_plugin(CLI::App& app, Action& action) {
  CLI::App* const command =
      app.add_subcommand("plugin", "List the available laws, neurons and integrators, describe, test or start one");
  command->require_subcommand(1);
  add_list(*command, action);
  add_show(*command, action);
  add_plugin_new(*command, action);
  add_plugin_check(*command, action);
}

}  // namespace springnet::tool
