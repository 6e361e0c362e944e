// Removal of springs, elements and loaded faces that are cut or break.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include <springnet/network.hpp>

#include "simulation/cutting.hpp"
#include "simulation/model.hpp"

namespace springnet {

class LinearModel;

class Topology {
 public:
  // Removals make the matrices of `linear` invalid.
  Topology(Model& model, LinearModel& linear, const std::vector<Cut>& cuts);

  // Springs and elements whose law has a rupture margin.
  struct Rupturing {
    std::vector<std::uint32_t> springs, elements;
    [[nodiscard]] std::size_t count() const noexcept { return springs.size() + elements.size(); }
  };
  [[nodiscard]] const Rupturing& rupturing();
  [[nodiscard]] std::size_t rupturing_count() const;  // without a list of them
  // margins: [rupturing().count()] of the springs, then of the elements, at a state; one of 0 or less breaks.
  // SPRINGNET_RECOVERABLE and a message if one is not a number.
  springnet_status margins(double time, const layers::NodeArrays& nodes, double* margins);

  // Removes springs, the elements and loaded faces with an edge along one of them, and further elements and faces.
  // Records events of this kind, with the state `nodes`. Returns the number of springs removed.
  struct Removal {
    std::vector<std::uint32_t> springs, elements;
    std::vector<std::size_t> faces;
  };
  std::size_t remove(const Removal& removal, Event::Kind kind, double time, const layers::NodeArrays& nodes);
  // All is there again but what is listed, elements and faces along these springs among it. Records nothing.
  void put_back_all_but(const Removal& removed);
  // At the committed state. Nodes lose all that is theirs.
  std::size_t remove_elements(const std::vector<std::uint32_t>& elements);
  void remove_nodes(const std::vector<std::uint32_t>& nodes);
  std::size_t cut(const std::vector<std::uint32_t>& springs);
  std::size_t cut(const CuttingPolygon& polygon);
  // The scene's cuts up to the committed time.
  void perform_due_cuts();
  // Removes what has no margin left at the committed state.
  springnet_status perform_due_ruptures();
  // Internal states of what has been removed stay as they were before a commit.
  void keep_states_of_removed(const State& before);
  // The same of the network before it was extended.
  void take_over(const Topology& before);
  // What has been removed, and the cuts that were made.
  void archive(Archive& archive);
  // Whether a cut of the scene was made, by its number.
  [[nodiscard]] bool is_done(std::size_t cut) const { return cuts_[cut].done; }
  // Time of the scene's next cut, s; infinity if there is none.
  [[nodiscard]] double next_cut(double time) const noexcept;

 private:
  struct ScheduledCut {
    double time;  // s
    std::vector<std::uint32_t> springs;
    std::optional<CuttingPolygon> polygon;
    bool done = false;
  };
  // The event of a spring, or an element, that is still there.
  [[nodiscard]] Event event_of_spring(std::uint32_t spring, Event::Kind kind, double time,
                                      const layers::NodeArrays& nodes) const;
  [[nodiscard]] Event event_of_element(std::uint32_t element, Event::Kind kind, double time,
                                       const layers::NodeArrays& nodes) const;
  void lay_out_without(const Removal& removed);
  // Returns whether any face was removed.
  bool remove_faces(const std::vector<std::size_t>& faces, double time);

  Model& model_;
  LinearModel& linear_;
  std::vector<ScheduledCut> cuts_;
  std::optional<Rupturing> rupturing_;  // empty: not known
  std::vector<std::uint32_t> broken_;   // found last; kept for its memory
  std::set<std::uint32_t> torn_loads_;  // that have lost faces
  std::size_t torn_faces_ = 0;
  std::vector<std::uint64_t> removed_states_;  // places of internal states, of the layout's revision
  std::uint64_t states_revision_ = 0;
};

}  // namespace springnet
