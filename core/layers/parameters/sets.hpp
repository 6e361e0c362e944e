// What forces and accelerations are differentiated by: sets of parameters of springs, elements and nodes, and which
// derivatives of which laws and neurons they need.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "layers/laws.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

struct ParameterSet {
  enum class Kind : std::uint8_t { reference, spring, viscosity, mass, neuron, input, time };
  Kind kind;
  bool of_elements = false;  // reference, spring, viscosity: of elements in place of springs
  std::uint32_t input = 0;   // number of the signal
  std::string component{};   // id of the law or neuron; empty: any
  std::string parameter{};   // its name
  double* values = nullptr;  // [spring], [element], [node] or one, see is_one()

  // Whether it is a single number, which all springs, elements and nodes share.
  [[nodiscard]] bool is_one() const noexcept { return kind == Kind::input || kind == Kind::time; }
};

// Which derivatives of the laws of a group, or of a neuron, which sets need.
class SetsOfGroup {
 public:
  struct Entry {
    std::uint32_t set;
    // Of its law: those of its forces, one for each of its scalars, then those of its states if they are wanted.
    std::uint32_t slot;
    std::uint32_t signal_column = 0;  // sets of an input: the column with each member's signal
    // Sets of references, laws over several scalars: which of the law's scalars this is about; beyond, a component of
    // the direction of the material.
    std::uint32_t scalar = 0;
  };
  // A derivative in the law's Jacobian; or, of the force of a law without one, the number of a parameter.
  struct Slot {
    std::size_t row, column;
    bool is_parameter;
  };
  struct OfLaw {
    std::vector<Slot> slots;
    std::vector<Entry> entries;
  };
  std::array<OfLaw, 2> laws;  // as Group::laws()

  [[nodiscard]] bool empty() const noexcept { return laws[0].entries.empty() && laws[1].entries.empty(); }
};

class ResolvedSets {
 public:
  // with_states: derivatives of internal states (rates, or those at the end of a step) are wanted, too. Throws
  // Error(plugin) if nothing has such a parameter, or a law or neuron does not give the derivatives by it.
  ResolvedSets(const Layout& layout, const std::vector<ParameterSet>& sets, bool with_states);

  [[nodiscard]] const std::vector<ParameterSet>& sets() const noexcept { return sets_; }
  // Of the springs, or elements, of a group.
  [[nodiscard]] const SetsOfGroup& of(std::size_t group, bool elements) const noexcept {
    return (elements ? elements_ : springs_)[group];
  }
  // Of neurons: which scalar of the neuron, for each kind of neuron.
  struct NeuronEntry {
    enum class By : std::uint8_t { mass, time, parameter };
    std::uint32_t set;
    By by;
    std::uint32_t parameter;
  };
  [[nodiscard]] const std::vector<NeuronEntry>& of_neuron(std::size_t kind) const noexcept { return neurons_[kind]; }
  [[nodiscard]] bool with_states() const noexcept { return with_states_; }

 private:
  void resolve_law(std::uint32_t set, const Group& group, std::size_t law, SetsOfGroup& out);
  void resolve_neuron(std::uint32_t set, const NeuronKind& kind, std::vector<NeuronEntry>& out);
  [[noreturn]] void refuse(const ParameterSet& set, const Layout& layout) const;

  std::vector<ParameterSet> sets_;
  std::vector<std::uint8_t> found_;              // [set]
  std::vector<SetsOfGroup> springs_, elements_;  // [group]
  std::vector<std::vector<NeuronEntry>> neurons_;
  bool with_states_;
};

}  // namespace springnet::layers
