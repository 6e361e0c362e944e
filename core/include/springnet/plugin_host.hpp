// The components (laws, neurons, integrators) that a program can use: loaded from shared libraries, linked into the
// program, or made by it (host_laws.hpp). A component is named by kind and id; its metadata is that of the C ABI
// (sdk/plugin.h).
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/export.hpp>
#include <springnet/parameters.hpp>

namespace springnet {

class HostComponent;

// SPRINGNET_SPRING_FUNCTION and so on, as a type.
enum class ComponentKind : unsigned {
  spring_function = SPRINGNET_SPRING_FUNCTION,
  viscosity_function = SPRINGNET_VISCOSITY_FUNCTION,
  neuron = SPRINGNET_NEURON,
  integrator = SPRINGNET_INTEGRATOR
};

// "spring function", "viscosity function", "neuron", "integrator".
[[nodiscard]] SPRINGNET_API std::string_view name_of(ComponentKind kind) noexcept;

struct Component {
  const springnet_component* description;
  const springnet_plugin* plugin;
  std::filesystem::path file;         // empty if it comes from the program itself
  std::shared_ptr<const void> owner;  // of what the pointers refer to; null if that stays as long as the process

  [[nodiscard]] ComponentKind kind() const noexcept { return static_cast<ComponentKind>(description->kind); }
  [[nodiscard]] std::string_view id() const noexcept { return description->id; }
  [[nodiscard]] const springnet_law& law() const noexcept {
    return *static_cast<const springnet_law*>(description->implementation);
  }
  [[nodiscard]] const springnet_neuron_model& neuron() const noexcept {
    return *static_cast<const springnet_neuron_model*>(description->implementation);
  }
  [[nodiscard]] const springnet_integrator& integrator() const noexcept {
    return *static_cast<const springnet_integrator*>(description->implementation);
  }
};

// A file or registration that was refused.
struct Refusal {
  std::filesystem::path file;
  std::string reason;  // what is wrong and what to do
};

class SPRINGNET_API PluginHost {
 public:
  // Nothing is loaded yet.
  PluginHost();
  ~PluginHost();
  PluginHost(PluginHost&&) noexcept;
  PluginHost& operator=(PluginHost&&) noexcept;

  // A host that has searched, in this order: `folders`, those of SPRINGNET_PLUGIN_PATH (separated by ':'), the folders
  // of the installed library and of the build tree it comes from. Never the working directory. Files that cannot be
  // loaded are kept as refusals; they never cause an exception.
  [[nodiscard]] static PluginHost with_default_search(const std::vector<std::filesystem::path>& folders = {});

  // Loads all files "*.springnet.so" (.dylib, .dll) of a folder, in the order of their names. A plugin with a component
  // whose kind and id another one of the same id provides is refused. A folder that does not exist is recorded as a
  // refusal.
  void search(const std::filesystem::path& folder);
  // Loads one file. Returns false if it was refused; the reason is refusals().back().
  bool load(const std::filesystem::path& file);
  // Adds a plugin linked into the program; `plugin` must outlive the host. Returns false like load().
  bool add(const springnet_plugin& plugin);
  // Adds a law, neuron or integrator that the program made (host_laws.hpp), as part of a plugin of this id; several of
  // one id are added one by one. What it refers to lives as long as anything uses it. Not while another thread uses the
  // host; simulations that were made before go on with what they have. Throws Error(plugin) if it is refused, as where
  // `plugin` has a component of that kind and id already.
  std::shared_ptr<const Component> add(const HostComponent& component, std::string_view plugin = "host",
                                       std::string_view version = "");

  [[nodiscard]] const std::vector<std::shared_ptr<const Component>>& components() const noexcept;
  [[nodiscard]] const std::vector<Refusal>& refusals() const noexcept;

  // Null if there is none. An id that several plugins provide is followed by '@' and the id of one:
  // "linear@org.example"; throws Error(plugin) if it is not.
  [[nodiscard]] std::shared_ptr<const Component> find(ComponentKind kind, std::string_view id) const;
  // Throws Error(plugin) that names the nearest known ids and every refused file with its reason.
  [[nodiscard]] std::shared_ptr<const Component> require(ComponentKind kind, std::string_view id) const;

 private:
  struct SPRINGNET_LOCAL Impl;
  std::unique_ptr<Impl> impl_;
};

// Index of the parameter, or -1.
[[nodiscard]] SPRINGNET_API std::ptrdiff_t parameter_index(const springnet_component& component,
                                                           std::string_view name) noexcept;
// Index of a choice of a SPRINGNET_CHOICE parameter, or -1.
[[nodiscard]] SPRINGNET_API std::ptrdiff_t choice_index(const springnet_parameter& parameter,
                                                        std::string_view choice) noexcept;
// Empty if `value` is valid for the parameter, else what is wrong: "must be above 0 kg, is -1".
[[nodiscard]] SPRINGNET_API std::string check_value(const springnet_parameter& parameter, double value);
// Values in the order of the component's parameters, defaults filled in. Throws Error(input) for an unknown name (with
// the nearest known ones), a missing required value or one out of range; `where` begins the message.
[[nodiscard]] SPRINGNET_API std::vector<double> complete_parameters(const springnet_component& component,
                                                                    const ParameterValues& given,
                                                                    std::string_view where);

// Numbers in a table of a law.
inline constexpr std::size_t most_table_values = 1'000'000;

// What is wrong with the values of a table: `row` counts from 0; none if it is their number.
struct TableMistake {
  std::optional<std::size_t> row;
  std::string what;  // "must be above the one before, 0.5 m, is 0.4; …"
};
[[nodiscard]] SPRINGNET_API std::optional<TableMistake> check_table(const springnet_table& table,
                                                                    std::span<const double> values);
// The tables that the component declares; none unless it is a law.
[[nodiscard]] SPRINGNET_API std::span<const springnet_table* const> tables_of(const springnet_component& component);
// Tables in the order of the component's, empty for optional ones that are not given; they point into `given`. Throws
// Error(input) for an unknown name, a missing table, one of a wrong length, or a value that check_table() refuses;
// messages count rows from 1.
[[nodiscard]] SPRINGNET_API std::vector<std::span<const double>> complete_tables(const springnet_component& component,
                                                                                 const TableValues& given,
                                                                                 std::string_view where);

}  // namespace springnet
