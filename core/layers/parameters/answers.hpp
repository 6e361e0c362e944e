// The derivatives that the laws of some springs or elements, or the neurons of some nodes, answer for sets of
// parameters.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "layers/elements/invariant.hpp"
#include "layers/elements/several.hpp"
#include "layers/evaluator.hpp"
#include "layers/law_pair.hpp"
#include "layers/parameters/sets.hpp"

namespace springnet::layers {

// A state that is held; its `nodes` say how internal states of laws are treated.
struct HeldState {
  double time;  // s
  const NodeArrays& nodes;
};

// Springs or elements of one group that laws are called for at a time, or nodes with one kind of neuron.
struct ParameterPiece {
  enum class Of : std::uint8_t { springs, elements, enclosure, nodes };
  Of of;
  std::uint32_t group;  // of laws; kind of neuron
  std::size_t begin;    // springs: in Layout::springs_of(); elements: the batch; the enclosure; the first node
  std::size_t count;
};

class LawAnswers {
 public:
  LawAnswers(const Layout& layout, const Evaluator& evaluator);

  // Evaluates the laws of a piece.
  springnet_status find(const ParameterPiece& piece, const ResolvedSets& sets, const HeldState& at,
                        springnet_message& message);
  // Then finds the weight of each member's force: weights . dF/dQ, with `weights` on all nodes ([3 node]).
  void weigh(const double* weights, const NodeArrays& nodes);

  struct Answer {
    std::uint32_t set, member;  // member: spring or element
    std::size_t place;          // of the member in the piece
    std::size_t scalar;         // of the group's list: which of the law's forces; 0 of laws with one
    double derivative;          // of the law's force by the set's parameter of this member
    double weight;              // of the law's force; after weigh()
    bool is_relative;           // the law acts along the relative velocity
  };
  // Member by member for each parameter of a law and each of its forces, law by law.
  template <class Use>
  void for_each(const Use& use) const;
  // The same set by set: use(set, for_each), and that with a use of answers, once.
  template <class Use>
  void for_each_set(const Use& use) const;
  // The same of internal states, if sets are resolved with them: use(set, member, place in the internal state,
  // derivative).
  template <class Use>
  void for_each_state(const Use& use) const;

  // The forces on the corners of the piece's elements from changes of their generalised forces, [scalar][member]; of
  // laws over several scalars: use(member, corner, force).
  template <class Use>
  void for_each_corner(const double (*changes)[several_batch], const Use& use) const;

 private:
  // Calls use(law, entry, derivatives of its forces ([scalar][member], then of its states)).
  template <class Use>
  void for_each_entry(const Use& use) const;
  // use(member of the piece), of those that it is about.
  template <class Use>
  void for_each_member(const SetsOfGroup::Entry& entry, const Use& use) const;
  template <class Use>
  void for_each_answer(const Law& law, const SetsOfGroup::Entry& entry, const double* derivative, const Use& use) const;
  [[nodiscard]] std::uint64_t internal_place(const Law& law, std::uint32_t member, std::size_t state) const {
    const InternalLayout& internal = layout_.internal();
    const InternalLayout::OfGroup& own = internal.group(piece_.group);
    const std::uint32_t place =
        piece_.of == ParameterPiece::Of::springs ? internal.of_spring(member) : internal.of_element(member);
    return own.first + (law.first_state + state) * own.count + place;
  }
  springnet_status find_springs(const HeldState& at, springnet_message& message);
  springnet_status find_elements(const HeldState& at, springnet_message& message);
  springnet_status find_several(const HeldState& at, springnet_message& message);
  void forces_of_several(const double (*changes)[several_batch], const CornerForces& out) const;
  // By how much what an entry is about grows with the element, of laws over several scalars; else 1.
  [[nodiscard]] double growth(const Law& law, const SetsOfGroup::Entry& entry, std::size_t i) const {
    if (law.scalar_count == 0 || sets_->sets()[entry.set].kind != ParameterSet::Kind::reference) return 1.0;
    if (entry.scalar >= law.scalar_count) return -several_members_.direction[entry.scalar - law.scalar_count][i];
    const std::size_t s = law.scalar[entry.scalar];
    return group_->scalars.scalar[s].dimension() * several_members_.reference[s][i];
  }
  [[nodiscard]] PairOutputs outputs(const InternalView* view);

