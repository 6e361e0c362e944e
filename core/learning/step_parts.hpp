// What a time step consists of if it is divided where events are located (`events = "located"`): parts, in which
// contacts stay as they are, and the events at their ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <springnet/simulation.hpp>

#include "learning/contact_history.hpp"
#include "simulation/engine.hpp"
#include "simulation/step_watch.hpp"

namespace springnet::learning {

// What an event makes of a node: its contact, position (m) and velocity (m/s) before and after, and the direction of
// its slip before.
struct NodeChange {
  std::uint32_t node = 0;  // the engine's
  Touch before{}, after{};
  Vector3 p = Vector3::Zero(), v = Vector3::Zero(), next_p = Vector3::Zero(), next_v = Vector3::Zero();
  Vector3 slip = Vector3::Zero();
  bool braced = false;  // before or after, see Contact::braced()
};

// What determines the time at which a part ends.
struct LocatedEvent {
  // rest: of a slip. slow, quick, stall, seam: see ContactEvents::Source. several: of one node, or of nodes
  // that are rigidly connected, at the same time.
  enum class Kind : std::uint8_t {
    touch,
    release,
    slip,
    rest,
    slow,
    quick,
    stall,
    seam,
    several,
    spring_rupture,
    element_rupture
  };
  Kind kind = Kind::touch;
  std::uint32_t index = 0;    // the engine's node, or the spring or element
  std::int32_t surface = -1;  // of a node
  // Of a node: what it makes of that, and if it is rigidly connected of all nodes of its cluster, ascending.
  NodeChange own{};
  std::vector<NodeChange> cluster{};
  // use(change): of each node that it changes.
  template <class Use>
  void for_each_node(const Use& use) const {
    if (!is_of_node()) return;
    if (cluster.empty()) use(own);
    for (const NodeChange& each : cluster) use(each);
  }
  [[nodiscard]] bool is_of_node() const noexcept { return kind < Kind::spring_rupture; }
};

struct StepPart {
  double time = 0.0;                 // s, at its end
  std::vector<LocatedEvent> events;  // none: it ends at a time that is given
  Eigen::VectorXd p, v, z;           // after them, the engine's order; empty: the end of the step
};

// Parts of the step that is made in its scope.
class PartRecorder final : public StepWatch {
 public:
  // What is committed, with its contacts until its events: `decided`: the sweeps have decided about them.
  struct Committed {
    Engine& engine;
    const StepPart& part;
    const Touches& within;
    bool decided;
  };
  // divides: whether steps are divided where events are located.
  PartRecorder(bool divides, std::function<void(const Committed&)> told) : divides_(divides), told_(std::move(told)) {}

  [[nodiscard]] bool divides() const noexcept { return divides_; }
  // Makes a step. told: if steps are divided, the function is called after each commit.
  void step(Simulation& simulation, bool told);
  // The last step had these.
  void take_up(std::vector<StepPart> parts) { parts_ = std::move(parts); }
  // Of this step; none if it was not divided.
  [[nodiscard]] const std::vector<StepPart>& parts() const noexcept { return parts_; }

  void fires(Engine& engine, double time, const State& state, const std::int32_t* fired) override;
  void committed(Engine& engine, bool decided) override;

 private:
  struct Outcome {
    std::vector<std::int32_t> touched, released;
    bool slipped = false, stuck = false;
  };
  [[nodiscard]] std::map<std::uint32_t, Outcome> outcomes(const Engine& engine) const;
  void add_events_of_nodes(Engine& engine, StepPart& part);
  [[nodiscard]] NodeChange change_of(const Engine& engine, std::uint32_t node) const;
  // Of all nodes that are rigidly connected.
  void add_event_of_cluster(const Engine& engine, std::size_t cluster, const std::map<std::uint32_t, Outcome>& all,
                            StepPart& part) const;

  bool divides_;
  std::function<void(const Committed&)> told_;
  bool tells_ = false;
  std::vector<StepPart> parts_;
  // Of events that have fired since the last commit.
  bool fired_ = false;
  std::size_t events_before_ = 0;         // in the journal
  std::vector<LocatedEvent> by_sources_;  // that were marked
  std::vector<LocatedEvent> ruptures_;
  Touches within_;
  Eigen::VectorXd p_, v_;  // as the events found them
  std::vector<Vector3> slips_;
  std::vector<std::uint32_t> braced_;  // nodes, ascending
};

}  // namespace springnet::learning
