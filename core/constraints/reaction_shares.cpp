// Shares of several surfaces in the reaction of a node.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "constraints/island.hpp"
#include "constraints/least_squares.hpp"

namespace springnet {

bool surfaces_move_alike(const ContactNode& node, double negligible) {
  const ContactSide* first = nullptr;
  for (const ContactSide& side : node.sides) {
    if (!side.active) continue;
    if (first != nullptr && (side.velocity - first->velocity).norm() > negligible) return false;
    if (first == nullptr) first = &side;
  }
  return true;
}

SplitReaction split_reaction(const std::vector<Vector3>& normals, const Vector3& reaction) {
  SplitReaction result;
  if (normals.size() == 1) {
    const double pressing = normals[0].dot(reaction);
    return {{pressing}, reaction - pressing * normals[0]};
  }
  Eigen::MatrixXd n(3, static_cast<Eigen::Index>(normals.size()));
  for (std::size_t i = 0; i < normals.size(); ++i) n.col(static_cast<Eigen::Index>(i)) = normals[i];
  const Eigen::VectorXd shares = least_squares(n, reaction);
  result.normal.assign(shares.begin(), shares.end());
  result.tangential = reaction - n * shares;
  return result;
}

std::vector<std::size_t> pressing_surfaces(const std::vector<Vector3>& normals, const Vector3& reaction) {
  const double rounding = 1e-12 * reaction.norm();
  std::vector<std::size_t> best;
  double least = std::numeric_limits<double>::infinity();  // tangential rest
  const unsigned all = (1u << normals.size()) - 1;
  for (unsigned set = all; set > 0; --set) {
    std::vector<std::size_t> chosen;
    std::vector<Vector3> some;
    for (std::size_t i = 0; i < normals.size(); ++i) {
      if ((set >> i & 1u) == 0) continue;
      chosen.push_back(i);
      some.push_back(normals[i]);
    }
    const SplitReaction split = split_reaction(some, reaction);
    if (*std::min_element(split.normal.begin(), split.normal.end()) < -rounding) continue;
    if (set == all) return chosen;
    if (split.tangential.norm() >= least) continue;
    least = split.tangential.norm();
    best = chosen;
  }
  return best;
}

std::vector<Vector3> share_reaction(const std::vector<Vector3>& normals, const std::vector<double>& coefficients,
                                    const Vector3& reaction) {
  if (normals.size() == 1) return {reaction};
  std::vector<std::size_t> pressing = pressing_surfaces(normals, reaction);
  for (std::size_t i = 0; pressing.empty() && i < normals.size(); ++i) pressing.push_back(i);  // all of them pull
  std::vector<Vector3> some;
  for (const std::size_t i : pressing) some.push_back(normals[i]);
  const SplitReaction split = split_reaction(some, reaction);
  std::vector<Vector3> result(normals.size(), Vector3::Zero());
  std::vector<double> limits;
  double all = 0.0;
  for (std::size_t s = 0; s < some.size(); ++s) {
    result[pressing[s]] = split.normal[s] * some[s];
    limits.push_back(coefficients[pressing[s]] * std::max(0.0, split.normal[s]));
    all += limits.back();
  }
  if (all == 0.0) result[pressing[0]] += split.tangential;  // rounding
  for (std::size_t s = 0; s < some.size() && all > 0.0; ++s) result[pressing[s]] += limits[s] / all * split.tangential;
  return result;
}

}  // namespace springnet
