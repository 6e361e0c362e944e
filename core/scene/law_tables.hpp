// The tables of a law: lists of numbers in the scene, or columns of CSV files.
#pragma once

#include <springnet/parameters.hpp>
#include <springnet/plugin_host.hpp>

#include "scene/files.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {

// The tables that the component declares and that `law` gives, each value checked. complete_tables() does the rest.
[[nodiscard]] TableValues read_law_tables(const Table& law, const springnet_component& component, const Files& files);

}  // namespace springnet::scene
