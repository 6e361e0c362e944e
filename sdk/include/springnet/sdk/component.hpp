// Turns component classes into the one symbol that a plugin exports. Included by law.hpp, neuron.hpp and
// integrator.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <springnet/sdk/metadata.hpp>

namespace springnet::sdk {

// `Component` derives from SpringFunction, ViscosityFunction, Neuron or Integrator, which give `kind` and `Glue`. Glue
// has static constants `capabilities` and `implementation`, and checks the class.
template <class Component>
struct ComponentEntry {
  struct ParameterList {
    static constexpr std::span<const Parameter> get() { return parameters_of<Component>(); }
  };
  static constexpr const char* reference() {
    if constexpr (requires { Component::reference; }) return Component::reference;
    return "";
  }
  using Glue = typename Component::template Glue<Component>;
  // With an implementation, which must outlive all uses.
  static constexpr springnet_component with(const void* implementation) {
    return {sizeof(springnet_component),
            Component::kind,
            Component::id,
            Component::summary,
            reference(),
            Glue::capabilities,
            Glue::needs,
            Glue::needs_minor,
            static_cast<std::uint32_t>(ParameterTable<ParameterList>::count),
            ParameterTable<ParameterList>::pointer,
            implementation};
  }
  static constexpr springnet_component value = with(&Glue::implementation);
};

template <class... Components>
struct PluginEntry {
  static_assert(sizeof...(Components) > 0, "SPRINGNET_PLUGIN needs at least one component");
  static constexpr std::array<const springnet_component*, sizeof...(Components)> components{
      &ComponentEntry<Components>::value...};
  static constexpr springnet_plugin make(const char* id, const char* version, const char* author, const char* licence) {
    return {SPRINGNET_MAGIC,
            sizeof(springnet_plugin),
            SPRINGNET_ABI_MAJOR,
            SPRINGNET_ABI_MINOR,
            0,  // components say what they need
            static_cast<std::uint32_t>(components.size()),
            0,
            id,
            version,
            author,
            licence,
            components.data()};
  }
};

}  // namespace springnet::sdk

#define SPRINGNET_JOIN_(a, b) a##b
#define SPRINGNET_JOIN(a, b) SPRINGNET_JOIN_(a, b)

// With SPRINGNET_STATIC_PLUGIN=name the entry is springnet_plugin_entry_name, so that several plugins can be linked
// into one program and given to PluginHost::add.
#ifdef SPRINGNET_STATIC_PLUGIN
#define SPRINGNET_ENTRY SPRINGNET_JOIN(springnet_plugin_entry_, SPRINGNET_STATIC_PLUGIN)
#define SPRINGNET_NOTE struct springnet_note
#else
#define SPRINGNET_ENTRY springnet_plugin_entry
#define SPRINGNET_NOTE SPRINGNET_PLUGIN_NOTE(0u)
#endif

// SPRINGNET_PLUGIN("org.example.my_laws", "1.0.0", "author", "SPDX licence", Component, …): the entry of the plugin,
// once in a plugin, outside of any namespace. Component classes belong in an unnamed namespace: plugins that are linked
// into one program may then use the same class names.
#define SPRINGNET_PLUGIN(id, version, author, licence, ...)           \
  SPRINGNET_NOTE;                                                     \
  extern "C" SPRINGNET_EXPORT const springnet_plugin SPRINGNET_ENTRY; \
  extern "C" constinit const springnet_plugin SPRINGNET_ENTRY =       \
      ::springnet::sdk::PluginEntry<__VA_ARGS__>::make(id, version, author, licence)
