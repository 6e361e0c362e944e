// The derivatives that the laws of some springs or elements, or the neurons of some nodes, answer for sets of
// parameters.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "layers/elements/invariant.hpp"
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
    double derivative;          // of the law's force by the set's parameter of this member
    double weight;              // of the law's force; after weigh()
    bool is_relative;           // the law acts along the relative velocity
  };
  // Member by member for each parameter of a law, law by law.
  template <class Use>
  void for_each(const Use& use) const;
  // The same of internal states, if sets are resolved with them: use(set, member, place in the internal state,
  // derivative).
  template <class Use>
  void for_each_state(const Use& use) const;

 private:
  // Calls use(law, set, derivatives of its force ([member], then of its states), member of the piece).
  template <class Use>
  void for_each_entry(const Use& use) const;
  [[nodiscard]] std::uint64_t internal_place(const Law& law, std::uint32_t member, std::size_t state) const {
    const InternalLayout& internal = layout_.internal();
    const InternalLayout::OfGroup& own = internal.group(piece_.group);
    const std::uint32_t place =
        piece_.of == ParameterPiece::Of::springs ? internal.of_spring(member) : internal.of_element(member);
    return own.first + (law.first_state + state) * own.count + place;
  }
  springnet_status find_springs(const HeldState& at, springnet_message& message);
  springnet_status find_elements(const HeldState& at, springnet_message& message);
  [[nodiscard]] PairOutputs outputs(const InternalView* view);

  const Layout& layout_;
  const Evaluator& evaluator_;
  ParameterPiece piece_{};
  const Group* group_ = nullptr;
  const SetsOfGroup* wanted_ = nullptr;
  const ResolvedSets* sets_ = nullptr;
  std::uint32_t members_[max_segment], rows_[max_segment];
  double weight_[2][max_segment];     // axial or of the element, along the relative velocity
  std::vector<double> derivatives_;   // [slot of either law][max_segment]
  std::vector<double*> jacobian_[2];  // of each law; null where not wanted
  double* by_parameters_[2][max_parameters];
  std::unique_ptr<SegmentGeometry> segment_;  // of springs
  std::vector<FirstOrder> elements_;          // of elements
};

template <class Use>
void LawAnswers::for_each_entry(const Use& use) const {
  std::size_t slots_before = 0;
  const std::array<const Law*, 2> laws = group_->laws();
  for (std::size_t k = 0; k < 2; ++k) {
    const SetsOfGroup::OfLaw& own = wanted_->laws[k];
    for (const SetsOfGroup::Entry& entry : own.entries) {
      const ParameterSet& set = sets_->sets()[entry.set];
      const double* const first = derivatives_.data() + (slots_before + entry.slot) * max_segment;
      for (std::size_t i = 0; i < piece_.count; ++i) {
        if (set.kind == ParameterSet::Kind::input &&
            static_cast<std::uint32_t>(group_->columns[entry.signal_column][rows_[i]]) != set.input)
          continue;
        use(*laws[k], entry.set, first, i);
      }
    }
    slots_before += own.slots.size();
  }
}

template <class Use>
void LawAnswers::for_each(const Use& use) const {
  for_each_entry([&](const Law& law, std::uint32_t set, const double* derivative, std::size_t i) {
    use(Answer{set, members_[i], derivative[i], weight_[law.relative ? 1 : 0][i], law.relative});
  });
}

template <class Use>
void LawAnswers::for_each_state(const Use& use) const {
  for_each_entry([&](const Law& law, std::uint32_t set, const double* derivative, std::size_t i) {
    for (std::size_t j = 0; j < law.state_count; ++j)
      use(set, members_[i], internal_place(law, members_[i], j), derivative[(1 + j) * max_segment + i]);
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
