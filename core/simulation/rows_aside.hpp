// Keeps the constraint rows of the last linearise() while others are looked at.
#pragma once

#include "constraints/constraint_set.hpp"

namespace springnet {

class RowsAside {
 public:
  explicit RowsAside(ConstraintSet& set) : constraints_(set) { constraints_.exchange(kept_); }
  ~RowsAside() { constraints_.exchange(kept_); }
  RowsAside(const RowsAside&) = delete;
  RowsAside& operator=(const RowsAside&) = delete;

 private:
  ConstraintSet& constraints_;
  ConstraintSet::Linearised kept_{};
};

}  // namespace springnet
