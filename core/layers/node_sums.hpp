// Sums over the springs and elements of one node.
#pragma once

#include "layers/block.hpp"
#include "layers/evaluator.hpp"

namespace springnet::layers {

// Null where not wanted.
struct Evaluator::NodeSums {
  Vector3& force;              // N
  Block* stiffness = nullptr;  // N/m
  Block* damping = nullptr;    // N s/m
  double* energy = nullptr;    // J
};

}  // namespace springnet::layers
