// Tables of observations as texts, and what is wrong with them.
#pragma once

#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <springnet/observations.hpp>

#include "refusal.hpp"
#include "temporary_folder.hpp"

namespace springnet::testing {

class Tables {
 public:
  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }
  [[nodiscard]] Observations read(const std::string& text, const std::string& name = "a.csv") const {
    // File systems wait for the disk when a file is written over.
    std::filesystem::remove(folder_.path() / name);
    folder_.write(name, text);
    return read_observations(folder_.path() / name);
  }

 private:
  TemporaryFolder folder_;
};

inline Observations read(const std::string& text) { return Tables().read(text); }

inline std::string refusal(const std::string& text) {
  return refusal_of([&] { static_cast<void>(read(text)); });
}
inline std::string refusal_of_file(const std::filesystem::path& file) {
  return refusal_of([&] { static_cast<void>(read_observations(file)); });
}
// Of ten nodes that move from 0 s to 2 s.
inline std::string objection(const Observations& observations) {
  return refusal_of([&] { check_observations(observations, 10, 0.0, 2.0); });
}

}  // namespace springnet::testing
