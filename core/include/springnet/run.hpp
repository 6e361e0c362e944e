// A run: simulates a scene and writes the files that it requests. They are written during the run, so that memory does
// not grow with its length, and a run that fails keeps its output.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/events.hpp>
#include <springnet/export.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/profile.hpp>
#include <springnet/readable.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>
#include <springnet/tables.hpp>

namespace springnet {

// The size of a run's files.
struct OutputEstimate {
  double records = 0.0;  // the one at the start included
  double bytes = 0.0;    // of all files
  std::vector<FileEstimate> files;
};
[[nodiscard]] SPRINGNET_API OutputEstimate estimate_output(const Scene& scene);

struct RunProgress {
  double time;      // s, simulated
  double duration;  // s
  std::uint64_t steps;
  double wall;  // s
};

// The clock that a run measures time by, and keeps pace with.
struct RunClock {
  std::function<double()> now;              // s, from any start; never decreases
  std::function<void(double)> sleep_until;  // returns when now() is this, or somewhat earlier
};

// An enclosed volume over all records of a run, m^3. Once a spring of its surface is removed it has leaked, and later
// records do not count.
struct VolumeSummary {
  ElementIndex element;
  std::string name;  // of its [[element]], may be empty
  double first, last, smallest, greatest;
  bool leaked = false;
};

struct RunOptions {
  std::filesystem::path folder;  // created if necessary
  std::string scene_name;        // for the summary
  // Called after every time step, and ten times a second of waiting for the clock; false stops the run.
  std::function<bool(const RunProgress&)> progress;
  // Notes of the program that embeds the run; the first ones in the summary.
  std::vector<std::string> notes{};
  // Simulated seconds per second of the clock; 0: as fast as possible.
  double realtime = 0.0;
  RunClock clock{};  // empty: the system's
  // Write profile.json, the time that each stage, law, solver and output took; and trace.json, their course for a
  // viewer of traces (core/docs/output.md). If the scene has a profiler, it records for both.
  bool profile = false;
  bool trace = false;
  // Above 0: keep a checkpoint in the folder, of the first time step that ends at or after each multiple of so many
  // simulated seconds. The integrator drops its history there (Simulation::save()), so that a run that resumes writes
  // the same bytes as one that was not disturbed. It is removed when the run has reached its end.
  double checkpoint = 0.0;  // s
  // Go on from the checkpoint in the folder: the files go on where they ended then, what they have beyond is cut off.
  // `checkpoint` 0: as before. Throws Error(input) if there is none, or it is of another scene, options or version.
  bool resume = false;
  LoadingCallback loading{};  // called before the first time step, where setting up takes time
};

// Of how many stages a run keeps the times for trace.json.
inline constexpr std::size_t run_trace_events = 100000;

// How a run kept pace with the clock. Each time step is a frame: it starts when the clock reaches its start time, and
// is due at its end time. No frame is skipped: after a late one the next ones start at once until they have caught up.
struct PaceReport {
  double factor = 1.0;          // simulated seconds per second of the clock
  std::uint64_t frames = 0;     // time steps
  std::uint64_t missed = 0;     // frames done after they were due
  double greatest_delay = 0.0;  // s, of the missed ones
};

// A plugin whose components a run used.
struct PluginUse {
  std::string id;
  std::string version;
  std::string file;  // its name without folder; empty if linked into the program
};
// Plugins of the network's laws and neurons and of the integrator, by id.
[[nodiscard]] SPRINGNET_API std::vector<PluginUse> plugins_used(const Scene& scene, const PluginHost& plugins);

// A file that could not be written to the end of the run.
struct CutShort {
  std::string file;    // name in the folder
  double until = 0.0;  // s, of its last record; nan if it has none
};

struct RunSummary {
  std::string scene;
  std::string title;
  LawUse integrator;
  std::map<std::string, std::string> choices;  // names of those integrator options that are choices
  double time_step = 0.0;                      // s
  double duration = 0.0;                       // s, requested
  unsigned threads = 1;
  std::string instruction_set;  // "generic", "avx2", "avx512"
  std::vector<PluginUse> plugins;

  std::size_t nodes = 0;
  std::size_t springs = 0;
  std::size_t springs_left = 0;
  std::size_t elements = 0;
  std::size_t elements_left = 0;
  std::uint64_t steps = 0;
  std::uint64_t sweeps = 0;
  double spring_updates = 0.0;     // springs evaluated
  double simulated = 0.0;          // s, reached
  double wall = 0.0;               // s, simulating
  double output_wall = 0.0;        // s, writing
  std::optional<PaceReport> pace;  // of a run that kept pace with the clock
  std::uint64_t unsettled = 0;     // time steps that were accepted without having settled
  std::uint64_t divided = 0;       // time steps that were made as several smaller ones
  std::uint64_t substeps = 0;      // those smaller ones
  std::uint64_t stages = 0;        // smaller time constants passed on the way to the full one
  double largest_residual = std::numeric_limits<double>::quiet_NaN();  // N, over the time steps; nan: never evaluated
  double last_residual = std::numeric_limits<double>::quiet_NaN();     // N
  EventCounts events;
  std::vector<VolumeSummary> volumes;
  std::map<std::string, double> statistics;
  std::vector<std::string> notes;  // of RunOptions, of the scene (notes_of), of the simulation

  std::uint64_t records = 0;
  std::uintmax_t bytes = 0;         // of the tables and the page
  std::vector<std::string> files;   // names in the folder, summary.json included
  std::vector<CutShort> cut_short;  // of these, what could not be written to the end

  std::optional<Profile> profile;  // if RunOptions ask for it

  std::string outcome;  // that of the worst time step ("settled", …), "failed" or "stopped"
  std::string error;    // why it failed; empty otherwise
  std::optional<ErrorKind> failure;
};

// Runs a scene and writes the files that it requests (core/docs/output.md), events.csv and summary.json. A record is
// made at the start, at the first time step that ends at or after each multiple of the output interval, and at the end,
// also if the run fails or is stopped. Throws Error(input) or Error(plugin), before anything is written, if the
// scene cannot be simulated, its output would not fit on the disk, another run is writing to the folder, or a folder
// has the name of a file. The summary reports a later failure. The folder may be a link; links in it are replaced,
// never followed.
SPRINGNET_API RunSummary run_scene(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                                   const RunOptions& options);

// The text of summary.json.
[[nodiscard]] SPRINGNET_API std::string to_json(const RunSummary& summary);
// The text of profile.json. steps: of the run, for the shares of one.
[[nodiscard]] SPRINGNET_API std::string to_json(const Profile& profile, std::uint64_t steps, unsigned threads);

}  // namespace springnet
