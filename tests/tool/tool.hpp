// The tool as a user runs it: a shell command in a folder of its own.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "temporary_folder.hpp"

namespace springnet::testing {

struct Answer {
  int status;
  std::string out, err;

  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(out); }
};

// Runs a shell command in the folder; SPRINGNET there stands for the tool.
inline Answer shell(const TemporaryFolder& folder, const std::string& command) {
  const std::filesystem::path out = folder.path() / ".stdout", err = folder.path() / ".stderr";
  const std::string line = "cd '" + folder.path().string() + "' && SPRINGNET='" SPRINGNET_TOOL "' && { " + command +
                           "\n} > .stdout 2> .stderr";
  const int status = std::system(line.c_str());
  if (status == -1 || !WIFEXITED(status)) throw std::runtime_error("not ended in order: " + command);
  return {WEXITSTATUS(status), read_text(out), read_text(err)};
}

inline Answer springnet(const TemporaryFolder& folder, const std::string& arguments) {
  return shell(folder, "\"$SPRINGNET\" " + arguments);
}

inline nlohmann::json read_json(const std::filesystem::path& file) { return nlohmann::json::parse(read_text(file)); }

// A fixed node and one that hangs from it: node 0 at the origin, node 1 at x = 1.
inline constexpr const char* pair_scene = R"(
title = "A pair"
[simulation]
duration = 1.0
time_step = 0.1
integrator = { name = "recurrent", max_sweeps = 500 }
[[body]]
name = "pair"
nodes = [[0, 0, 0], [1, 0, 0]]
springs = [[0, 1]]
neuron = { type = "point_mass", mass = 2.0 }
spring = { type = "linear", stiffness = 4.0 }
viscosity = { type = "linear", damping = 0.5 }
[[fix]]
select = { body = "pair", nodes = [0] }
[gravity]
acceleration = [1, 0.5, 0]
)";

}  // namespace springnet::testing
