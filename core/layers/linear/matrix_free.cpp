#include "layers/linear/matrix_free.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Dense>

#include "layers/block.hpp"
#include "layers/linear/bicgstab.hpp"

namespace springnet::layers {
namespace {

// Nodes from which on it is faster than a matrix. (Measured on lattices.)
constexpr std::size_t min_nodes = 300;
constexpr std::size_t nodes_of_part = 256;
// Springs from which on threads pay off.
constexpr std::size_t multiplied_in_parallel = 8000;
// In the unit of mass.
constexpr double greatest = greatest_in_single, max_mass_ratio = 1e12;
// Accuracy that single precision reaches in one go, and the reduction that refinement must bring.
constexpr double single_accuracy = 1e-4, max_reduction = 0.1;

}  // namespace

MatrixFree::MatrixFree(const Layout& layout, const Evaluator& evaluator, const std::vector<double>& mass,
                       const std::vector<std::uint8_t>& constrained)
    : layout_(layout),
      evaluator_(evaluator),
      mass_(mass),
      constrained_(constrained),
      springs_(layout),
      segments_(layout, evaluator),
      kernels_(spring_kernels_for(evaluator.instruction_set())),
      coarse_(evaluator.instruction_set()) {}

bool MatrixFree::fits() const {
  if (layout_.node_count() < min_nodes || layout_.elements().live_count() > 0 || layout_.loaded_faces().any_following())
    return false;
  const auto relative = [](const Group& group) { return group.spring.relative || group.viscosity.relative; };
  const std::vector<Group>& groups = layout_.laws().groups;
  if (std::any_of(groups.begin(), groups.end(), relative)) return false;
  const auto differentiable = [](const Law* law) { return !*law || law->can(SPRINGNET_HAS_DERIVATIVES); };
  return std::all_of(groups.begin(), groups.end(), [&](const Group& group) {
    const auto laws = group.laws();
    return std::all_of(laws.begin(), laws.end(), differentiable);
  });
}

void MatrixFree::lay_out() {
  const std::size_t n = layout_.node_count();
  for (auto* values : {&own_scale_, &inverse_mass_, &mass_in_unit_}) values->assign(n, 0.0F);
  own_.assign(12 * n, 0.0);
  blocks_.assign(9 * n, 0.0);
  spring_blocks_.resize(8 * n);
  inverse_.assign(12 * n, 0.0F);
  if (!springs_.follow() && is_laid_out_) return;
  is_laid_out_ = false;  // memory may run out below
  coarse_.clear();
  for (auto& vector : vectors_) vector.clear();
  for (auto* vector : {&solution_, &residual_, &right_side_}) vector->assign(4 * n, 0.0);
  parts_.clear();
  first_part_.assign(1, 0);
  for (const Unit& unit : layout_.units()) {
    const std::size_t end = std::size_t{unit.first_node} + unit.node_count;
    for (std::size_t begin = unit.first_node; begin < end; begin += nodes_of_part)
      parts_.push_back({begin, std::min(end, begin + nodes_of_part)});
    first_part_.push_back(parts_.size());
  }
  sum_.resize(parts_.size());
  of_unit_.clear();
  for (const SpringsOfUnit& unit : springs_.units()) {
    const std::size_t within = unit.within.second.size();
    of_unit_.push_back({std::vector<float>(4 * (within + unit.leaving.second.size()), 0.0F), within});
  }
  is_laid_out_ = true;
}

SpringRows MatrixFree::rows_within(std::size_t unit) const {
  const SpringsOfUnit::Part& part = springs_.units()[unit].within;
  return {part.start.data(), part.second.data(), of_unit_[unit].stiffness.data()};
}

SpringRows MatrixFree::rows_leaving(std::size_t unit) const {
  const SpringsOfUnit::Part& part = springs_.units()[unit].leaving;
  return {part.start.data(), part.second.data(), of_unit_[unit].stiffness.data() + 4 * of_unit_[unit].within};
}

bool MatrixFree::prepare(double time, const NodeArrays& nodes, const ExternalForces& external,
                         const SystemWeights& weights, const std::vector<NodeResponse>& responses) {
  lay_out();
  responses_.set(responses);
  velocity_weight_ = weights.velocity;
  const std::size_t used = responses_.symmetric() ? 6 : vectors_.size();
  for (std::size_t i = 0; i < used; ++i) vectors_[i].resize(4 * layout_.node_count());
  if (!set_own_blocks(time, nodes, external, weights)) return false;
  const auto units = static_cast<std::int64_t>(layout_.units().size());
  segments_.reserve();
  std::vector<StiffnessSums> sums(layout_.units().size());
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t u = 0; u < units; ++u) {
    const FlushDenormals flush;
    sums[static_cast<std::size_t>(u)] = linearise_unit(static_cast<std::size_t>(u), time, nodes, weights);
  }
  double asymmetric = 0.0, all = 0.0;
  for (const StiffnessSums& unit : sums) {
    if (!unit.fits) return false;
    asymmetric += unit.asymmetric;
    all += unit.all;
  }
  asymmetry_ = all > 0.0 ? std::sqrt(asymmetric / all) : 0.0;
  for (std::size_t u = 0; u < of_unit_.size(); ++u) take_incoming(u);
  bool inverted = true;
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads())) reduction(&& : inverted)
  for (std::int64_t u = 0; u < units; ++u) inverted = invert_blocks(static_cast<std::size_t>(u)) && inverted;
  if (!inverted) return false;
  prepare_coarse(nodes, weights);
  return add_responses();
}

