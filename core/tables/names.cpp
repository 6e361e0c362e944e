#include "tables/names.hpp"

#include "tables/csv_file.hpp"

namespace springnet::tables {

namespace {

std::string label_of(const std::string& name, std::size_t surface) {
  return name.empty() ? std::to_string(surface) : name;
}

}  // namespace

std::string label_of(const Simulation& simulation, std::size_t surface) {
  return label_of(simulation.surface_name(surface), surface);
}

std::string labels_of(const Simulation& simulation, const std::vector<std::size_t>& surfaces) {
  std::string text;
  for (const std::size_t surface : surfaces) {
    if (!text.empty()) text += ';';
    text += label_of(simulation, surface);
  }
  return text;
}

std::vector<double> label_lengths(const Network& network) {
  std::vector<double> lengths;
  const auto add = [&](const auto& surface) {
    lengths.push_back(static_cast<double>(csv_cell(label_of(surface.name, lengths.size())).size()));
  };
  for (const Plane& plane : network.planes()) add(plane);
  for (const Instrument& instrument : network.instruments()) add(instrument);
  return lengths;
}

std::string pair_of(const std::array<std::uint32_t, 4>& nodes, std::size_t first, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) text += i == first ? "; " : " ";
    text += std::to_string(nodes[i]);
  }
  return text;
}

}  // namespace springnet::tables
