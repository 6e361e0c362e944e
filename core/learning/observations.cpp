#include <springnet/observations.hpp>

#include <algorithm>
#include <bit>
#include <utility>

#include <fmt/format.h>

#include "learning/observed_values.hpp"

namespace springnet {
namespace {

template <class Row>
void append_rows(std::vector<Row>& to, std::vector<Row>&& from, std::uint32_t first_file) {
  for (Row& row : from)
    if (row.place.file != Observations::Place::no_file) row.place.file += first_file;
  if (to.empty()) {
    to = std::move(from);
  } else {
    to.insert(to.end(), from.begin(), from.end());
  }
}

}  // namespace

std::vector<double> Observations::times() const {
  std::vector<double> result;
  learning::for_each_list(*this, [&](const auto& rows, const char*) {
    for (const auto& row : rows)
      if (learning::observed_values(row) != 0 && (result.empty() || result.back() != row.time))
        result.push_back(row.time);
  });
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

std::size_t Observations::value_count() const noexcept {
  std::size_t count = 0;
  learning::for_each_list(*this, [&](const auto& rows, const char*) {
    for (const auto& row : rows) count += static_cast<std::size_t>(std::popcount(learning::observed_values(row)));
  });
  return count;
}

void Observations::append(Observations other) {
  const auto first_file = static_cast<std::uint32_t>(files.size());
  files.insert(files.end(), other.files.begin(), other.files.end());
  outlier_distance = std::min(outlier_distance, other.outlier_distance);
  append_rows(positions, std::move(other.positions), first_file);
  append_rows(velocities, std::move(other.velocities), first_file);
  append_rows(reactions, std::move(other.reactions), first_file);
  append_rows(distances, std::move(other.distances), first_file);
  append_rows(surface_points, std::move(other.surface_points), first_file);
}

std::string Observations::text_of(const Place& place) const {
  if (place.file >= files.size()) return {};
  const File& file = files[place.file];
  return file.is_binary ? fmt::format("{}: record {}", file.name, place.line)
                        : fmt::format("{}:{}", file.name, place.line);
}

}  // namespace springnet
