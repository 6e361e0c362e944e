// Event functions of contacts (touch, release, slip, stick) and ruptures, for integrators with root finding.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "simulation/body_motion.hpp"
#include "simulation/model.hpp"
#include "simulation/reactions_at.hpp"
#include "simulation/settling.hpp"
#include "simulation/topology.hpp"

namespace springnet {

class ContactEvents {
 public:
  ContactEvents(Model& model, Topology& topology) : model_(model), topology_(topology) {}

  // One event function of a node and an obstacle.
  struct Source {
    // rest: a slip has no speed left along its direction. slow: it is about to end, friction keeps its direction;
    // quick: friction follows the slip again. stall: the acceleration of a starting slip reverses. seam: a sliding node
    // crosses a line where the curvature of its obstacle jumps, a pair comes to a border of a face or an edge.
    enum class Kind : std::uint8_t { touch, release, slip, rest, slow, quick, stall, seam };
    Kind kind;
    std::uint32_t index;  // node
    std::uint32_t surface;
    // Added to the value. Touch: depth behind the obstacle at which it counts, m; slip: N; release: N of pairs and of
    // clusters that bodies may push, m/s^2 of braced nodes.
    double offset = 0.0;
    // Of a pair of bodies its place among those that touch; -1: of a node and an obstacle.
    std::int32_t pair = -1;
  };
  // For the present revision of the model.
  [[nodiscard]] const std::vector<Source>& sources();
  // To be called when a state is committed. Offsets of sources follow the state that was committed after the change of
  // the network, whoever asked for them in between.
  void committed() noexcept {
    if (committed_revision_ != model_.revision) sources_revision_ = 0;
    committed_revision_ = model_.revision;
  }
  // Sources are listed anew, with offsets from the committed state, now and after the next commit: in a copy, which
  // counts other revisions, that commit would do so.
  void forget() noexcept { sources_revision_ = committed_revision_ = 0; }
  // Of pairs that do not touch but overlap at the state that was committed after the change of the network: from which
  // depth on they touch, m; of others from the contact tolerance on.
  [[nodiscard]] const std::map<std::pair<proximity::PairKind, proximity::Pair>, double>& pair_depths() {
    static_cast<void>(sources());
    return pair_depths_;
  }
  // Of these, and after them of the springs and elements that may break.
  [[nodiscard]] std::size_t count() { return sources().size() + topology_.rupturing_count(); }
  // Values and directions of all of them, as in springnet_host::event_values.
  springnet_status values(const springnet_evaluation& at, double* values, std::int32_t* directions);
  // That of one event of a contact.
  springnet_status value(const Source& source, ReactionsAt& reactions, double& value) const;
  // What they are, as in springnet_event_values; null: not wanted.
  void names(std::uint32_t* kinds, std::uint32_t* who, std::uint32_t* surfaces);
  // Carries out the events marked in `fired`, and touches within the contact tolerance; then evaluates the forces of
  // `state`.
  springnet_status fire(double time, State& state, const std::int32_t* fired);

 private:
  using Kind = Source::Kind;
  // Friction follows the direction of a slip faster than this multiple of the rest speed.
  static constexpr double quick_slip = 4.0;
  static constexpr double rounding_of_force = 1e-14;  // in units of the force scale
  // Reactions at the committed state, computed when they are first asked for.
  class AtCommitted {
   public:
    explicit AtCommitted(Model& model) : model_(model) {}
    ReactionsAt& operator()() {
      if (!reactions_)
        reactions_.emplace(model_, model_.time, read_only(model_.state.view.position),
                           read_only(model_.state.view.velocity));
      return *reactions_;
    }

   private:
    Model& model_;
    std::optional<ReactionsAt> reactions_;
  };
  void add_sources_of(std::uint32_t node, double tolerance, const Placement& now, AtCommitted& at);
  void add_sources_of_pairs(AtCommitted& at);
  void find_redundant();
  [[nodiscard]] double same_gap() const;
  // How far a pair that touches is from saying what others that touch say, too; below 0 it does. 1
  [[nodiscard]] double before_redundant(std::int32_t pair, const BodyMotion& all,
                                        const springnet_const_vectors& position) const;
  springnet_status pair_value(const Source& source, ReactionsAt& reactions, double& value) const;
  void find_pair(const Source& source, double time, const State& state, Findings& findings);
  // Pairs of bodies that approach within the contact tolerance.
  void find_impacts(const State& state, Findings& findings);
  // Of a braced node: acceleration of its gap if it had no contact, m/s^2.
  springnet_status separating_acceleration(const Source& release, const ReactionsAt& at, double& value) const;
  [[nodiscard]] double beyond_cone(const Source& slip, AtCommitted& at) const;        // N
  [[nodiscard]] double beyond_held(const Source& slip, AtCommitted& at) const;        // N
  [[nodiscard]] double beyond_brace(const Source& release, AtCommitted& at) const;    // m/s^2
  [[nodiscard]] double beyond_release(const Source& release, AtCommitted& at) const;  // N
  [[nodiscard]] double behind_border(const Source& seam, AtCommitted& at) const;      // 1
  // N, by which forces have to leave their cones to count: those of redundant pairs lie on the boundaries of cones as
  // long as others bear the rest.
  [[nodiscard]] double on_cones() const;
  // Rigidly connected, while bodies touch: its reaction is not unique.
  [[nodiscard]] bool is_pushed_cluster(std::uint32_t node) const;
  [[nodiscard]] bool is_impacting(const Source& touch, const Placement& at, const State& state, double tolerance) const;

  Model& model_;
  Topology& topology_;
  std::vector<Source> sources_;
  std::map<std::pair<proximity::PairKind, proximity::Pair>, double> pair_depths_;
  double pair_tolerance_ = 0.0;  // m
  // Of pairs that touch, what they may come to be: the same as these others, edges that are side by side.
  std::vector<std::vector<std::size_t>> may_be_same_;
  std::vector<std::uint8_t> may_be_side_by_side_;
  std::uint64_t sources_revision_ = 0;
  std::uint64_t committed_revision_ = 0;  // of the network at the last commit
};

}  // namespace springnet
