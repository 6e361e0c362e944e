// Units of laws' parameters, for readers.
#pragma once

#include <optional>
#include <string>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet::view {

// "linear (stiffness 6 N/m)". A page is written without the run's plugins at hand: units are those of the plugins that
// are found by default, and left out where these do not have the law.
class LawTexts {
 public:
  [[nodiscard]] std::string of(ComponentKind kind, const LawUse& use);
  [[nodiscard]] std::string of(const Material& material);

 private:
  [[nodiscard]] std::string unit_of(ComponentKind kind, const std::string& law, const std::string& parameter);
  std::optional<PluginHost> plugins_;  // searched for when the first parameter is met
};

}  // namespace springnet::view
