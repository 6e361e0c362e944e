// A plugin of one component that the program made.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <springnet/host_laws.hpp>

namespace springnet {

// Does not move: `plugin` points into it.
struct HostPlugin {
  HostPlugin(const HostComponent& component, std::string_view id, std::string_view version);
  HostPlugin(const HostPlugin&) = delete;
  HostPlugin& operator=(const HostPlugin&) = delete;

  HostComponent component;
  std::string id, version;
  const springnet_component* list[1];
  springnet_plugin plugin;
};

}  // namespace springnet
