// Derivatives of net forces and accelerations by parameters, times a direction or weighted: laws and neurons answer the
// derivatives batch by batch, which are multiplied by the geometry at once and not kept. Sums have one order, whatever
// the number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "layers/evaluator.hpp"
#include "layers/parameters/answers.hpp"
#include "layers/parameters/sets.hpp"

namespace springnet::layers {

// Arrays over the nodes have 3n numbers, x of all nodes first. Statuses and messages are those of laws and neurons.
class ParameterProducts {
 public:
  // They must outlive it.
  ParameterProducts(const Layout& layout, const Evaluator& evaluator) : layout_(layout), evaluator_(evaluator) {}

  // force = dF/d(values) values, N, of all laws; `internal` likewise, if sets are resolved with states.
  springnet_status force_change(const ResolvedSets& sets, const HeldState& at, double* force, double* internal,
                                springnet_message& message);
  // values += (dF/d(values))^T weights, of all laws, and of their states if sets are resolved with them.
  springnet_status weigh_forces(const ResolvedSets& sets, const HeldState& at, const double* weights,
                                const double* internal_weights, springnet_message& message);

  // Of neurons whose net forces are `force`: acceleration = da/dF force_change + da/d(values) values, m/s^2.
  springnet_status acceleration_change(const ResolvedSets& sets, const HeldState& at, const double* force,
                                       const double* force_change, double* acceleration, springnet_message& message);
  // values += (da/d(values))^T weights, force_weights += (da/dF)^T weights.
  springnet_status weigh_accelerations(const ResolvedSets& sets, const HeldState& at, const double* force,
                                       const double* weights, double* force_weights, springnet_message& message);

 private:
  [[nodiscard]] std::vector<ParameterPiece> pieces_of_laws(const ResolvedSets& sets) const;
  [[nodiscard]] std::vector<ParameterPiece> pieces_of_nodes() const;
  // Calls work(number of the piece, answers, message) for each, on several threads.
  template <class Scratch, class Work>
  springnet_status for_each(const std::vector<ParameterPiece>& pieces, springnet_message& message,
                            const Work& work) const;
  void scatter_springs(const HeldState& at, double* force) const;
  void scatter_elements(const HeldState& at, double* force) const;

  const Layout& layout_;
  const Evaluator& evaluator_;
  // Of the last call of force_change: changes of forces along the axis and along the relative velocity, of elements;
  // and on the corners of elements whose laws read several scalars, [slot].
  std::vector<double> axial_, along_, generalised_;
  std::vector<Vector3> corner_change_;
  std::vector<double> ones_;  // [piece][set] partial sums of sets with one number
};

}  // namespace springnet::layers
