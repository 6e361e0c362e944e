// What was learned, as a page: the values on the body, the motions, the course of the search.
#pragma once

#include <memory>

#include <springnet/learn.hpp>
#include <springnet/output_folder.hpp>
#include <springnet/scene.hpp>

namespace springnet::tool {

// scene: with the values that were learned; start: its network before. Simulates both. Throws OutputError.
void write_learning_page(const OutputFile& file, const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                         const Network& start, const Observations& observations, const LearnedNet& learned);

}  // namespace springnet::tool
