// How far the nodes of a run move, record by record.
#pragma once

#include <utility>
#include <vector>

#include <springnet/simulation.hpp>
#include <springnet/validation.hpp>

namespace springnet {

class DisplacementNorm {
 public:
  // Deformation is measured body by body; nodes without a body count as one.
  explicit DisplacementNorm(const Network& network);

  // Positions of one record, nodes in the order of `columns`.
  void add(double time, const ConstNodeMap& positions, const std::vector<std::uint32_t>& columns);
  [[nodiscard]] const Displacement& result() const { return result_; }

 private:
  std::vector<Vector3> start_;                // [node], m
  std::vector<std::vector<NodeIndex>> sets_;  // the nodes of each body
  Displacement result_;
};

}  // namespace springnet
