// Random numbers, vectors and rotations.
#pragma once

#include <random>

#include <Eigen/Geometry>

#include <springnet/network.hpp>

namespace springnet::testing {

class Dice {
 public:
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector3 vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  Matrix3 rotation() { return Eigen::AngleAxisd(number(-3.0, 3.0), vector(1.0).normalized()).toRotationMatrix(); }

 private:
  std::mt19937 random_{11};
};

}  // namespace springnet::testing
