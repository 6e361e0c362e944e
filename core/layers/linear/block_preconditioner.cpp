#include "layers/linear/block_preconditioner.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Dense>

namespace springnet::layers {
namespace {

using Columns = Eigen::Matrix<double, 3, 3>;

// Inverse of the symmetric part, if that is positive definite.
std::optional<Columns> inverse_of(const Columns& block) {
  const Columns symmetric = 0.5 * (block + block.transpose());
  const Eigen::LLT<Columns> factors(symmetric);
  if (factors.info() != Eigen::Success) return std::nullopt;
  const Columns inverse = factors.solve(Columns::Identity());
  if (!inverse.allFinite()) return std::nullopt;
  return Columns(0.5 * (inverse + inverse.transpose()));
}

// A pivot of the factorisation is at least this share of the node's own block, and of its mass, in each of its
// principal directions. A sheet under compression, for example, has negative ones across its plane, where nothing may
// move.
constexpr double min_pivot = 0.3;

// Inverse of the pivot made positive definite; `own` is the node's own block.
Columns inverse_of_pivot(const Columns& pivot, const Columns& own, double mass) {
  const Eigen::SelfAdjointEigenSolver<Columns> modes(0.5 * (pivot + pivot.transpose()));
  Columns inverse = Columns::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Vector3 mode = modes.eigenvectors().col(i);
    const double floor = min_pivot * std::max(std::abs(mode.dot(own * mode)), mass);
    inverse += mode * mode.transpose() / std::max(std::abs(modes.eigenvalues()[i]), floor);
  }
  return inverse;
}

}  // namespace

void BlockPreconditioner::set(const BlockSystem& system, Kind wanted, unsigned threads) {
  invert_blocks(system);
  kind_ = Kind::blocks;
  if (wanted == Kind::blocks) return;
  find_pattern(system);
  const std::size_t n = system.node_count();
  pivots_.resize(9 * n + 1);
  const auto pieces = static_cast<std::int64_t>((n + piece - 1) / piece);
#pragma omp parallel for schedule(dynamic, 1) num_threads(static_cast <int>(threads)) if (threads > 1 && pieces > 1)
  for (std::int64_t p = 0; p < pieces; ++p) {
    const FlushDenormals flush;  // as the calling thread does
    const std::size_t begin = static_cast<std::size_t>(p) * piece;
    factorise(system, {begin, std::min(n, begin + piece)});
  }
  kind_ = Kind::factors;
}

void BlockPreconditioner::invert_blocks(const BlockSystem& system) {
  const std::size_t n = system.node_count();
  inverse_.resize(9 * n + 1);
  const double* values = system.arrays().values;
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Map<const Columns> block(values + 9 * std::size_t{system.own_block(k)});
    const std::optional<Columns> inverse = inverse_of(block);
    Eigen::Map<Columns>(inverse_.data() + 9 * k) =
        inverse ? *inverse : inverse_of_pivot(block, block, system.mass()[k]);
  }
}

void BlockPreconditioner::find_pattern(const BlockSystem& system) {
  const BlockArrays a = system.arrays();
  lower_.clear();
  upper_.clear();
  const auto n = static_cast<std::uint32_t>(system.node_count());
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::size_t begin = k / piece * piece, end = begin + piece;
    for (std::uint32_t b = a.start[k]; b < a.start[k + 1]; ++b) {
      const std::uint32_t other = a.column[b];
      if (other == k || other < begin || other >= end || system.constrained()[k] != 0 ||
          system.constrained()[other] != 0)
        continue;
      Triangle& triangle = other < k ? lower_ : upper_;
      triangle.column.push_back(other);
      triangle.source.push_back(b);
    }
    lower_.start.push_back(static_cast<std::uint32_t>(lower_.column.size()));
    upper_.start.push_back(static_cast<std::uint32_t>(upper_.column.size()));
  }
  lower_.values.resize(9 * lower_.column.size() + 1);
  upper_.values.resize(9 * upper_.column.size() + 1);
}

void BlockPreconditioner::factorise(const BlockSystem& system, NodeRange nodes) {
  const double* from = system.arrays().values;
  const auto copy = [from](Triangle& t, std::size_t b) {
    std::copy_n(from + 9 * std::size_t{t.source[b]}, 9, &t.values[9 * b]);
  };
  const auto block = [](std::vector<double>& values, std::size_t b) { return Eigen::Map<Columns>(&values[9 * b]); };
  constexpr std::uint32_t none = 0xffffffffu;
  // Where the row in work has a block: place in its triangle, by column.
  std::vector<std::uint32_t> place(nodes.end - nodes.begin, none);
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    const std::uint32_t l_begin = lower_.start[k], l_end = lower_.start[k + 1];
    const std::uint32_t u_begin = upper_.start[k], u_end = upper_.start[k + 1];
    for (std::uint32_t b = l_begin; b < l_end; ++b) {
      copy(lower_, b);
      place[lower_.column[b] - nodes.begin] = b;
    }
    for (std::uint32_t b = u_begin; b < u_end; ++b) {
      copy(upper_, b);
      place[upper_.column[b] - nodes.begin] = b;
    }
    const Columns whole = Eigen::Map<const Columns>(from + 9 * std::size_t{system.own_block(k)});
    Columns own = whole;
    for (std::uint32_t b = l_begin; b < l_end; ++b) {
      const std::uint32_t j = lower_.column[b];
      const Columns factor = block(lower_.values, b) * block(pivots_, j);
      block(lower_.values, b) = factor;
      for (std::uint32_t c = upper_.start[j]; c < upper_.start[j + 1]; ++c) {
        const std::size_t column = upper_.column[c];
        if (column == k) {
          own.noalias() -= factor * block(upper_.values, c);
          continue;
        }
        const std::uint32_t at = place[column - nodes.begin];
        if (at == none) continue;
        block(column < k ? lower_.values : upper_.values, at).noalias() -= factor * block(upper_.values, c);
      }
    }
    for (std::uint32_t b = l_begin; b < l_end; ++b) place[lower_.column[b] - nodes.begin] = none;
    for (std::uint32_t b = u_begin; b < u_end; ++b) place[upper_.column[b] - nodes.begin] = none;
    const std::optional<Columns> inverse = inverse_of(own);
    block(pivots_, k) = inverse ? *inverse : inverse_of_pivot(own, whole, system.mass()[k]);
  }
}

void BlockPreconditioner::apply(const BlockKernels& kernels, NodeRange nodes, const double* r, double* z) const {
  if (kind_ == Kind::blocks) {
    kernels.diagonal(inverse_.data(), nodes, r, z);
    return;
  }
  for (std::size_t begin = nodes.begin; begin < nodes.end; begin += piece) {
    const NodeRange rows{begin, std::min(nodes.end, begin + piece)};
    kernels.lower(lower_.arrays(), rows, r, z);
    kernels.upper(upper_.arrays(), pivots_.data(), rows, z);
  }
}

}  // namespace springnet::layers
