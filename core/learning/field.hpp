// Smooth fields: values of many members as polynomials of low order of where the members are.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <springnet/learn.hpp>

namespace springnet::learning {

// m, [member]: where each is at the start: a node, the middle of a spring, the centroid of an element's nodes.
[[nodiscard]] std::vector<Vector3> places_of(const Network& network, const LearnedValues& values);

// Bernstein polynomials of this degree in each direction, multiplied over the three (G. Farin, Curves and Surfaces for
// CAGD, chapter 14), over the box of the places: [place][coefficient]. They are not negative, and their sum is 1, so
// that a field stays between its least and greatest coefficient. In a direction in which there are fewer different
// places than coefficients the degree is lower; 0 where all are at one.
[[nodiscard]] Eigen::MatrixXd bernstein_basis(const std::vector<Vector3>& places, int degree);

}  // namespace springnet::learning
