#include "layers/linear/matrix_free.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Dense>

#include "layers/law_pair.hpp"
#include "layers/springs/blocks.hpp"

namespace springnet::layers {
namespace {

// Smaller nets fit the caches as matrices, too. (Measured on lattices.)
constexpr std::size_t min_nodes = 2000;
constexpr std::size_t nodes_of_part = 1024;
// Springs from which on threads pay off.
constexpr std::size_t springs_worth_threads = 8000;
// Mass times da/dF of a point mass, up to rounding.
constexpr double rounding = 1e-12;
// So that products of a spring's four numbers are finite, too.
constexpr double greatest = 1e37;

const SpringKernels& kernels_of(InstructionSet set) {
#if defined(__x86_64__) && !defined(SPRINGNET_GENERIC_ONLY)
  if (set == InstructionSet::avx512) return avx512::spring_kernels();
  if (set == InstructionSet::avx2) return avx2::spring_kernels();
#endif
  static_cast<void>(set);
  return generic::spring_kernels();
}

SegmentSprings springs_of(const Unit& unit, const Segment& segment) {
  return {unit.runs.data() + segment.run_begin,
          segment.run_count,
          segment.run_springs,
          segment.count,
          unit.first.data() + segment.begin,
          unit.second.data() + segment.begin};
}

}  // namespace

MatrixFree::MatrixFree(const Layout& layout, const Evaluator& evaluator, const std::vector<double>& mass,
                       const std::vector<std::uint8_t>& constrained)
    : layout_(layout),
      evaluator_(evaluator),
      mass_(mass),
      constrained_(constrained),
      kernels_(kernels_of(evaluator.instruction_set())) {}

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
  pitch_ = (n + 7) / 8 * 8 + 8;
  for (auto& vector : vectors_) vector.assign(3 * pitch_, 0.0);
  for (auto* blocks : {&own_, &inverse_})
    for (auto& component : *blocks) component.assign(n, 0.0);
  inverse_mass_.assign(n, 0.0);
  parts_.clear();
  first_part_.assign(1, 0);
  for (const Unit& unit : layout_.units()) {
    const std::size_t end = std::size_t{unit.first_node} + unit.node_count;
    for (std::size_t begin = unit.first_node; begin < end; begin += nodes_of_part)
      parts_.push_back({begin, std::min(end, begin + nodes_of_part)});
    first_part_.push_back(parts_.size());
  }
  sum_.resize(parts_.size());
  stiffness_.resize(layout_.units().size());
}

bool MatrixFree::prepare(double time, const NodeArrays& nodes, const ExternalForces& external,
                         const SystemWeights& weights) {
  lay_out();
  if (!set_own_blocks(time, nodes, external, weights)) return false;
  for (std::size_t c = 0; c < 6; ++c) inverse_[c] = own_[c];
  const auto units = static_cast<std::int64_t>(layout_.units().size());
  std::vector<Sums> sums(layout_.units().size());
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t u = 0; u < units; ++u) {
    const FlushDenormals flush;
    sums[static_cast<std::size_t>(u)] = linearise_unit(static_cast<std::size_t>(u), time, nodes, weights);
  }
  double asymmetric = 0.0, all = 0.0;
  for (const Sums& unit : sums) {
    if (!unit.fits) return false;
    asymmetric += unit.asymmetric;
    all += unit.all;
  }
  asymmetry_ = all > 0.0 ? std::sqrt(asymmetric / all) : 0.0;
  for (std::size_t k = 0; k < layout_.node_count(); ++k) {
    if (constrained_[k] != 0) {
      for (auto& component : inverse_) component[k] = 0.0;
      continue;
    }
    inverse_mass_[k] = 1.0 / mass_[k];
    Eigen::Matrix3d block;
    block << inverse_[0][k], inverse_[3][k], inverse_[5][k], inverse_[3][k], inverse_[1][k], inverse_[4][k],
        inverse_[5][k], inverse_[4][k], inverse_[2][k];
    const Eigen::LLT<Eigen::Matrix3d> factors(block);
    if (factors.info() != Eigen::Success) return false;
    const Eigen::Matrix3d inverse = factors.solve(Eigen::Matrix3d::Identity());
    if (!inverse.allFinite()) return false;
    const double values[6] = {inverse(0, 0), inverse(1, 1), inverse(2, 2), inverse(0, 1), inverse(1, 2), inverse(0, 2)};
    for (std::size_t c = 0; c < 6; ++c) inverse_[c][k] = values[c];
  }
  return true;
}

