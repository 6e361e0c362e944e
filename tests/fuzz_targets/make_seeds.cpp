// Writes files of all kinds that springnet reads: "PROGRAM FOLDER" makes FOLDER/KIND/NAME, where KIND is the ending of
// the target that reads it.
#include <cstdio>
#include <cstring>

#include <fmt/format.h>

#include "fuzzy/random_base.hpp"
#include "mesh/samples.hpp"
#include "scene/everything.hpp"
#include "state_net.hpp"

using namespace springnet::testing;

namespace {

std::filesystem::path root;

void write(const std::string& kind, const std::string& name, const std::string& bytes) {
  std::filesystem::create_directories(root / kind);
  std::ofstream(root / kind / name, std::ios::binary) << bytes;
}

// As a run writes it, with numbers of 8 or of 4 bytes.
std::string table(const std::string& numbers, std::size_t rows, bool single, std::size_t records) {
  const std::size_t record_bytes = 8 + rows * 2 * (single ? 4 : 8);
  const std::string description = fmt::format(
      R"({{"row":"node","rows":{},"columns":["x","y"],"units":["m","m"],"type":"{}","record_bytes":{},"numbers":{}}})",
      rows, single ? "<f4" : "<f8", record_bytes, numbers);
  std::string bytes = fmt::format("springnet records 1 {:08}\n{}\n", 30 + description.size(), description);
  for (std::size_t k = 0; k < records * record_bytes; ++k) bytes += static_cast<char>(k * 37);
  return bytes;
}

// Bodies and elements with several scalars, which name no file: the search has none, and would refuse the scene before
// it reads them.
constexpr const char* elements = R"([simulation]
duration = 1.0
time_step = 0.01

[[body]]
name = "fibres"
mesh = { lattice = [2, 2, 3], spacing = 1.0 }
neuron = { type = "point_mass" }
density = 1000.0
material = { youngs_modulus = 1e4, poisson_ratio = 0.45, damping_time = 0.01, direction = [0, 0, 1], law = { type = "fibre_solid", fibre_modulus = 1e5 } }

[[body]]
name = "skin"
mesh = { lattice = [3, 3, 1], spacing = 1.0, origin = [10, 0, 0] }
neuron = { type = "point_mass" }
density = 1000.0
thickness = 0.001
material = { youngs_modulus = 1e4, poisson_ratio = -0.3, damping_time = 0.01, bending = true, law = { type = "membrane", model = "st_venant_kirchhoff" } }

[[body]]
name = "block"
mesh = { lattice = [2, 2, 2], spacing = 1.0, origin = [20, 0, 0] }
neuron = { type = "point_mass", mass = 1.0 }
material = { youngs_modulus = 1e4, poisson_ratio = 0.3, law = "solid" }

[[element]]
name = "more"
invariant = "tetrahedron"
select = { body = "fibres" }
direction = [1, 0, 0]
spring = { type = "fibre_solid", youngs_modulus = 1.0, poisson_ratio = 0.3, fibre_modulus = 1.0 }
viscosity = { type = "viscous_solid", shear_viscosity = 1.0 }
reference_scale = 1.1

[[element]]
invariant = "triangle"
body = "skin"
nodes = [[0, 1, 3]]
spring = { type = "membrane", youngs_modulus = 1.0, poisson_ratio = 0.3, thickness = 0.1 }

[[element]]
invariant = "hinge"
select = { body = "skin" }
spring = { type = "shell", youngs_modulus = 1.0, poisson_ratio = 0.3, thickness = 0.1 }
)";

// Formulas as laws of materials; what else they may have is in a file of its own.
constexpr const char* formulas = R"toml(
[[body]]
name = "net"
mesh = { lattice = [2, 2, 3], spacing = 1.0, origin = [0, 10, 0] }
neuron = { type = "point_mass" }
density = 1000.0
material = { youngs_modulus = 1e4, law = { formula = "stiffness*e*(1 + b*e^2)", b = { value = 2.0, smallest = 0 } } }

[[body]]
name = "skin"
mesh = { lattice = [3, 3, 1], spacing = 1.0, origin = [10, 10, 0] }
neuron = { type = "point_mass" }
density = 1000.0
thickness = 0.001
material = { youngs_modulus = 1e4, law = { energy = "youngs_modulus*thickness*(a - rest(a))^2", scalars = { a = "length(0, 1)" }, declares = ["adds power"] } }
)toml";

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  root = argv[1];
  std::filesystem::remove_all(root);
  for (const Sample& sample : all_samples()) {
    std::string kind = std::filesystem::path(sample.name).extension().string().substr(1);
    write(kind == "vtp" ? "vtu" : kind, sample.name, sample.bytes);
  }
  write("bin", "all", table("null", 3, false, 2));
  write("bin", "some", table("[1,5]", 2, true, 3));
  write("bin", "cut", table("null", 2, true, 2).substr(0, 200));
  springnet::Simulation simulation = state_simulation();
  for (const int steps : {0, 1, 4, 12}) {
    while (simulation.steps() < static_cast<std::uint64_t>(steps)) simulation.step();
    const std::string saved = simulation.save();
    write("state", fmt::format("file_{}", steps), saved);
    // The state alone, behind the head and the identity.
    std::uint64_t told = 0;
    std::memcpy(&told, saved.data() + 18, sizeof told);
    write("state", fmt::format("state_{}", steps), saved.substr(18 + 24 + told));
  }
  for (unsigned seed = 0; seed < 20; ++seed)
    write("fcl", fmt::format("random_{}", seed), springnet::fuzzy::to_fcl(springnet::testing::RandomBase(seed).make()));
  write("fcl", "soft_tissue", std::string(springnet::fuzzy::soft_tissue_fcl()));
  write("toml", "everything", everything);
  write("toml", "everything_of_meshes", everything_of_meshes);
  write("toml", "elements", elements);
  write("toml", "formulas", read_text(FORMULAS) + formulas);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(EXAMPLES)) {
    if (entry.path().extension() == ".toml") write("toml", entry.path().stem().string(), read_text(entry.path()));
  }
  return 0;
}