  const Layout& layout_;
  const Evaluator& evaluator_;
  ParameterPiece piece_{};
  const Group* group_ = nullptr;
  const SetsOfGroup* wanted_ = nullptr;
  const ResolvedSets* sets_ = nullptr;
  std::uint32_t members_[max_segment], rows_[max_segment];
  double weight_[2][max_segment]{};   // axial or of the element, along the relative velocity
  std::vector<double> derivatives_;   // [slot of either law][max_segment]
  std::vector<double*> jacobian_[2];  // of each law; null where not wanted
  double* by_parameters_[2][max_parameters];
  std::unique_ptr<SegmentGeometry> segment_;  // of springs
  std::vector<FirstOrder> elements_;          // of elements
  // Of elements whose laws read several scalars, and the weights of their forces, [scalar][member].
  std::unique_ptr<SeveralGeometry> several_;
  SeveralMembers several_members_{};
  std::vector<std::array<double, several_batch>> several_weight_;
};

template <class Use>
void LawAnswers::for_each_entry(const Use& use) const {
  std::size_t slots_before = 0;
  const std::array<const Law*, 2> laws = group_->laws();
  for (std::size_t k = 0; k < 2; ++k) {
    const SetsOfGroup::OfLaw& own = wanted_->laws[k];
    for (const SetsOfGroup::Entry& entry : own.entries)
      use(*laws[k], entry, derivatives_.data() + (slots_before + entry.slot) * max_segment);
    slots_before += own.slots.size();
  }
}

template <class Use>
void LawAnswers::for_each_member(const SetsOfGroup::Entry& entry, const Use& use) const {
  const ParameterSet& set = sets_->sets()[entry.set];
  const bool is_input = set.kind == ParameterSet::Kind::input;
  for (std::size_t i = 0; i < piece_.count; ++i)
    if (!is_input || static_cast<std::uint32_t>(group_->columns[entry.signal_column][rows_[i]]) == set.input) use(i);
}

template <class Use>
void LawAnswers::for_each_answer(const Law& law, const SetsOfGroup::Entry& entry, const double* derivative,
                                 const Use& use) const {
  if (law.scalar_count == 0) {
    const double* const weight = weight_[law.relative ? 1 : 0];
    return for_each_member(entry, [&](std::size_t i) {
      use(Answer{entry.set, members_[i], i, 0, derivative[i], weight[i], law.relative});
    });
  }
  for_each_member(entry, [&](std::size_t i) {
    const double factor = growth(law, entry, i);
    for (std::size_t j = 0; j < law.scalar_count; ++j) {
      const std::size_t s = law.scalar[j];
      if (!law.reads[j]) continue;
      use(Answer{entry.set, members_[i], i, s, factor * derivative[j * max_segment + i], several_weight_[s][i], false});
    }
  });
}

template <class Use>
void LawAnswers::for_each(const Use& use) const {
  for_each_entry([&](const Law& law, const SetsOfGroup::Entry& entry, const double* derivative) {
    for_each_answer(law, entry, derivative, use);
  });
}

template <class Use>
void LawAnswers::for_each_set(const Use& use) const {
  for_each_entry([&](const Law& law, const SetsOfGroup::Entry& entry, const double* derivative) {
    use(entry.set, [&](const auto& of_answer) { for_each_answer(law, entry, derivative, of_answer); });
  });
}

template <class Use>
void LawAnswers::for_each_corner(const double (*changes)[several_batch], const Use& use) const {
  double force[3][max_corners * several_batch];
  forces_of_several(changes, {force[0], force[1], force[2], several_batch});
  for (std::size_t i = 0; i < piece_.count; ++i)
    for (std::size_t c = 0; c < group_->scalars.corners; ++c) {
      const std::size_t at = c * several_batch + i;
      use(members_[i], c, Vector3(force[0][at], force[1][at], force[2][at]));
    }
}

template <class Use>
void LawAnswers::for_each_state(const Use& use) const {
  for_each_entry([&](const Law& law, const SetsOfGroup::Entry& entry, const double* derivative) {
    for_each_member(entry, [&](std::size_t i) {
      for (std::size_t j = 0; j < law.state_count; ++j)
        use(entry.set, members_[i], internal_place(law, members_[i], j), derivative[(1 + j) * max_segment + i]);
    });
  });
}

class NeuronAnswers {
 public:
  NeuronAnswers(const Layout& layout, const Evaluator& evaluator) : layout_(layout), evaluator_(evaluator) {}

  // force: net forces on all nodes, [3 node] N.
  springnet_status find(const ParameterPiece& piece, const ResolvedSets& sets, const HeldState& at, const double* force,
                        springnet_message& message);
  // da/dF of the i-th node, 1/kg.
  [[nodiscard]] Eigen::Map<const Block> by_force(std::size_t i) const {
    return Eigen::Map<const Block>(by_force_.data() + 9 * i);
  }
  // Derivatives of its acceleration: use(set, derivative).
  template <class Use>
  void for_each(std::size_t i, const Use& use) const {
    using By = ResolvedSets::NeuronEntry::By;
    for (const ResolvedSets::NeuronEntry& entry : *wanted_) {
      const std::size_t scalar = entry.by == By::mass ? 0 : entry.by == By::time ? 1 : 2 + entry.parameter;
      use(entry.set, Vector3(Eigen::Map<const Vector3>(scalars_[scalar].data() + 3 * i)));
    }
  }

 private:
  const Layout& layout_;
  const Evaluator& evaluator_;
  const std::vector<ResolvedSets::NeuronEntry>* wanted_ = nullptr;
  std::vector<double> by_force_, acceleration_;
  std::vector<std::vector<double>> scalars_;  // [mass, time, parameters][node][3]
};

}  // namespace springnet::layers
