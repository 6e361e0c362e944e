// Forward sensitivities by CVODES: where a scalar s changes parameters and the start, S = dy/ds goes by
//
//   S' = df/dy S + df/ds
//
// beside the motion, a column for each scalar. The staggered corrector solves for the columns once the motion's own
// step is found, with the same matrix. The error test is that of the motion and of all columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "equations.hpp"
#include "sundials.hpp"

namespace springnet::cvode {

class Sensitivities {
 public:
  explicit Sensitivities(Equations& equations) noexcept : equations_(equations) {}

  // Begins with these columns at the committed state; none: there are no more. CVODE has to be created anew.
  void begin(std::span<const springnet_sensitivity* const> columns, const Context& context);
  [[nodiscard]] bool any() const noexcept { return !columns_.empty(); }
  [[nodiscard]] std::size_t count() const noexcept { return columns_.size(); }

  // Adds the columns to CVODE's memory, as they are now. fixed_point: by functional iteration, without a linear solver.
  void attach(void* memory, bool fixed_point, const Context& context);
  // The same after CVodeReInit.
  void restart(void* memory);
  // Takes them up at a time, s, within the last step.
  void keep(void* memory, double time);
  // Writes a column, 3 node_count numbers each. Throws sdk::Failure if there is none of this number.
  void read(std::uint32_t column, double* position, double* velocity) const;

  // Function for CVODES, as those of Equations.
  int rates(double time, N_Vector y, N_Vector* changes, N_Vector* rates) noexcept;

 private:
  struct Column {
    std::vector<const springnet_parameter_set*> sets;
    double scale;
    Vector change;
  };
  void set_tolerances(void* memory);
  [[nodiscard]] bool is_linearised(double time, N_Vector y) const noexcept;

  Equations& equations_;
  std::vector<Column> columns_;
  std::vector<N_Vector> changes_;  // those of the columns
  NonlinearSolver fixed_point_;
  // Where rates() linearised last, and the number of linearisations then: Newton's method makes others.
  double time_ = std::numeric_limits<double>::quiet_NaN();  // s
  std::vector<double> y_;
  std::uint64_t linearisations_ = 0;
};

}  // namespace springnet::cvode
