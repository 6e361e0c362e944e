#include "layers/linear/iterative_solver.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>

namespace springnet::layers {
namespace {

// From this many blocks on threads pay off.
constexpr std::size_t blocks_worth_threads = 20000;
// Enclosures beyond this many are left to the other parts of the preconditioner.
constexpr std::size_t max_terms = 48;
constexpr std::size_t slots = 4;
constexpr std::size_t vectors = 8;

}  // namespace

// A thread's share of the work. Threads run the same code; where one reads what another one wrote, there is a barrier.
struct IterativeSolver::Team {
  unsigned count = 1, me = 0;
  NodeRange nodes{0, 0};   // whole chunks
  NodeRange pieces{0, 0};  // nodes of whole pieces of the preconditioner
  std::size_t slot = 0;

  Team(unsigned threads, unsigned index, std::size_t node_count) : count(threads), me(index) {
    nodes = share(node_count, chunk);
    pieces = share(node_count, BlockPreconditioner::piece);
  }
  void barrier() const {
    if (count > 1) {
#pragma omp barrier
    }
  }
  // `action` by one thread alone, between barriers.
  template <class Action>
  void alone(const Action& action) const {
    barrier();
    if (me == 0) action();
    barrier();
  }

 private:
  [[nodiscard]] NodeRange share(std::size_t node_count, std::size_t unit) const {
    const std::size_t units = (node_count + unit - 1) / unit;
    return {std::min(node_count, units * me / count * unit), std::min(node_count, units * (me + 1) / count * unit)};
  }
};

void IterativeSolver::prepare(const BlockSystem& system, BlockPreconditioner::Kind kind,
                              const MakeProjection& make_projection) {
  nodes_ = system.node_count();
  preconditioner_.set(system, kind, threads_);
  projection_ = make_projection(preconditioner_.inverse_blocks());
  if (projection_.impulse) impulses_.resize(3 * nodes_ + 1);
  inverse_mass_.resize(nodes_);
  for (std::size_t k = 0; k < nodes_; ++k) inverse_mass_[k] = 1.0 / system.mass()[k];
  work_.resize(vectors);
  for (auto& values : work_) values.resize(3 * nodes_ + 1);
  partial_.resize(slots * ((nodes_ + chunk - 1) / chunk));
  prepare_enclosures(system);
}

void IterativeSolver::prepare_enclosures(const BlockSystem& system) {
  terms_.clear();
  for (const BlockSystem::RankOne& term : system.enclosures())
    if (term.stiffness > 0.0 && !term.nodes.empty()) terms_.push_back(&term);
  if (terms_.size() > max_terms) {
    std::stable_sort(terms_.begin(), terms_.end(),
                     [](const auto* a, const auto* b) { return a->stiffness > b->stiffness; });
    terms_.resize(max_terms);
  }
  std::vector<const BlockSystem::RankOne*> all;
  std::swap(all, terms_);  // B without enclosures
  Team alone(1, 0, nodes_);
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

template <class Part>
double IterativeSolver::sum(Team& team, const Part& part) {
  const std::size_t chunks = (nodes_ + chunk - 1) / chunk;
  double* own = partial_.data() + team.slot * chunks;
  team.slot = (team.slot + 1) % slots;
  for (std::size_t begin = team.nodes.begin; begin < team.nodes.end; begin += chunk)
    own[begin / chunk] = part(NodeRange{begin, std::min(team.nodes.end, begin + chunk)});
  team.barrier();
  double total = 0.0;
  for (std::size_t c = 0; c < chunks; ++c) total += own[c];
  return total;
}

void IterativeSolver::product(Team& team, const BlockSystem& system, const double* p, double* q) {
  kernels_.product(system.arrays(), team.nodes, p, q);
  if (system.enclosures().empty()) return;
  team.alone([&] {
    for (const BlockSystem::RankOne& term : system.enclosures()) {
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
  if (preconditioner_.kind() == BlockPreconditioner::Kind::blocks) {
    // Q^T may be left out: Q W = W Q^T, and Q Q = Q.
    preconditioner_.apply(kernels_, team.nodes, r, z);
  } else {
    team.barrier();
    if (constrained) {  // one thread
      std::copy(r, r + 3 * nodes_, impulses_.begin());
      projection_.impulse(impulses_.data());
    }
    preconditioner_.apply(kernels_, team.pieces, constrained ? impulses_.data() : r, z);
    team.barrier();
  }
  if (!constrained && terms_.empty()) return;
  team.alone([&] {
    if (constrained) projection_.change(z);
    if (!terms_.empty()) correct(z);
  });
}

IterativeSolver::Answer IterativeSolver::solve(const BlockSystem& system, bool symmetric, double accuracy,
                                               std::uint32_t max_iterations, const std::vector<double>& b,
                                               std::vector<double>& x) {
  Answer answer;
  // Projections are not for threads.
  const bool threaded = system.block_count() >= blocks_worth_threads && !projection_.change;
  const unsigned threads = threaded ? threads_ : 1;
  const auto run = [&](unsigned count, unsigned me) {
    const FlushDenormals flush;
    Team team(count, me, nodes_);
    const Answer own = symmetric ? conjugate_gradients(team, system, accuracy, max_iterations, b.data(), x.data())
                                 : bicgstab(team, system, accuracy, max_iterations, b.data(), x.data());
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

IterativeSolver::Answer IterativeSolver::conjugate_gradients(Team& team, const BlockSystem& system, double accuracy,
                                                             std::uint32_t max_iterations, const double* b, double* x) {
  double *r = work_[0].data(), *z = work_[1].data(), *p = work_[2].data(), *q = work_[3].data();
  const NodeRange own = team.nodes;
  const auto square = [&](double along) {
    if (projection_.change) return along;
    return sum(team, [&](NodeRange range) { return kernels_.square(inverse_mass_.data(), r, range); });
  };
  std::copy(b + 3 * own.begin, b + 3 * own.end, r + 3 * own.begin);
  std::fill(x + 3 * own.begin, x + 3 * own.end, 0.0);
  precondition(team, r, z);
  std::copy(z + 3 * own.begin, z + 3 * own.end, p + 3 * own.begin);
  double along = sum(team, [&](NodeRange range) { return kernels_.dot(r, z, range); });
  const double first = square(along);
  Answer answer;
  if (first == 0.0) {
    answer.outcome = Outcome::solved;
    answer.residual = 0.0;
    return answer;
  }
  if (!std::isfinite(first) || !(along > 0.0)) return answer;
  while (answer.iterations < max_iterations) {
    product(team, system, p, q);
    const double curvature = sum(team, [&](NodeRange range) { return kernels_.dot(p, q, range); });
    if (!std::isfinite(curvature)) return answer;
    if (!(curvature > 0.0)) {
      answer.outcome = Outcome::truncated;
      return answer;
    }
    const double step = along / curvature;
    kernels_.add(step, p, own, x);
    kernels_.add(-step, q, own, r);
    precondition(team, r, z);
    const double next = sum(team, [&](NodeRange range) { return kernels_.dot(r, z, range); });
    const double left = square(next);
    ++answer.iterations;
    answer.residual = std::sqrt(std::max(0.0, left) / first);
    if (!std::isfinite(answer.residual)) return answer;
    if (answer.residual <= accuracy || !(next > 0.0)) {
      answer.outcome = answer.residual <= accuracy ? Outcome::solved : Outcome::stalled;
      return answer;
    }
    kernels_.scale_add(next / along, z, own, p);
    along = next;
    team.barrier();
  }
  return answer;
}

// van der Vorst 1992, preconditioned from the left: every vector is a change that the constraints allow.
IterativeSolver::Answer IterativeSolver::bicgstab(Team& team, const BlockSystem& system, double accuracy,
                                                  std::uint32_t max_iterations, const double* b, double* x) {
  double *r = work_[0].data(), *shadow = work_[1].data(), *p = work_[2].data(), *v = work_[3].data(),
         *t = work_[4].data(), *q = work_[5].data(), *right = work_[6].data();
  const NodeRange own = team.nodes;
  const double* mass = system.mass().data();
  const auto dot = [&](const double* a, const double* c) {
    return sum(team, [&](NodeRange range) { return kernels_.dot(a, c, range); });
  };
  const auto apply = [&](const double* from, double* to) {
    product(team, system, from, q);
    precondition(team, q, to);
  };
  const auto copy = [&](const double* from, double* to) {
    std::copy(from + 3 * own.begin, from + 3 * own.end, to + 3 * own.begin);
  };
  const auto norm = [&] { return sum(team, [&](NodeRange range) { return kernels_.square(mass, r, range); }); };
  copy(b, right);
  std::fill(x + 3 * own.begin, x + 3 * own.end, 0.0);
  precondition(team, right, r);
  copy(r, shadow);
  copy(r, p);
  Answer answer;
  const double first = norm();
  if (first == 0.0) {
    answer.outcome = Outcome::solved;
    answer.residual = 0.0;
    return answer;
  }
  if (!std::isfinite(first)) return answer;
  double rho = dot(shadow, r);
  while (answer.iterations < max_iterations) {
    apply(p, v);
    const double alpha = rho / dot(shadow, v);
    if (!std::isfinite(alpha)) return answer;
    kernels_.add(alpha, p, own, x);
    kernels_.add(-alpha, v, own, r);  // s
    team.barrier();
    apply(r, t);
    const double tt = dot(t, t), ts = dot(t, r);
    const double omega = tt > 0.0 ? ts / tt : 0.0;
    kernels_.add(omega, r, own, x);
    kernels_.add(-omega, t, own, r);
    ++answer.iterations;
    answer.residual = std::sqrt(norm() / first);
    if (!std::isfinite(answer.residual)) return answer;
    if (answer.residual <= accuracy) {
      answer.outcome = Outcome::solved;
      return answer;
    }
    const double next = dot(shadow, r);
    const double beta = next / rho * (alpha / omega);
    if (!std::isfinite(beta) || omega == 0.0) return answer;
    rho = next;
    kernels_.add(-omega, v, own, p);
    kernels_.scale_add(beta, r, own, p);
    team.barrier();
  }
  return answer;
}

}  // namespace springnet::layers
