// Materials that differ in numbers alone, as files with a row for each spring or element.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene_writer.hpp>

namespace springnet::scene {

class ValueFiles {
 public:
  // No files: each material stands in the scene.
  explicit ValueFiles(const Network& network);
  // Names of files begin with `stem`.
  ValueFiles(const Network& network, const PluginHost& plugins, std::string stem);

  // One for all materials that share a file; itself for others.
  [[nodiscard]] MaterialIndex group_of(MaterialIndex material) const { return groups_[material]; }

  // What differs from the materials that stand in the scene.
  struct Row {
    std::uint32_t number;
    MaterialIndex written, own;  // of one group
  };
  // Writes what differs between them, and returns the file's name. noun: "spring" or "element", the column of numbers.
  [[nodiscard]] std::string add(const std::string& noun, const std::vector<Row>& rows);

  [[nodiscard]] std::vector<SceneTable>& files() noexcept { return files_; }

 private:
  const Network& network_;
  std::string stem_;
  std::vector<MaterialIndex> groups_;  // [material]
  std::vector<SceneTable> files_;
};

}  // namespace springnet::scene
