// Files that a scene names, and where they may be.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/scene.hpp>
#include <springnet/scene_formulas.hpp>

#include "scene/csv_columns.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {

struct Files {
  std::filesystem::path folder;  // of the scene; may be empty
  OutsideFiles outside = OutsideFiles::refused;
  LoadingCallback loading{};  // empty: nothing is told
  std::shared_ptr<CsvFiles> csv = std::make_shared<CsvFiles>();
  // Laws that were given as formulas, by their texts and declarations: the same again is the same component, so that
  // its springs are evaluated together.
  std::shared_ptr<std::map<std::string, std::shared_ptr<const Component>>> known_formulas =
      std::make_shared<std::map<std::string, std::shared_ptr<const Component>>>();
  std::vector<SceneFormula>* formulas = nullptr;  // gets every law that is read as a formula; null: not wanted

  // Resolves a path of the scene relative to its folder. Every reader of a file uses this. Throws Error(input) if the
  // path leads out of the folder, by "..", a link or an absolute path, unless that is allowed.
  [[nodiscard]] std::filesystem::path resolve(const Value& name) const;
  // Columns of a CSV file that the scene names. Throws Error(input) at the value.
  [[nodiscard]] CsvColumns csv_columns(const Value& name, const std::vector<std::string>& columns) const;
  // The whole file. Throws likewise.
  [[nodiscard]] const CsvTable& csv_table(const Value& name) const;
  // Tells that work on `count` nodes, springs or cells begins, if that takes time.
  void tell(std::string_view stage, std::size_t count) const {
    if (loading && count >= slow_to_load) loading({stage, std::numeric_limits<double>::quiet_NaN()});
  }
};

}  // namespace springnet::scene
