// view.html: a self-contained page that plays a run in a browser. core/docs/view.md describes it.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/output_folder.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// Values of springs, nodes or elements that were learned. They are colours of the page.
struct ViewValues {
  enum class Of : std::uint8_t { springs, nodes, elements };
  struct Value {
    std::uint32_t member = 0;  // spring, node or element
    double start = 0.0, value = 0.0;
    double lower = 0.0, upper = 0.0;  // ends of the 95 % interval
    double determined = 1.0;          // share that the data determine; nan: not known
    double from_guess = 0.0;          // share that comes from the guess; nan: not known
    // false: the data say nothing of it. It has no interval then, whatever the ends are.
    bool has_interval = true;
  };
  Of of = Of::springs;
  std::string name;           // "spring.stiffness"
  std::string unit;           // empty: dimensionless
  std::vector<Value> values;  // of each member once
};

// What was observed: a place of a node or of a point of the surface, or a node's velocity, or the force that holds it.
struct ViewPoint {
  enum class What : std::uint8_t { position, velocity, force };
  static constexpr NodeIndex no_node = std::numeric_limits<NodeIndex>::max();
  double time = 0.0;                // s
  Vector3 point = Vector3::Zero();  // m, m/s or N
  NodeIndex node = no_node;         // of a velocity or force there is one
  What what = What::position;
  bool held_out = false;  // not learned from
};

// What a page shows of a net that was learned, beside its motion.
struct LearnedView {
  std::vector<ViewValues> values;
  std::vector<ViewPoint> observed;
  std::vector<std::string> notes;  // plain text
  std::string below;               // HTML below the rest of the page, trusted; the page's own policy applies to it
};

struct ViewOptions {
  double size = 16e6;                                   // largest size of the page, bytes
  std::shared_ptr<const PluginHost> plugins = nullptr;  // of the run, for the units of laws; null: no units
  // For the page of a learned net: its records have the motion of the start, too.
  std::shared_ptr<const LearnedView> learned = nullptr;
  // Of what the page's program leaves of the size, the share of this motion, where the page has several.
  double share = 1.0;
};

// Collects the records of a run and writes the page. The size of the page bounds the memory: once there are more
// records than fit, every second one is dropped, evenly over the run; of a network with more springs than can be drawn,
// some are left out. The page and left_out() report both. The first and the last record are always there.
class SPRINGNET_API ViewWriter {
 public:
  // Writes a page that says that the run has not ended. Throws Error(input) if it cannot be created, or if what
  // was learned is of springs, nodes or elements that the network does not have. The scene must outlive the writer.
  ViewWriter(const OutputFile& file, const Scene& scene, const ViewOptions& options = {});
  ~ViewWriter();
  ViewWriter(const ViewWriter&) = delete;
  ViewWriter& operator=(const ViewWriter&) = delete;

  // A further motion, which a menu of the page chooses: record it with the writer that is returned, which belongs to
  // this one and is closed with it. Give all of them their share of the size.
  ViewWriter& add(const Scene& scene, const ViewOptions& options);

  // Records the present state and the events since the last call.
  void record(const Simulation& simulation);
  // Of a page with ViewOptions::learned: with the motion of the values at the start, at the same time.
  void record(const Simulation& simulation, const Simulation& start);
  // Call it if the run failed: the page will begin with the reason, plain text of any length. The last call counts.
  void failed(const std::string& reason);
  // Writes the page with what was recorded, also after a failure. If that is not possible, throws Error(simulation) and
  // leaves no file. The destructor calls it if necessary, and ignores errors.
  void close();

  // Notes on what the page leaves out or rounds; complete after close().
  [[nodiscard]] const std::vector<std::string>& left_out() const noexcept;

 private:
  struct SPRINGNET_LOCAL Impl;
  explicit ViewWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Upper bound for the size of a run's page, bytes; 0 if the scene requests none.
[[nodiscard]] SPRINGNET_API double estimate_view(const Scene& scene);

}  // namespace springnet
