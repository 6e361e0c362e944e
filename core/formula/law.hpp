// A law given by formulas: its programs, and their run for a batch of the plugin ABI.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <springnet/formula.hpp>
#include <springnet/sdk/metadata.hpp>
#include <springnet/sdk/table.hpp>

#include "formula/program.hpp"
#include "formula/symbols.hpp"

namespace springnet::formula {

// As layers have room for.
inline constexpr std::size_t max_parameters = 32, max_inputs = 8;
// Of a law with states (state_steps.cpp).
inline constexpr std::size_t max_states = 2, max_parameters_beside_states = 8, max_inputs_beside_states = 2;

// The typical magnitude that a component declares.
[[nodiscard]] double scale_of(const FormulaSymbol& symbol);
[[nodiscard]] double scale_of(const FormulaState& state);

class Law {
 public:
  // Throws Error(input), see component_of().
  explicit Law(const LawFormula& law);
  Law(const Law&) = delete;
  Law& operator=(const Law&) = delete;

  [[nodiscard]] const Reads& reads() const { return reads_; }
  [[nodiscard]] bool has_energy() const { return energy_.rows == 1; }
  [[nodiscard]] bool has_margin() const { return margin_.rows == 1; }
  [[nodiscard]] const sdk::JacobianLayout& layout() const { return layout_; }
  [[nodiscard]] const Curves& curves() const { return curves_; }
  // Bounds and scale of each state.
  [[nodiscard]] const std::vector<sdk::Parameter>& states() const { return states_; }
  // As lists of steps: outputs are the force, the energy, the margin, or the rates of all states.
  [[nodiscard]] const Program& force() const { return force_.values; }
  [[nodiscard]] const Program& energy() const { return energy_.values; }
  [[nodiscard]] const Program& margin() const { return margin_.values; }
  [[nodiscard]] const Program& rates() const { return rates_.values; }
  // springnet_law::evaluate.
  void evaluate(const springnet_law_batch& batch) const;
  // springnet_law::update. False: no state satisfies the equation of its step.
  [[nodiscard]] bool update(const springnet_law_update& update) const;

 private:
  // Forces, the energy or the margin, with their derivatives by the law's arguments, four at a time of one kind.
  struct Columns {
    std::size_t first, count;
    Program program;  // outputs: [row][count]
  };
  struct Quantity {
    std::size_t rows = 0;
    Program values;   // [row]
    Program tangent;  // of forces: [row], then [row][column]
    std::vector<Columns> columns;
  };
  class CurvesOf final : public Curves {
   public:
    explicit CurvesOf(const std::vector<FormulaCurve>& curves);
    void evaluate(std::uint32_t table, unsigned order, const double* x, double* out, std::size_t count) const override;

   private:
    std::vector<sdk::MonotoneCubic> curves_;
  };
  struct Arguments;

  template <class Values>
  Quantity quantity(std::size_t rows, std::size_t tangent_columns, const Values& values) const;
  [[nodiscard]] bool is_often_same(std::uint32_t column) const;
  template <class To>
  void run_columns(const Quantity& quantity, const Batch& batch, std::size_t first, const To& to) const;

  sdk::JacobianLayout layout_{};
  bool several_ = false;
  std::size_t tangent_columns_ = 1;
  Reads reads_;
  std::vector<sdk::Parameter> states_;
  bool smooth_rates_ = false;
  CurvesOf curves_;
  Quantity force_, energy_, margin_, rates_;
};

}  // namespace springnet::formula