void MatrixFree::add_additions(double share) {
  responses_.for_each_addition([&](std::uint32_t node, const Eigen::Matrix3d& extra, const Eigen::Matrix3d& slip) {
    const Eigen::Matrix3d all = share * mass_[node] / unit_ * (extra - velocity_weight_ * slip);
    for (Eigen::Index c = 0; c < 3; ++c) {
      for (Eigen::Index r = 0; r < 3; ++r) {
        own_[12 * std::size_t{node} + static_cast<std::size_t>(4 * c + r)] += all(r, c);
        blocks_[9 * std::size_t{node} + static_cast<std::size_t>(3 * c + r)] += all(r, c);
      }
    }
  });
}

bool MatrixFree::add_responses() {
  add_additions(1.0);
  isotropic_ = isotropic_ && !responses_.any();
  if (!isotropic_) own_single_.assign(own_.begin(), own_.end());
  return responses_.for_each_inverse(
      [this](std::size_t node) { return Eigen::Map<const Eigen::Matrix3d>(&blocks_[9 * node]); },
      [this](std::size_t node, const Eigen::Matrix3d& inverse) { set_inverse(node, inverse); });
}

void MatrixFree::set_inverse(std::size_t node, const Eigen::Matrix3d& inverse) {
  for (Eigen::Index c = 0; c < 3; ++c)
    for (Eigen::Index r = 0; r < 3; ++r)
      inverse_[12 * node + static_cast<std::size_t>(4 * c + r)] = static_cast<float>(inverse(r, c));
}

bool MatrixFree::invert_blocks(std::size_t index) {
  const FlushDenormals flush;
  const Unit& unit = layout_.units()[index];
  const NodeRange nodes{unit.first_node, std::size_t{unit.first_node} + unit.node_count};
  std::fill(spring_blocks_.begin() + static_cast<std::ptrdiff_t>(8 * nodes.begin),
            spring_blocks_.begin() + static_cast<std::ptrdiff_t>(8 * nodes.end), 0.0);
  kernels_.add_blocks(rows_within(index), nodes, true, spring_blocks_.data());
  kernels_.add_blocks(rows_leaving(index), nodes, false, spring_blocks_.data());
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    const double* const of_springs = &spring_blocks_[8 * k];
    double* const block = &blocks_[9 * k];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t next = (c + 1) % 3;
      block[4 * c] += of_springs[c];
      block[3 * c + next] += of_springs[4 + c];
      block[3 * next + c] += of_springs[4 + c];
    }
    if (constrained_[k] != 0) continue;
    mass_in_unit_[k] = static_cast<float>(mass_[k] / unit_);
    inverse_mass_[k] = static_cast<float>(unit_ / mass_[k]);
    const Eigen::LLT<Eigen::Matrix3d> factors(Eigen::Map<const Eigen::Matrix3d>(&blocks_[9 * k]));
    if (factors.info() != Eigen::Success) return false;
    const Eigen::Matrix3d inverse = factors.solve(Eigen::Matrix3d::Identity());
    const double least = inverse.diagonal().minCoeff(), most = inverse.diagonal().maxCoeff();
    if (!(least >= 1.0 / greatest && most <= greatest)) return false;  // in single precision
    set_inverse(k, Eigen::Matrix3d(inverse.selfadjointView<Eigen::Upper>()));
  }
  return true;
}

void MatrixFree::prepare_coarse(const NodeArrays& nodes, const SystemWeights& weights) {
  // Trials of other lengths, and shifts, would make it anew each time.
  repeats_ = !last_weights_ || CoarseUse::are_same(weights, *last_weights_);
  last_weights_ = weights;
  coarse_is_kept_ = coarse_.any() && unit_ == coarse_unit_ && coarse_use_.serves(weights);
  if (coarse_is_kept_) return coarse_.follow(constrained_);
  make_coarse({nodes.px, nodes.py, nodes.pz});
  coarse_use_.begin(weights, layout_.live_count(), coarse_.numbers());
}

