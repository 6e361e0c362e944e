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
#include <springnet/output_folder.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

class CsvFile;
class TableFile;
class VtkSeries;

// Tables of comma separated values with a header line. Numbers are the shortest decimals that read back as the same
// double. Nodes and springs have the user's numbers. Constructors replace a file that is there and throw Error(input)
// if it cannot be created; they, record() and close() throw Error(simulation) if the file cannot be written, the disk
// being full for instance. The file then ends with its last whole record, whose time the message tells, and takes no
// more. Text is in the file a second after record() at the latest, if records go on. Those that take OutputOptions
// write the binary form of springnet/records.hpp if the options say so.

// "time,node" and the quantities of the options: "x,y,z" m, "vx,vy,vz" m/s, "fx,fy,fz" N (net force of springs and
// loads); a row for every node of the options and record, by rising node.
class TrajectoryWriter {
 public:
  TrajectoryWriter(const OutputFile& file, const Network& network, const OutputOptions& options = {});
  ~TrajectoryWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<TableFile> file_;
  std::vector<NodeIndex> nodes_;
  bool position_, velocity_, force_;
  std::vector<double> values_;  // [node][column]
};

// "time,spring,length,tension,energy,alive" in s, m, N, J: of the springs of the options, the distance of their ends,
// their tension (> 0 pulls the ends together) and the energy stored in them (nan where the law has none); 0 once they
// are removed, alive being 0 then.
class SpringWriter {
 public:
  SpringWriter(const OutputFile& file, const Network& network, const OutputOptions& options);
  ~SpringWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  struct Ends {
    SpringIndex spring;
    NodeIndex first, second;
  };
  std::unique_ptr<TableFile> file_;
  std::vector<Ends> springs_;
  std::vector<double> tensions_, energies_;  // of all springs
  std::vector<double> values_;               // [spring][column]
};

// "time,element,value,force,alive": of the elements of the options, in the units of its invariant
// (Simulation::element_value, element_force).
class ElementWriter {
 public:
  ElementWriter(const OutputFile& file, const Network& network, const OutputOptions& options = {});
  ~ElementWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<TableFile> file_;
  std::vector<ElementIndex> elements_;
  std::vector<double> values_;  // [element][column]
};

// "time,node,fx,fy,fz,tx,ty,tz,jx,jy,jz,surface" in s, N, N m, N s: the force that holds or moves a node, its torque
// about the origin, the impulses of touching that surfaces gave the node so far (Simulation::contact_impulse), and the
// surfaces that it is in contact with, as SurfaceWriter names them, joined by ';'. A row for each node of the options
// that is fixed, moved or in contact at the time, or whose impulse changed since the last record.
class ReactionWriter {
 public:
  ReactionWriter(const OutputFile& file, const Network& network, const OutputOptions& options = {});
  ~ReactionWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<CsvFile> file_;
  std::vector<NodeIndex> nodes_;
  std::vector<bool> fixed_;        // of nodes_
  std::vector<Vector3> impulses_;  // N s, of nodes_ at the last record
};

// "time,surface,x,y,z,fx,fy,fz,tx,ty,tz,nodes,jx,jy,jz" in s, m, N, N m, N s: where each plane and instrument is (its
// point, its first end), the force of the nodes in contact on it, the torque of that about the place, how many nodes
// there are, and the impulses of touching that nodes gave it so far (Simulation::surface_impulse). The surface's name
// stands in its column, or its number if it has none: planes first, then instruments.
class SurfaceWriter {
 public:
  explicit SurfaceWriter(const OutputFile& file);
  ~SurfaceWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<CsvFile> file_;
};

// "time,rigid,force" in s, N: the force in each rigid connection, > 0 is tension.
class RigidWriter {
 public:
  RigidWriter(const OutputFile& file, const Network& network);
  ~RigidWriter();
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<CsvFile> file_;
  RigidIndex count_;
};

// "time,event,element,index,surface,jx,jy,jz" in s, N s: cut and ruptured springs; nodes that touched a surface or were
// released from it, that slipped on it, stuck again or jammed, with the surface, as SurfaceWriter names it, and the
// impulse that it gave the node then.
class EventWriter {
 public:
  explicit EventWriter(const OutputFile& file);
  ~EventWriter();
  // Writes the events since the last call.
  void record(const Simulation& simulation);
  void close();

 private:
  std::unique_ptr<CsvFile> file_;
  std::size_t written_ = 0;
};

