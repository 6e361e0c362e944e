#include "plugin_host/law_use.hpp"

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet {

std::shared_ptr<const Component> component_of(const LawUse& use, ComponentKind kind, const PluginHost& plugins) {
  if (use.component == nullptr) return plugins.require(kind, use.id);
  if (use.component->kind() != kind)
    throw Error(ErrorKind::plugin, fmt::format("the {} '{}' of a material is a {}; make it one of the right kind",
                                               name_of(kind), use.id, name_of(use.component->kind())));
  return use.component;
}

}  // namespace springnet