bool MatrixFree::renews(const std::array<const double*, 3>& position) {
  if (!std::exchange(coarse_is_kept_, false)) return false;
  const FlushDenormals flush;
  add_additions(-1.0);
  make_coarse(position);
  add_additions(1.0);
  coarse_use_.begin_again();
  return true;
}

// Of springs and masses alone.
void MatrixFree::make_coarse(const std::array<const double*, 3>& position) {
  coarse_.clear();
  coarse_unit_ = unit_;
  const std::size_t n = layout_.node_count();
  double stiffness = 0.0, inertia = 0.0, moving = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    if (constrained_[k] != 0) continue;
    moving += 1.0;
    stiffness += blocks_[9 * k] + blocks_[9 * k + 4] + blocks_[9 * k + 8];
    inertia += own_[12 * k] + own_[12 * k + 5] + own_[12 * k + 10];
  }
  const bool is_rigid = static_cast<double>(layout_.live_count()) >= CoarseSpace::rigid * moving;
  if (!CoarseSpace::pays(n, stiffness / inertia, repeats_ && is_rigid)) return;
  coarse_.begin(position, constrained_);
  for (std::size_t k = 0; k < n; ++k) {
    if (constrained_[k] != 0) continue;
    const double* const own = &own_[12 * k];
    coarse_.add_block(
        k, k,
        (Eigen::Matrix3d() << own[0], own[4], own[8], own[1], own[5], own[9], own[2], own[6], own[10]).finished());
  }
  for (std::size_t u = 0; u < layout_.units().size(); ++u) {
    const Unit& unit = layout_.units()[u];
    for (const bool within : {true, false}) {
      const SpringRows rows = within ? rows_within(u) : rows_leaving(u);
      for (std::size_t k = 0; k < unit.node_count; ++k) {
        for (std::uint32_t s = rows.start[k]; s < rows.start[k + 1]; ++s) {
          const std::size_t first = unit.first_node + k, second = rows.second[s];
          if (!within && second < first) continue;  // it is among those of the other unit, too
          const float* const b = rows.stiffness + 4 * std::size_t{s};
          coarse_.add_spring(first, second, b[3], {b[0], b[1], b[2]});
        }
      }
    }
  }
  coarse_.factorise();
}

double MatrixFree::correct(Team& team, const float* r, float* z) {
  team.alone([&] {
    coarse_part_ = coarse_.correct<4>(r, z);
    responses_.allow({0, layout_.node_count()}, z);
  });
  return coarse_part_;
}

// Mass and neurons. False: the force does not act on a node as on a point mass.
bool MatrixFree::set_own_blocks(double time, const NodeArrays& nodes, const ExternalForces& external,
                                const SystemWeights& weights) {
  const std::size_t n = layout_.node_count();
  for (const NeuronKind& neuron : layout_.laws().neurons)
    if ((neuron.component->description->capabilities & SPRINGNET_HAS_DERIVATIVES) == 0) return false;
  force_.resize(6 * n);
  double* force[3] = {force_.data(), force_.data() + n, force_.data() + 2 * n};
  double* acceleration[3] = {force_.data() + 3 * n, force_.data() + 4 * n, force_.data() + 5 * n};
  springnet_message message{};
  if (evaluator_.evaluate(time, nodes, external, {force[0], force[1], force[2]}, {}, message) != SPRINGNET_OK)
    return false;
  for (auto* blocks : {&by_force_, &by_position_, &by_velocity_}) blocks->assign(9 * n, 0.0);
  const double* const_force[3] = {force[0], force[1], force[2]};
  if (evaluator_.accelerations(0, static_cast<std::uint32_t>(n), time, nodes, const_force, acceleration,
                               by_force_.data(), by_position_.data(), by_velocity_.data(), message) != SPRINGNET_OK)
    return false;
  using Map = Eigen::Map<const Block>;
  double lightest = std::numeric_limits<double>::infinity(), heaviest = 0.0;  // of nodes that move
  for (std::size_t k = 0; k < n; ++k) {
    if (constrained_[k] != 0) continue;
    lightest = std::min(lightest, mass_[k]);
    heaviest = std::max(heaviest, mass_[k]);
  }
  if (!(heaviest > 0.0 && heaviest <= max_mass_ratio * lightest)) return false;
  unit_ = std::sqrt(lightest) * std::sqrt(heaviest);
  isotropic_ = true;
  for (std::size_t k = 0; k < n; ++k) {
    const double m = mass_[k] / unit_;
    Block own = Block::Identity();  // of nodes that do not move
    if (constrained_[k] == 0) {
      if (!((mass_[k] * Map(&by_force_[9 * k]) - Block::Identity()).cwiseAbs().maxCoeff() <= point_mass_rounding))
        return false;
      const Block drag =
          -m * (weights.velocity * Map(&by_velocity_[9 * k]) + weights.position * Map(&by_position_[9 * k]));
      if (!drag.allFinite() || !drag.isApprox(drag.transpose(), point_mass_rounding)) return false;
      own = m * (1.0 + weights.shift) * Block::Identity() + 0.5 * (drag + drag.transpose());
    }
    if (!(own.cwiseAbs().maxCoeff() <= greatest)) return false;
    isotropic_ = isotropic_ && own == Block(own(0, 0) * Block::Identity());
    own_scale_[k] = static_cast<float>(own(0, 0));
    for (Eigen::Index c = 0; c < 3; ++c) {
      for (Eigen::Index r = 0; r < 3; ++r) {
        own_[12 * k + static_cast<std::size_t>(4 * c + r)] = own(r, c);
        blocks_[9 * k + static_cast<std::size_t>(3 * c + r)] = own(r, c);
      }
    }
  }
  return true;
}

