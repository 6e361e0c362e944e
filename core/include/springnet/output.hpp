// What a run leaves behind: tables of its course (CSV) and a summary (JSON). Everything is written as it happens, so
// that memory does not grow with the length of a run and a run that fails keeps what was written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/events.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

class CsvFile;

// Tables of comma separated values with a header line. Numbers are the shortest decimals that read back as the same
// double. Nodes and springs have the user's numbers. Constructors replace a file that is there and throw Error(input)
// if it cannot be created; record() and close() throw Error(simulation) if the file cannot be written, the disk being
// full for instance. What was written until then stays.

// "time,node,x,y,z,vx,vy,vz" in s, m, m/s; a row for every node and record, by rising node.
class TrajectoryWriter {
 public:
  explicit TrajectoryWriter(const std::filesystem::path& file);
  ~TrajectoryWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<CsvFile> file_;
};

// "time,node,fx,fy,fz,tx,ty,tz" in s, N, N m: the force that holds or moves a node, and its torque about the origin,
// for each node that is fixed, moved or in contact at the time.
class ReactionWriter {
 public:
  ReactionWriter(const std::filesystem::path& file, const Network& network);
  ~ReactionWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<CsvFile> file_;
  std::vector<bool> fixed_;  // by the user's node
};

// "time,surface,x,y,z,fx,fy,fz,tx,ty,tz,nodes" in s, m, N, N m: where each plane and instrument is (its point, its
// first end), the force of the nodes in contact on it, the torque of that about the place, and how many nodes there
// are. The surface's name stands in its column, or its number if it has none: planes first, then instruments.
class SurfaceWriter {
 public:
  explicit SurfaceWriter(const std::filesystem::path& file);
  ~SurfaceWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<CsvFile> file_;
};

// "time,rigid,force" in s, N: the force in each rigid connection, > 0 is tension.
class RigidWriter {
 public:
  RigidWriter(const std::filesystem::path& file, const Network& network);
  ~RigidWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<CsvFile> file_;
  RigidIndex count_;
};

// "time,event,element,index" in s: cut and ruptured springs; nodes that touched a surface or were released from it,
// that slipped on it or stuck again.
class EventWriter {
 public:
  explicit EventWriter(const std::filesystem::path& file);
  ~EventWriter();
  // Writes the events since the last call.
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<CsvFile> file_;
  std::size_t written_ = 0;
};

// How large the files of a run become, rather too large: rows are shorter where numbers have few digits.
struct OutputEstimate {
  double records = 0.0;  // the one at the start included
  double bytes = 0.0;
};
[[nodiscard]] OutputEstimate estimate_output(const Scene& scene);

struct RunProgress {
  double time;      // s, simulated
  double duration;  // s
  std::uint64_t steps;
  double wall;  // s
};

struct RunOptions {
  std::filesystem::path folder;  // made if it is not there
  std::string scene_name;        // for the summary
  // Called after every time step; false stops the run.
  std::function<bool(const RunProgress&)> progress;
  // What the program that embeds the run has to tell, for the summary: first of its notes.
  std::vector<std::string> notes{};
};

// A plugin that a run took components from.
struct PluginUse {
  std::string id;
  std::string version;
  std::string file;  // its name without folder; empty if linked into the program
};
// Plugins of the network's laws and neurons and of the integrator, by id.
[[nodiscard]] std::vector<PluginUse> plugins_used(const Scene& scene, const PluginHost& plugins);

struct RunSummary {
  std::string scene;
  std::string title;
  LawUse integrator;
  std::map<std::string, std::string> choices;  // names of those integrator options that are choices
  double time_step = 0.0;                      // s
  double duration = 0.0;                       // s, asked for
  unsigned threads = 1;
  std::string instruction_set;  // "generic", "avx2", "avx512"
  std::vector<PluginUse> plugins;

  std::size_t nodes = 0;
  std::size_t springs = 0;
  std::size_t springs_left = 0;
  std::uint64_t steps = 0;
  std::uint64_t sweeps = 0;
  double spring_updates = 0.0;    // springs evaluated
  double simulated = 0.0;         // s, reached
  double wall = 0.0;              // s, simulating
  double output_wall = 0.0;       // s, writing
  std::uint64_t unsettled = 0;    // time steps that were accepted without having settled
  std::uint64_t divided = 0;      // time steps that were made as several smaller ones
  std::uint64_t substeps = 0;     // those smaller ones
  std::uint64_t stages = 0;       // smaller time constants passed on the way to the full one
  double largest_residual = 0.0;  // N, over the time steps; nan if it was never evaluated
  double last_residual = 0.0;     // N
  EventCounts events;
  std::map<std::string, double> statistics;
  std::vector<std::string> notes;  // of RunOptions, of the scene (notes_of), of the simulation

  std::uint64_t records = 0;
  std::uintmax_t bytes = 0;        // of the tables and the page
  std::vector<std::string> files;  // names in the folder, summary.json included

  std::string outcome;  // that of the worst time step ("settled", …), "failed" or "stopped"
  std::string error;    // why it failed; empty otherwise
  std::optional<ErrorKind> failure;
};

// Runs a scene and writes trajectory.csv, reactions.csv, surfaces.csv, rigid.csv (those that the scene asks for; the
// last two if it has surfaces and rigid connections), events.csv, view.html and summary.json. A record is made at the
// start, at the first time step that ends at or after each multiple of the output interval, and at the end. Throws
// Error(input) or Error(plugin), before anything is written, if the scene cannot be simulated or its output would not
// fit the disk. A failure later is told in the summary.
RunSummary run_scene(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const RunOptions& options);

// The text of summary.json.
[[nodiscard]] std::string to_json(const RunSummary& summary);

// "12 bytes", "3.4 MB"
[[nodiscard]] std::string readable_bytes(double bytes);

}  // namespace springnet