// Mass and neurons. False: the force does not act on a node as on a point mass.
bool MatrixFree::set_own_blocks(double time, const NodeArrays& nodes, const ExternalForces& external,
                                const SystemWeights& weights) {
  const std::size_t n = layout_.node_count();
  for (const NeuronKind& neuron : layout_.laws().neurons)
    if ((neuron.component->description->capabilities & SPRINGNET_HAS_DERIVATIVES) == 0) return false;
  force_.resize(6 * pitch_);
  double* force[3] = {force_.data(), force_.data() + pitch_, force_.data() + 2 * pitch_};
  double* acceleration[3] = {force_.data() + 3 * pitch_, force_.data() + 4 * pitch_, force_.data() + 5 * pitch_};
  springnet_message message{};
  if (evaluator_.evaluate(time, nodes, external, {force[0], force[1], force[2]}, {}, message) != SPRINGNET_OK)
    return false;
  for (auto* blocks : {&by_force_, &by_position_, &by_velocity_}) blocks->assign(9 * n, 0.0);
  const double* const_force[3] = {force[0], force[1], force[2]};
  if (evaluator_.accelerations(0, static_cast<std::uint32_t>(n), time, nodes, const_force, acceleration,
                               by_force_.data(), by_position_.data(), by_velocity_.data(), message) != SPRINGNET_OK)
    return false;
  using Map = Eigen::Map<const Block>;
  isotropic_ = true;
  for (std::size_t k = 0; k < n; ++k) {
    const double m = mass_[k];
    if (constrained_[k] != 0) {
      for (std::size_t c = 0; c < 6; ++c) own_[c][k] = c < 3 ? m : 0.0;
      continue;
    }
    if (!((m * Map(&by_force_[9 * k]) - Block::Identity()).cwiseAbs().maxCoeff() <= rounding)) return false;
    const Block drag =
        -m * (weights.velocity * Map(&by_velocity_[9 * k]) + weights.position * Map(&by_position_[9 * k]));
    if (!drag.allFinite() || !drag.isApprox(drag.transpose(), rounding)) return false;
    const double inertia = m * (1.0 + weights.shift);
    isotropic_ = isotropic_ && drag(0, 0) == drag(1, 1) && drag(0, 0) == drag(2, 2) && drag(0, 1) == 0.0 &&
                 drag(1, 2) == 0.0 && drag(0, 2) == 0.0;
    const double values[6] = {inertia + drag(0, 0), inertia + drag(1, 1), inertia + drag(2, 2),
                              drag(0, 1),           drag(1, 2),           drag(0, 2)};
    for (std::size_t c = 0; c < 6; ++c) own_[c][k] = values[c];
  }
  return true;
}

