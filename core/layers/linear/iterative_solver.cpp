#include "layers/linear/iterative_solver.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "layers/linear/bicgstab.hpp"

namespace springnet::layers {
namespace {

// From this many blocks on threads pay off.
constexpr std::size_t blocks_worth_threads = 20000;
// Rank-one terms beyond this many are left to the other parts of the preconditioner.
constexpr std::size_t max_terms = 48;
constexpr std::size_t vectors = 6;

// Of g w^T, for w = stiffness g: comparable among enclosures and drags, whose g have other units.
double strength_of(const BlockSystem::RankOne& term) {
  double square = 0.0;
  for (const Vector3& g : term.g) square += g.squaredNorm();
  return term.stiffness * square;
}

}  // namespace

NodeRange IterativeSolver::chunk_nodes(std::size_t index) const noexcept {
  return {index * chunk, std::min(nodes_, (index + 1) * chunk)};
}

NodeRange IterativeSolver::nodes_of(const Team& team) const noexcept {
  const NodeRange chunks = team.share(chunk_count());
  return {std::min(nodes_, chunks.begin * chunk), std::min(nodes_, chunks.end * chunk)};
}

NodeRange IterativeSolver::pieces_of(const Team& team) const noexcept {
  constexpr std::size_t piece = BlockPreconditioner::piece;
  const NodeRange pieces = team.share((nodes_ + piece - 1) / piece);
  return {std::min(nodes_, pieces.begin * piece), std::min(nodes_, pieces.end * piece)};
}

void IterativeSolver::prepare(const BlockSystem& system, BlockPreconditioner::Kind kind,
                              const std::array<const double*, 3>& position, const MakeProjection& make_projection) {
  nodes_ = system.node_count();
  preconditioner_.set(system, kind, threads_);
  projection_ = make_projection(preconditioner_.inverse_blocks());
  if (projection_.impulse) impulses_.resize(3 * nodes_ + 1);
  if (projection_.reactions) balanced_.resize(3 * nodes_ + 1);
  inverse_mass_.resize(nodes_);
  for (std::size_t k = 0; k < nodes_; ++k) inverse_mass_[k] = 1.0 / system.mass()[k];
  work_.resize(vectors);
  for (auto& values : work_) values.resize(3 * nodes_ + 1);
  sum_.resize(chunk_count());
  prepare_coarse(system, position);
  prepare_terms(system);
}

void IterativeSolver::prepare_coarse(const BlockSystem& system, const std::array<const double*, 3>& position) {
  coarse_.clear();
  if (preconditioner_.kind() != BlockPreconditioner::Kind::blocks) return;
  const BlockArrays arrays = system.arrays();
  const auto block = [&](std::size_t b) { return Eigen::Map<const Eigen::Matrix3d>(arrays.values + 9 * b); };
  double stiffness = 0.0, inertia = 0.0;
  for (std::size_t k = 0; k < nodes_; ++k) {
    if (system.constrained()[k] != 0) continue;
    stiffness += block(system.own_block(k)).trace();
    inertia += 3.0 * system.mass()[k];
  }
  if (!CoarseSpace::pays(nodes_, stiffness / inertia, false)) return;
  coarse_.begin(position, system.constrained());
  for (std::size_t k = 0; k < nodes_; ++k)
    for (std::uint32_t b = arrays.start[k]; b < arrays.start[k + 1]; ++b)
      coarse_.add_block(k, arrays.column[b], block(b));
  coarse_.factorise();
}

void IterativeSolver::prepare_terms(const BlockSystem& system) {
  terms_.clear();
  for (const BlockSystem::RankOne& term : system.terms())
    if (term.stiffness > 0.0 && !term.nodes.empty()) terms_.push_back(&term);
  if (terms_.size() > max_terms) {
    std::stable_sort(terms_.begin(), terms_.end(),
                     [&](const auto* a, const auto* b) { return strength_of(*a) > strength_of(*b); });
    terms_.resize(max_terms);
  }
  std::vector<const BlockSystem::RankOne*> all;
  std::swap(all, terms_);  // B without them
  Team alone(1, 0);
  std::vector<double> g(3 * nodes_ + 1);
  z_.resize(all.size());
  for (std::size_t s = 0; s < all.size(); ++s) {
    std::fill(g.begin(), g.end(), 0.0);
    for (std::size_t i = 0; i < all[s]->nodes.size(); ++i)
      for (Eigen::Index c = 0; c < 3; ++c) g[3 * all[s]->nodes[i] + static_cast<std::size_t>(c)] = all[s]->g[i][c];
    z_[s].resize(3 * nodes_ + 1);
    precondition(alone, g.data(), z_[s].data());
  }
  terms_ = std::move(all);
  const auto count = static_cast<Eigen::Index>(terms_.size());
  Eigen::MatrixXd small(count, count);
  for (Eigen::Index s = 0; s < count; ++s) {
    const BlockSystem::RankOne& term = *terms_[static_cast<std::size_t>(s)];
    for (Eigen::Index t = 0; t < count; ++t) {
      const std::vector<double>& z = z_[static_cast<std::size_t>(t)];
      double value = s == t ? 1.0 / term.stiffness : 0.0;
      for (std::size_t i = 0; i < term.nodes.size(); ++i)
        value += term.g[i].dot(Eigen::Map<const Vector3>(&z[3 * std::size_t{term.nodes[i]}]));
      small(s, t) = value;
    }
  }
  if (count > 0) small_.compute(0.5 * (small + small.transpose()));
  if (count > 0 && (small_.info() != Eigen::Success || !small_.isPositive())) terms_.clear();
}

void IterativeSolver::correct(double* z) const {
  Eigen::VectorXd share(static_cast<Eigen::Index>(terms_.size()));
  for (std::size_t s = 0; s < terms_.size(); ++s) {
    double value = 0.0;
    for (std::size_t i = 0; i < terms_[s]->nodes.size(); ++i)
      value += terms_[s]->g[i].dot(Eigen::Map<const Vector3>(z + 3 * std::size_t{terms_[s]->nodes[i]}));
    share[static_cast<Eigen::Index>(s)] = value;
  }
  share = small_.solve(share);
  for (std::size_t s = 0; s < terms_.size(); ++s)
    kernels_.add(-share[static_cast<Eigen::Index>(s)], z_[s].data(), {0, nodes_}, z);
}

double IterativeSolver::dot(Team& team, const double* a, const double* b) {
  return sum_(team, team.share(chunk_count()), [&](std::size_t c) { return kernels_.dot(a, b, chunk_nodes(c)); });
}

double IterativeSolver::square(Team& team, const double* r, double along) {
  if (projection_.change) return along;
  return sum_(team, team.share(chunk_count()),
              [&](std::size_t c) { return kernels_.square(inverse_mass_.data(), r, chunk_nodes(c)); });
}

Sums2 IterativeSolver::update(Team& team, double step, const double* p, const double* q, double* x, double* r,
                              double* z) {
  const bool local = preconditioner_.kind() == BlockPreconditioner::Kind::blocks && !projection_.change &&
                     terms_.empty() && !coarse_.any();
  if (!local) {
    add(team, step, p, x);
    add(team, -step, q, r);
    precondition(team, r, z);
  }
  const Sums2 sums = sum_.two(team, team.share(chunk_count()), [&](std::size_t c) -> Sums2 {
    const NodeRange nodes = chunk_nodes(c);
    if (local) {
      kernels_.add(step, p, nodes, x);
      kernels_.add(-step, q, nodes, r);
      preconditioner_.apply(kernels_, nodes, r, z);
    }
    return {kernels_.dot(r, z, nodes), kernels_.square(inverse_mass_.data(), r, nodes)};
  });
  return {sums.first, projection_.change ? sums.first : sums.second};
}

void IterativeSolver::copy(Team& team, const double* x, double* y) {
  const NodeRange own = nodes_of(team);
  std::copy(x + 3 * own.begin, x + 3 * own.end, y + 3 * own.begin);
}

void IterativeSolver::zero(Team& team, double* x) {
  const NodeRange own = nodes_of(team);
  std::fill(x + 3 * own.begin, x + 3 * own.end, 0.0);
}

void IterativeSolver::product(Team& team, const double* p, double* q) {
  kernels_.product(system_->arrays(), nodes_of(team), p, q);
  if (system_->terms().empty()) return;
  team.alone([&] {
    for (const BlockSystem::RankOne& term : system_->terms()) {
      double share = 0.0;
      for (std::size_t i = 0; i < term.nodes.size(); ++i)
        share += term.w[i].dot(Eigen::Map<const Vector3>(p + 3 * std::size_t{term.nodes[i]}));
      for (std::size_t i = 0; i < term.nodes.size(); ++i)
        Eigen::Map<Vector3>(q + 3 * std::size_t{term.nodes[i]}) += share * term.g[i];
    }
  });
}

void IterativeSolver::precondition(Team& team, const double* r, double* z) {
  const bool constrained = projection_.change != nullptr;
  if (projection_.reactions) {  // one thread
    std::copy(r, r + 3 * nodes_, balanced_.begin());
    projection_.reactions(balanced_.data());
    r = balanced_.data();
  }
  if (preconditioner_.kind() == BlockPreconditioner::Kind::blocks) {
    // Q^T may be left out: Q W = W Q^T, and Q Q = Q.
    preconditioner_.apply(kernels_, nodes_of(team), r, z);
  } else {
    team.barrier();
    if (constrained) {  // one thread
      std::copy(r, r + 3 * nodes_, impulses_.begin());
      projection_.impulse(impulses_.data());
    }
    preconditioner_.apply(kernels_, pieces_of(team), constrained ? impulses_.data() : r, z);
    team.barrier();
  }
  if (!constrained && terms_.empty() && !coarse_.any()) return;
  team.alone([&] {
    if (coarse_.any()) add_coarse(r, z);
    if (constrained) projection_.change(z);
    if (!terms_.empty()) correct(z);
  });
}

void IterativeSolver::add_coarse(const double* r, double* z) {
  if (projection_.impulse) {
    std::copy(r, r + 3 * nodes_, impulses_.begin());
    projection_.impulse(impulses_.data());
    r = impulses_.data();
  }
  static_cast<void>(coarse_.correct<3>(r, z));
}

SolveAnswer IterativeSolver::solve(const BlockSystem& system, bool symmetric, double accuracy,
                                   std::uint32_t max_iterations, const std::vector<double>& b, std::vector<double>& x) {
  system_ = &system;
  SolveAnswer answer;
  // Projections are not for threads.
  const bool threaded = system.block_count() >= blocks_worth_threads && !projection_.change;
  const unsigned threads = threaded ? threads_ : 1;
  const auto run = [&](unsigned count, unsigned me) {
    const FlushDenormals flush;
    Team team(count, me);
    double* const work[4] = {work_[0].data(), work_[1].data(), work_[2].data(), work_[3].data()};
    const SolveAnswer own = symmetric ? conjugate_gradients(*this, team, accuracy, max_iterations, b.data(), x.data(),
                                                            work[0], work[1], work[2], work[3])
                                      : solve_unsymmetric(team, accuracy, max_iterations, b.data(), x.data());
    if (me == 0) answer = own;
  };
  if (threads <= 1) {
    run(1, 0);
    return answer;
  }
#pragma omp parallel num_threads(static_cast <int>(threads))
  run(static_cast<unsigned>(omp_get_num_threads()), static_cast<unsigned>(omp_get_thread_num()));
  return answer;
}

SolveAnswer IterativeSolver::solve_unsymmetric(Team& team, double accuracy, std::uint32_t max_iterations,
                                               const double* b, double* x) {
  // What the accuracy is of: constraint forces are in a residual until it is preconditioned.
  const auto residual = [&]() -> std::optional<double> {
    if (projection_.change) return std::nullopt;
    const auto square_of = [&](const double* values) {
      return sum_(team, team.share(chunk_count()),
                  [&](std::size_t c) { return kernels_.square(inverse_mass_.data(), values, chunk_nodes(c)); });
    };
    double *product_of_x = work_[5].data(), *left = work_[4].data();
    team.barrier();
    product(team, x, product_of_x);
    copy(team, b, left);
    add(team, -1.0, product_of_x, left);
    const double square_left = square_of(left), all = square_of(b);
    return std::sqrt(square_left / all);
  };
  std::array<double*, 6> work{};
  for (std::size_t i = 0; i < work.size(); ++i) work[i] = work_[i].data();
  return bicgstab(*this, team, accuracy, max_iterations, b, x, work, residual);
}

double IterativeSolver::mass_square(Team& team, const double* r) {
  return sum_(team, team.share(chunk_count()),
              [&](std::size_t c) { return kernels_.square(system_->mass().data(), r, chunk_nodes(c)); });
}

}  // namespace springnet::layers