// Files for ParaView and other programs that read VTK's XML formats, in a folder that is made if it is not there: for
// each record net_<number>.vtu, with surfaces_<number>.vtp beside it if there are planes or instruments, and run.pvd,
// which lists them with their times and is complete after each record. core/docs/output.md lists the data. Throws as
// the tables do.
class VtkWriter {
 public:
  VtkWriter(const OutputFile& folder, const Network& network, const OutputOptions& options = {});
  ~VtkWriter();
  void record(const Simulation& simulation);
  void close();
  [[nodiscard]] std::uintmax_t bytes() const noexcept;  // of all files

 private:
  std::unique_ptr<VtkSeries> series_;
};

// How large the files of a run become. Tables of text too large: each number counts as the longest that there is.
struct FileEstimate {
  std::string file;    // name in the folder
  double bytes = 0.0;  // at most
  bool exact = false;
};
struct OutputEstimate {
  double records = 0.0;  // the one at the start included
  double bytes = 0.0;    // of all files
  std::vector<FileEstimate> files;
};
[[nodiscard]] OutputEstimate estimate_output(const Scene& scene);

struct RunProgress {
  double time;      // s, simulated
  double duration;  // s
  std::uint64_t steps;
  double wall;  // s
};

// The time that a run is measured with and that it keeps pace with.
struct RunClock {
  std::function<double()> now;              // s, from any start; never falls
  std::function<void(double)> sleep_until;  // until now() is this, or somewhat earlier
};

// Of an enclosed volume, m^3, over all records of a run until it leaked: until a spring of its surface was gone.
struct VolumeSummary {
  ElementIndex element;
  std::string name;  // of its [[element]], may be empty
  double first, last, smallest, greatest;
  bool leaked = false;
};

struct RunOptions {
  std::filesystem::path folder;  // made if it is not there
  std::string scene_name;        // for the summary
  // Called after every time step, and ten times a second of waiting for the clock; false stops the run.
  std::function<bool(const RunProgress&)> progress;
  // What the program that embeds the run has to tell, for the summary: first of its notes.
  std::vector<std::string> notes{};
  // Keeps pace with the clock: so many simulated seconds to one of the clock. 0: as fast as it goes.
  double realtime = 0.0;
  RunClock clock{};  // empty: the machine's
};

// How a run kept pace. A time step is a frame: it starts when the clock reaches the time at which it begins, and is due
// at that at which it ends. None is left out: after one that was late the next ones start at once until they have
// caught up.
struct PaceReport {
  double factor = 1.0;          // simulated seconds to one of the clock
  std::uint64_t frames = 0;     // time steps
  std::uint64_t missed = 0;     // of these, done after they were due
  double greatest_delay = 0.0;  // s, of the missed ones
};

// A plugin that a run took components from.
struct PluginUse {
  std::string id;
  std::string version;
  std::string file;  // its name without folder; empty if linked into the program
};
// Plugins of the network's laws and neurons and of the integrator, by id.
[[nodiscard]] std::vector<PluginUse> plugins_used(const Scene& scene, const PluginHost& plugins);

// A file that ends before the run does, because it could not be written any more.
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
  double duration = 0.0;                       // s, asked for
  unsigned threads = 1;
  std::string instruction_set;  // "generic", "avx2", "avx512"
  std::vector<PluginUse> plugins;

  std::size_t nodes = 0;
  std::size_t springs = 0;
  std::size_t springs_left = 0;
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
  double largest_residual = 0.0;   // N, over the time steps; nan if it was never evaluated
  double last_residual = 0.0;      // N
  EventCounts events;
  std::vector<VolumeSummary> volumes;
  std::map<std::string, double> statistics;
  std::vector<std::string> notes;  // of RunOptions, of the scene (notes_of), of the simulation

  std::uint64_t records = 0;
  std::uintmax_t bytes = 0;         // of the tables and the page
  std::vector<std::string> files;   // names in the folder, summary.json included
  std::vector<CutShort> cut_short;  // of these, what could not be written to the end

  std::string outcome;  // that of the worst time step ("settled", …), "failed" or "stopped"
  std::string error;    // why it failed; empty otherwise
  std::optional<ErrorKind> failure;
};

// Runs a scene and writes the files that it asks for (core/docs/output.md), events.csv and summary.json. A record is
// made at the start, at the first time step that ends at or after each multiple of the output interval, and at the end,
// also where the run fails or is stopped. Throws Error(input) or Error(plugin), before anything is written, if the
// scene cannot be simulated, its output would not fit the disk, another run is writing to the folder, or a folder has
// the name of a file. A failure later is told in the summary. The folder may be a link; links in it are replaced, never
// followed.
RunSummary run_scene(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const RunOptions& options);

// The text of summary.json.
[[nodiscard]] std::string to_json(const RunSummary& summary);

// "12 bytes", "3.4 MB"
[[nodiscard]] std::string readable_bytes(double bytes);

}  // namespace springnet
