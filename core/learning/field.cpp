#include "learning/field.hpp"

#include <algorithm>
#include <cmath>

namespace springnet::learning {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double same_place = 1e-6;  // of the greatest extent: lattices have places that rounding tells apart

// Of a place at a share of the extent, 0 to 1; by de Casteljau's recursion.
VectorXd bernstein(double share, int degree) {
  VectorXd result = VectorXd::Zero(degree + 1);
  result[0] = 1.0;
  for (int d = 1; d <= degree; ++d) {
    for (int k = d; k > 0; --k) result[k] = (1.0 - share) * result[k] + share * result[k - 1];
    result[0] *= 1.0 - share;
  }
  return result;
}

}  // namespace

std::vector<Vector3> places_of(const Network& network, const LearnedValues& values) {
  const std::vector<Vector3>& nodes = network.nodes().positions();
  const bool is_of_nodes = member_name(values.kind, values.of_elements) == "node";
  std::vector<Vector3> result;
  result.reserve(values.members.size());
  for (const std::uint32_t member : values.members) {
    if (is_of_nodes) {
      result.push_back(nodes[member]);
    } else if (!values.of_elements) {
      const SpringList::Ends& ends = network.springs().ends()[member];
      result.emplace_back(0.5 * (nodes[ends[0]] + nodes[ends[1]]));
    } else {
      std::vector<NodeIndex> own = network.elements()[member].nodes;  // of closed surfaces each several times
      std::sort(own.begin(), own.end());
      own.erase(std::unique(own.begin(), own.end()), own.end());
      Vector3 sum = Vector3::Zero();
      for (const NodeIndex node : own) sum += nodes[node];
      result.emplace_back(sum / static_cast<double>(own.size()));
    }
  }
  return result;
}

MatrixXd bernstein_basis(const std::vector<Vector3>& places, int degree) {
  const auto count = static_cast<Eigen::Index>(places.size());
  if (places.empty()) return {};
  Vector3 least = places.front(), greatest = places.front();
  for (const Vector3& each : places) {
    least = least.cwiseMin(each);
    greatest = greatest.cwiseMax(each);
  }
  const Vector3 extent = greatest - least;
  const double tolerance = same_place * extent.maxCoeff();
  MatrixXd result = MatrixXd::Ones(count, 1);
  for (int axis = 2; axis >= 0; --axis) {  // coefficients along x are next to each other
    std::vector<double> along;
    for (const Vector3& each : places) along.push_back(each[axis]);
    std::sort(along.begin(), along.end());
    int different = 1;
    double last = along.front();
    for (const double each : along) {
      if (!(each - last > tolerance)) continue;
      ++different;
      last = each;
    }
    const int own = std::min(degree, different - 1);
    if (own == 0) continue;
    MatrixXd next(count, result.cols() * (own + 1));
    for (Eigen::Index k = 0; k < count; ++k) {
      const double share = (places[static_cast<std::size_t>(k)][axis] - least[axis]) / extent[axis];
      const VectorXd factors = bernstein(std::clamp(share, 0.0, 1.0), own);
      for (Eigen::Index c = 0; c < result.cols(); ++c)
        next.row(k).segment(c * (own + 1), own + 1) = result(k, c) * factors.transpose();
    }
    result = std::move(next);
  }
  return result;
}

}  // namespace springnet::learning
