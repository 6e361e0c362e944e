// What was learned, as a page: the values on the body, the motions, the course of the search.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <springnet/learn.hpp>
#include <springnet/output_folder.hpp>
#include <springnet/scene.hpp>

namespace springnet::tool {

// "spring.stiffness@bar of spring 3", "spring.stiffness@bar:together", "gravity.z"
[[nodiscard]] std::string value_title(const LearnedParameter& parameter);

// An experiment: its scene with the values that were learned, and what it was before.
struct LearnedMotion {
  Scene scene;
  const Experiment& before;
};

// Of the first one the page tells the values and the course; a menu chooses the motion. Simulates all, before and
// after. Throws OutputError.
void write_learning_page(const OutputFile& file, const std::vector<LearnedMotion>& motions,
                         const std::shared_ptr<const PluginHost>& plugins, const LearnedNet& learned);

}  // namespace springnet::tool