MatrixFree::Sums MatrixFree::linearise_unit(std::size_t index, double time, const NodeArrays& nodes,
                                            const SystemWeights& weights) {
  const Unit& unit = layout_.units()[index];
  UnitStiffness& stiffness = stiffness_[index];
  for (auto* values : {&stiffness.a, &stiffness.qx, &stiffness.qy, &stiffness.qz})
    values->assign(unit.first.size() + 8, 0.0F);
  const Kernels& kernels = kernels_for(evaluator_.instruction_set());
  const auto geometry = std::make_unique<SegmentGeometry>();
  const auto answers = std::make_unique<PairAnswers<max_segment>>();
  const PairOutputs out = answers->outputs(true, false);
  Sums sums;
  springnet_message message{};
  for (const Segment& segment : unit.segments) {
    const Group& group = layout_.laws().groups[segment.group];
    const SegmentSprings springs = springs_of(unit, segment);
    kernels.lengths_and_rates(springs, nodes, *geometry);
    kernels.relative_speeds(springs, nodes, *geometry);
    const RowSelection rows = segment.row == mixed_rows ? RowSelection{unit.row.data() + segment.begin, 0}
                                                        : RowSelection{nullptr, segment.row};
    const LawBatch batch{group, segment.count, rows, geometry->length, geometry->rate, geometry->speed};
    if (evaluate_laws(batch, evaluator_.instruction_set(), time, out, message) != SPRINGNET_OK) {
      sums.fits = false;
      return sums;
    }
    for (std::size_t i = 0; i < segment.count; ++i) {
      const std::size_t slot = segment.begin + i;
      const SpringForces forces = spring_forces(group, *answers, i);
      const double length = geometry->length[i], rate = geometry->rate[i], speed = geometry->speed[i];
      const double a = length > 0.0 ? weights.position * forces.tension / length : 0.0;
      const double along = weights.position * forces.by_length + weights.velocity * forces.by_rate - a;
      // A spring that softens, or a stiffness that is not finite in single precision.
      if (!(along >= 0.0) || !(std::abs(a) <= greatest && along <= greatest)) {
        if (constrained_[unit.first[slot]] != 0 && constrained_[unit.second[slot]] != 0) continue;
        sums.fits = false;
        return sums;
      }
      const double root = std::sqrt(along);
      const double q[3] = {root * geometry->nx[i], root * geometry->ny[i], root * geometry->nz[i]};
      stiffness.a[slot] = static_cast<float>(a);
      stiffness.qx[slot] = static_cast<float>(q[0]);
      stiffness.qy[slot] = static_cast<float>(q[1]);
      stiffness.qz[slot] = static_cast<float>(q[2]);
      const double block[6] = {a + q[0] * q[0], a + q[1] * q[1], a + q[2] * q[2],
                               q[0] * q[1],     q[1] * q[2],     q[0] * q[2]};
      for (const std::size_t node : {unit.first[slot], unit.second[slot]}) {
        for (std::size_t c = 0; c < 6; ++c) inverse_[c][node] += block[c];
        if (segment.boundary) break;
      }
      if (length > 0.0) {
        const double skew = weights.position * forces.by_rate / length;
        sums.asymmetric += 2.0 * skew * skew * std::max(0.0, speed * speed - rate * rate);
      }
      sums.all += 2.0 * a * a + (a + along) * (a + along);
    }
  }
  return sums;
}

SolveAnswer MatrixFree::solve(double accuracy, std::uint32_t max_iterations, const double* b, double* x) {
  const std::size_t n = layout_.node_count();
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t k = 0; k < n; ++k)
      vectors_[0][c * pitch_ + k] = constrained_[k] != 0 ? 0.0 : mass_[k] * b[c * n + k];
  SolveAnswer answer;
  const auto run = [&](unsigned count, unsigned me) {
    const FlushDenormals flush;
    Team team(count, me);
    const SolveAnswer own =
        conjugate_gradients(*this, team, accuracy, max_iterations, vectors_[0].data(), vectors_[1].data(),
                            vectors_[2].data(), vectors_[3].data(), vectors_[4].data(), vectors_[5].data());
    if (me == 0) answer = own;
  };
  const unsigned threads = layout_.live_count() >= springs_worth_threads ? evaluator_.threads() : 1;
  if (threads <= 1) {
    run(1, 0);
  } else {
#pragma omp parallel num_threads(static_cast <int>(threads))
    run(static_cast<unsigned>(omp_get_num_threads()), static_cast<unsigned>(omp_get_thread_num()));
  }
  for (std::size_t c = 0; c < 3; ++c) std::copy_n(vectors_[1].data() + c * pitch_, n, x + c * n);
  return answer;
}

NodeRange MatrixFree::own_units(const Team& team) const { return team.share(layout_.units().size()); }

NodeRange MatrixFree::own_parts(const Team& team) const {
  const NodeRange units = own_units(team);
  return {first_part_[units.begin], first_part_[units.end]};
}

// action(begin, count) for each axis of the thread's nodes.
template <class Action>
void MatrixFree::for_own_axes(const Team& team, const Action& action) const {
  const NodeRange parts = own_parts(team);
  if (parts.begin == parts.end) return;
  const std::size_t begin = parts_[parts.begin].begin, end = parts_[parts.end - 1].end;
  for (std::size_t c = 0; c < 3; ++c) action(c * pitch_ + begin, end - begin);
}