StiffnessSums MatrixFree::linearise_unit(std::size_t index, double time, const NodeArrays& nodes,
                                         const SystemWeights& weights) {
  StiffnessSums sums;
  float* const stiffness = of_unit_[index].stiffness.data();
  sums.fits = segments_.for_each(index, time, nodes, springs_.units()[index].place, [&](const AxialAnswers& answers) {
    const StiffnessSums own =
        kernels_.write_stiffness(answers, weights.position / unit_, weights.velocity / unit_, stiffness);
    sums.asymmetric += own.asymmetric;
    sums.all += own.all;
    return own.fits || fits_where_it_matters(answers, stiffness);
  });
  return sums;
}

bool MatrixFree::fits_where_it_matters(const AxialAnswers& answers, float* stiffness) const {
  for (std::size_t i = 0; i < answers.count; ++i) {
    const std::uint32_t spring = answers.spring[i];
    if (spring == no_spring) continue;
    float* const own = stiffness + 4 * std::size_t{answers.place[i]};
    if (!std::isnan(own[0])) continue;
    if (constrained_[layout_.first(spring)] == 0 || constrained_[layout_.second(spring)] == 0) return false;
    std::fill_n(own, 4, 0.0F);
  }
  return true;
}

// Springs that the unit before has linearised.
void MatrixFree::take_incoming(std::size_t unit) {
  Springs& own = of_unit_[unit];
  for (const SpringsOfUnit::Incoming& spring : springs_.units()[unit].incoming) {
    const Springs& before = of_unit_[unit - 1];
    std::copy_n(&before.stiffness[4 * (before.within + spring.from)], 4,
                &own.stiffness[4 * (own.within + spring.place)]);
  }
}

SolveAnswer MatrixFree::solve(double accuracy, std::uint32_t max_iterations, const double* b, double* x) {
  SolveAnswer answer;
  const auto run = [&](unsigned count, unsigned me) {
    const FlushDenormals flush;
    Team team(count, me);
    const SolveAnswer own = solve(team, accuracy, max_iterations, b);
    if (me == 0) answer = own;
  };
  const unsigned threads = layout_.live_count() >= multiplied_in_parallel ? evaluator_.threads() : 1;
  if (threads <= 1) {
    run(1, 0);
  } else {
#pragma omp parallel num_threads(static_cast <int>(threads))
    run(static_cast<unsigned>(omp_get_num_threads()), static_cast<unsigned>(omp_get_thread_num()));
  }
  if (coarse_.any()) coarse_use_.count(answer, responses_.symmetric() ? 1.0 : 2.0);
  const std::size_t n = layout_.node_count();
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t k = 0; k < n; ++k) x[c * n + k] = solution_[4 * k + c];
  return answer;
}

