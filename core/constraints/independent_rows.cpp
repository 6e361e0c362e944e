#include "constraints/independent_rows.hpp"

#include <cmath>
#include <cstdint>
#include <map>

#include <Eigen/Core>

#include "constraints/row_groups.hpp"

namespace springnet {
namespace {

constexpr std::size_t most_rows = 2000;
constexpr double implied = 1e-8;  // square of what is left of a row

// G W G^T of some rows.
Eigen::MatrixXd gram_matrix(const std::vector<ConstraintRow>& rows, const std::vector<std::uint32_t>& group,
                            const std::vector<double>& mobility) {
  struct End {
    Eigen::Index row;
    double weight;
  };
  std::map<std::uint32_t, std::vector<End>> ends;
  for (std::size_t g = 0; g < group.size(); ++g)
    rows[group[g]].for_each_end([&](std::size_t, std::uint32_t node, double weight) {
      if (mobility[node] > 0.0) ends[node].push_back({static_cast<Eigen::Index>(g), weight});
    });
  const auto count = static_cast<Eigen::Index>(group.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(count, count);
  for (const auto& [node, of_node] : ends)
    for (const End& a : of_node)
      for (const End& b : of_node)
        result(a.row, b.row) += a.weight * b.weight * mobility[node] *
                                rows[group[static_cast<std::size_t>(a.row)]].direction.dot(
                                    rows[group[static_cast<std::size_t>(b.row)]].direction);
  return result;
}

// Marks those that are not implied: Cholesky factors with pivots, as far as these are no rounding.
void mark(const std::vector<ConstraintRow>& rows, const std::vector<std::uint32_t>& group,
          const std::vector<double>& mobility, std::vector<std::uint8_t>& kept) {
  const Eigen::MatrixXd all = gram_matrix(rows, group, mobility);
  const Eigen::Index count = all.rows();
  Eigen::VectorXd left = all.diagonal(), share(count);
  Eigen::MatrixXd factors(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index g = 0; g < count; ++g)
      share[g] = kept[group[static_cast<std::size_t>(g)]] != 0 || !(all(g, g) > 0.0) ? 0.0 : left[g] / all(g, g);
    Eigen::Index pivot = 0;
    if (!(share.maxCoeff(&pivot) > implied)) break;
    kept[group[static_cast<std::size_t>(pivot)]] = 1;
    factors.col(i) = all.col(pivot) - factors.leftCols(i) * factors.row(pivot).head(i).transpose();
    factors.col(i) /= std::sqrt(left[pivot]);
    left -= factors.col(i).cwiseAbs2();
  }
}

}  // namespace

std::vector<ConstraintRow> independent_rows(std::vector<ConstraintRow> rows, const std::vector<double>& mobility) {
  RowGroups groups(rows.size());
  for (std::uint32_t r = 0; r < rows.size(); ++r)
    rows[r].for_each_end([&](std::size_t, std::uint32_t node, double) {
      if (mobility[node] > 0.0) groups.connect(r, {false, node});
    });
  std::vector<std::uint8_t> kept(rows.size(), 0);
  for (const std::vector<std::uint32_t>& group : groups.groups()) {
    if (group.size() > most_rows)
      for (const std::uint32_t r : group) kept[r] = 1;
    else
      mark(rows, group, mobility, kept);
  }
  std::vector<ConstraintRow> result;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (kept[r] != 0) result.push_back(rows[r]);
  return result;
}

}  // namespace springnet
