// Error of a run against a reference, record by record.
#pragma once

#include <cstddef>

#include <springnet/simulation.hpp>
#include <springnet/validation.hpp>

namespace springnet {

class ErrorNorm {
 public:
  // Adds the positions of one record, columns in the order of nodes. The start does not count in the rms.
  void add(double time, const ConstNodeMap& positions, const std::vector<std::uint32_t>& columns,
           const ConstNodeMap& reference, const std::vector<std::uint32_t>& reference_columns);
  [[nodiscard]] PositionError result() const;

 private:
  PositionError error_;
  double squares_ = 0.0;  // m^2
  double count_ = 0.0;
};

}  // namespace springnet