SolveAnswer MatrixFree::solve(Team& team, double accuracy, std::uint32_t max_iterations, const double* b) {
  const auto [begin, end] = own_nodes(team);
  const std::size_t n = layout_.node_count();
  std::fill(solution_.begin() + static_cast<std::ptrdiff_t>(4 * begin),
            solution_.begin() + static_cast<std::ptrdiff_t>(4 * end), 0.0);
  for (std::size_t k = begin; k < end; ++k)
    for (std::size_t c = 0; c < 3; ++c)
      right_side_[4 * k + c] = constrained_[k] != 0 ? 0.0 : mass_[k] / unit_ * b[c * n + k];
  responses_.take_right_side({begin, end}, right_side_.data());
  std::copy(right_side_.begin() + static_cast<std::ptrdiff_t>(4 * begin),
            right_side_.begin() + static_cast<std::ptrdiff_t>(4 * end),
            residual_.begin() + static_cast<std::ptrdiff_t>(4 * begin));
  const double first = norm(team, residual_.data());
  SolveAnswer answer{SolveOutcome::solved, 0, 0.0};
  if (first == 0.0) return answer;
  answer.outcome = SolveOutcome::stalled;
  answer.residual = 1.0;
  if (!std::isfinite(first)) return answer;
  double left = first;
  while (true) {
    const double scale = 1.0 / left;
    for (std::size_t i = 4 * begin; i < 4 * end; ++i) vectors_[0][i] = static_cast<float>(scale * residual_[i]);
    const double wanted = accuracy / answer.residual;
    const SolveAnswer part = solve_once(team, std::max(wanted, single_accuracy), max_iterations - answer.iterations);
    answer.iterations += part.iterations;
    answer.outcome = part.outcome;
    for (std::size_t i = 4 * begin; i < 4 * end; ++i) solution_[i] += left * double{vectors_[1][i]};
    if (wanted >= single_accuracy || part.outcome != SolveOutcome::solved) {
      answer.residual *= part.residual;
      return answer;
    }
    const double before = left;
    left = find_residual(team);
    answer.residual = left / first;
    if (answer.residual <= accuracy) return answer;
    if (!(left < max_reduction * before)) {
      answer.outcome = SolveOutcome::stalled;
      if (left <= before) return answer;
      for (std::size_t i = 4 * begin; i < 4 * end; ++i) solution_[i] -= before * double{vectors_[1][i]};
      answer.residual = before / first;
      return answer;
    }
  }
}

SolveAnswer MatrixFree::solve_once(Team& team, double accuracy, std::uint32_t max_iterations) {
  std::array<float*, 6> work{};
  for (std::size_t i = 0; i < work.size(); ++i) work[i] = vectors_[i + 2].data();
  float *const b = vectors_[0].data(), *const x = vectors_[1].data();
  if (responses_.symmetric())
    return conjugate_gradients(*this, team, accuracy, max_iterations, b, x, work[0], work[1], work[2], work[3]);
  const auto none = []() -> std::optional<double> { return std::nullopt; };
  return bicgstab(*this, team, accuracy, max_iterations, b, x, work, none);
}

double MatrixFree::find_residual(Team& team) {
  team.barrier();  // solution_ of all
  const NodeRange units = own_units(team), own = own_nodes(team);
  for (std::size_t u = units.begin; u < units.end; ++u) {
    const Unit& unit = layout_.units()[u];
    const NodeRange nodes{unit.first_node, std::size_t{unit.first_node} + unit.node_count};
    kernels_.diagonal_double(own_.data(), nodes, solution_.data(), residual_.data());
    kernels_.product_double(rows_within(u), nodes, solution_.data(), true, residual_.data());
    kernels_.product_double(rows_leaving(u), nodes, solution_.data(), false, residual_.data());
  }
  responses_.see(own, residual_.data());
  for (std::size_t i = 4 * own.begin; i < 4 * own.end; ++i)
    residual_[i] = constrained_[i / 4] != 0 ? 0.0 : right_side_[i] - residual_[i];
  return norm(team, residual_.data());
}

double MatrixFree::norm(Team& team, const double* residual) {
  return std::sqrt(sum_(team, own_parts(team), [&](std::size_t i) {
    double sum = 0.0;
    for (std::size_t k = parts_[i].begin; k < parts_[i].end; ++k)
      for (std::size_t c = 0; c < 3; ++c) sum += unit_ / mass_[k] * residual[4 * k + c] * residual[4 * k + c];
    return sum;
  }));
}

NodeRange MatrixFree::own_units(const Team& team) const { return team.share(layout_.units().size()); }

NodeRange MatrixFree::own_parts(const Team& team) const {
  const NodeRange units = own_units(team);
  return {first_part_[units.begin], first_part_[units.end]};
}

NodeRange MatrixFree::own_nodes(const Team& team) const {
  const NodeRange parts = own_parts(team);
  if (parts.begin == parts.end) return {0, 0};
  return {parts_[parts.begin].begin, parts_[parts.end - 1].end};
}

}  // namespace springnet::layers