void MatrixFree::product(Team& team, const double* p, double* q) {
  const NodeRange units = own_units(team);
  const double* const from[3] = {p, p + pitch_, p + 2 * pitch_};
  double* const to[3] = {q, q + pitch_, q + 2 * pitch_};
  for (std::size_t u = units.begin; u < units.end; ++u) {
    const Unit& unit = layout_.units()[u];
    const UnitStiffness& own = stiffness_[u];
    const std::size_t begin = unit.first_node;
    const double* const blocks[6] = {&own_[0][begin], &own_[1][begin], &own_[2][begin],
                                     &own_[3][begin], &own_[4][begin], &own_[5][begin]};
    const double* const in[3] = {from[0] + begin, from[1] + begin, from[2] + begin};
    double* const out[3] = {to[0] + begin, to[1] + begin, to[2] + begin};
    if (isotropic_)
      for (std::size_t c = 0; c < 3; ++c) kernels_.multiply(blocks[0], in[c], unit.node_count, out[c]);
    else
      kernels_.diagonal(blocks, in, unit.node_count, out);
    for (const Segment& segment : unit.segments)
      kernels_.product(springs_of(unit, segment),
                       {own.a.data() + segment.begin, own.qx.data() + segment.begin, own.qy.data() + segment.begin,
                        own.qz.data() + segment.begin},
                       from, !segment.boundary, to);
  }
}

void MatrixFree::precondition_part(std::size_t part, const double* r, double* z) const {
  const auto [begin, end] = parts_[part];
  const double* const blocks[6] = {&inverse_[0][begin], &inverse_[1][begin], &inverse_[2][begin],
                                   &inverse_[3][begin], &inverse_[4][begin], &inverse_[5][begin]};
  const double* const in[3] = {r + begin, r + pitch_ + begin, r + 2 * pitch_ + begin};
  double* const out[3] = {z + begin, z + pitch_ + begin, z + 2 * pitch_ + begin};
  kernels_.diagonal(blocks, in, end - begin, out);
}

double MatrixFree::dot_part(std::size_t part, const double* a, const double* b) const {
  const auto [begin, end] = parts_[part];
  double value = 0.0;
  for (std::size_t c = 0; c < 3; ++c)
    value += kernels_.dot(a + c * pitch_ + begin, b + c * pitch_ + begin, end - begin);
  return value;
}

double MatrixFree::square_part(std::size_t part, const double* r) const {
  const auto [begin, end] = parts_[part];
  double value = 0.0;
  for (std::size_t c = 0; c < 3; ++c)
    value += kernels_.square(&inverse_mass_[begin], r + c * pitch_ + begin, end - begin);
  return value;
}

void MatrixFree::precondition(Team& team, const double* r, double* z) {
  const NodeRange parts = own_parts(team);
  for (std::size_t i = parts.begin; i < parts.end; ++i) precondition_part(i, r, z);
}

double MatrixFree::dot(Team& team, const double* a, const double* b) {
  return sum_(team, own_parts(team), [&](std::size_t i) { return dot_part(i, a, b); });
}

double MatrixFree::square(Team& team, const double* r, double) {
  return sum_(team, own_parts(team), [&](std::size_t i) { return square_part(i, r); });
}

Sums2 MatrixFree::update(Team& team, double step, const double* p, const double* q, double* x, double* r, double* z) {
  return sum_.two(team, own_parts(team), [&](std::size_t i) -> Sums2 {
    const auto [begin, end] = parts_[i];
    for (std::size_t at = begin; at < begin + 3 * pitch_; at += pitch_) {
      kernels_.add(step, p + at, end - begin, x + at);
      kernels_.add(-step, q + at, end - begin, r + at);
    }
    precondition_part(i, r, z);
    return {dot_part(i, r, z), square_part(i, r)};
  });
}

void MatrixFree::scale_add(Team& team, double s, const double* x, double* y) {
  for_own_axes(team, [&](std::size_t begin, std::size_t count) { kernels_.scale_add(s, x + begin, count, y + begin); });
}

void MatrixFree::copy(Team& team, const double* x, double* y) {
  for_own_axes(team, [&](std::size_t begin, std::size_t count) { std::copy_n(x + begin, count, y + begin); });
}

void MatrixFree::zero(Team& team, double* x) {
  for_own_axes(team, [&](std::size_t begin, std::size_t count) { std::fill_n(x + begin, count, 0.0); });
}

}  // namespace springnet::layers
