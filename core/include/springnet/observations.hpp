// What was observed of a net in one experiment: tables of positions, velocities, distances and reaction forces of
// nodes, and of points on its surface. core/docs/observations.md describes the files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/network_lists.hpp>

namespace springnet {

// Plain rows in the order of the files. The weight of a value is that of its squared residual in a sum of squares: 1,
// or what the table says; 1/s^2 for a standard deviation s. A missing value is 0 and has weight 0.
struct SPRINGNET_API Observations {
  // The row of a file, for messages.
  struct Place {
    static constexpr std::uint32_t no_file = UINT32_MAX;  // a program made the row
    std::uint32_t file = no_file;                         // index into `files`
    std::uint32_t line = 0;                               // from 1; of a binary table the record, from 0
  };
  struct VectorRow {
    double time = 0.0;                 // s
    Vector3 value = Vector3::Zero();   // of positions m, velocities m/s, reactions N
    Vector3 weight = Vector3::Zero();  // of each component
    NodeIndex node = 0;
    Place place{};
  };
  struct DistanceRow {
    double time = 0.0;      // s
    double distance = 0.0;  // m
    double weight = 0.0;
    NodeIndex node = 0, other = 0;
    Place place{};
  };
  // A point on the surface; which node or face is nearest is not known.
  struct SurfacePoint {
    double time = 0.0;                // s
    Vector3 point = Vector3::Zero();  // m
    double weight = 0.0;              // of its distance from the surface
    Place place{};
  };
  struct File {
    std::string name;  // as in messages
    bool is_binary = false;
  };

  std::vector<VectorRow> positions, velocities, reactions;
  std::vector<DistanceRow> distances;
  std::vector<SurfacePoint> surface_points;
  // m: positions that are farther off, and points that are farther from the surface, count by their distance, in place
  // of its square (P. J. Huber, Ann. Math. Statist. 35, 1964), so that wrong ones do not outweigh the others.
  double outlier_distance = std::numeric_limits<double>::infinity();
  std::vector<File> files;

  // Times at which something is observed, s, ascending, each once.
  [[nodiscard]] std::vector<double> times() const;
  // Values with a weight above 0: each component of a vector, each distance, each surface point.
  [[nodiscard]] std::size_t value_count() const noexcept;
  // Adds the rows of another table of the same experiment. The lesser distance of outliers counts.
  void append(Observations other);
  // "camera.csv:12" or "trajectory.bin: record 3"; empty for a row without a file.
  [[nodiscard]] std::string text_of(const Place& place) const;
};

// Reads one table: CSV, or a binary one of a run. Throws Error(input), "file:line: what; what to do", for a file that
// cannot be read, columns that say nothing or not clearly what is observed, and cells that are not numbers, are
// infinite or out of range. Takes memory for the rows, not for the file.
[[nodiscard]] SPRINGNET_API Observations read_observations(const std::filesystem::path& file);

// Checks the observations of a net with this many nodes during [first_time, last_time], s. Throws Error(input) with the
// place of the row if a node does not exist, a time is outside of the interval (by more than 1e-9 of the greater of its
// ends, for rounding), a number is not finite, a weight or a distance is negative, a distance is that of a node to
// itself, or a value is observed twice; and if nothing is observed.
SPRINGNET_API void check_observations(const Observations& observations, std::size_t node_count, double first_time,
                                      double last_time);

}  // namespace springnet
