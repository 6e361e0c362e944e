#include "layers/linear/linearisation.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>

#include "layers/failure.hpp"
#include "layers/linear/axial_springs.hpp"
#include "layers/springs/queries.hpp"
#include "plugin_host/call.hpp"
#include "plugin_host/message.hpp"

namespace springnet::layers {

struct Linearisation::System {
  using Factors = Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>>;

  Eigen::SparseMatrix<double> matrix;  // 3n x 3n, unknown 3 node + coordinate
  Factors factors;
  // With rows: the same matrix bordered by them.
  Eigen::SparseMatrix<double> bordered;
  Factors bordered_factors;
};

Linearisation::Linearisation(const Layout& layout, const Evaluator& evaluator,
                             const std::vector<std::uint8_t>& constrained)
    : layout_(layout),
      evaluator_(evaluator),
      constrained_(constrained),
      axial_(std::make_unique<AxialSprings>(layout, evaluator)),
      elements_(layout, evaluator),
      system_(std::make_unique<System>()) {}

Linearisation::~Linearisation() = default;

springnet_status Linearisation::update(double time, const NodeArrays& nodes, const ExternalForces& external,
                                       springnet_message& message) {
  layout_.need_incidence();
  const std::size_t n = layout_.node_count();
  known_ = false;
  bonds_.clear();
  drags_.clear();
  const std::vector<Group>& groups = layout_.laws().groups;
  const bool may_be_axial = std::all_of(groups.begin(), groups.end(), [](const Group& group) {
    const std::array<const Law*, 2> laws = group.laws();
    return std::all_of(laws.begin(), laws.end(),
                       [](const Law* law) { return !*law || (!law->relative && law->can(SPRINGNET_HAS_DERIVATIVES)); });
  });
  are_axial_ = may_be_axial && axial_->update(time, nodes, constrained_);
  has_blocks_ = !are_axial_;
  stiffness_.resize(9 * layout_.spring_count());
  damping_.resize(9 * layout_.spring_count());
  bool finite = true;
  const auto geometry = std::make_unique<SegmentGeometry>();
  const auto answers = std::make_unique<PairAnswers<max_segment>>();
  const PairOutputs out = answers->outputs(true, false);
  for (std::size_t g = 0; g < groups.size() && !are_axial_; ++g) {  // which also tells what failed
    const Group& group = groups[g];
    for (const Law* law : group.laws())
      if (*law && require_derivatives(*law->component, message) != SPRINGNET_OK) return SPRINGNET_FAILED;
    const std::vector<std::uint32_t>& springs = layout_.springs_of(g);
    for (std::size_t begin = 0; begin < springs.size(); begin += max_segment) {
      const std::size_t count = std::min(max_segment, springs.size() - begin);
      const springnet_status status = evaluate_springs(layout_, evaluator_.instruction_set(), time, nodes, g,
                                                       springs.data() + begin, count, *geometry, out, message);
      if (status != SPRINGNET_OK) return status;
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t s = springs[begin + i];
        const Vector3 normal(geometry->nx[i], geometry->ny[i], geometry->nz[i]);
        const Vector3 along(geometry->sx[i], geometry->sy[i], geometry->sz[i]);
        const SpringForces forces = spring_forces(group, *answers, i);
        // Springs between constrained nodes do not matter.
        const bool counts = constrained_[layout_.first(s)] == 0 || constrained_[layout_.second(s)] == 0;
        finite = finite && (!counts || forces.is_finite());
        const SpringBlocks blocks(forces, geometry->length[i], normal, geometry->rate[i], geometry->speed[i], along);
        Eigen::Map<Block>(stiffness_.data() + 9 * std::size_t{s}) = blocks.stiffness;
        Eigen::Map<Block>(damping_.data() + 9 * std::size_t{s}) = blocks.damping;
      }
    }
  }
  if (const springnet_status elements = elements_.update(time, nodes, external.pressure, message);
      elements != SPRINGNET_OK)
    return elements;
  if (!finite || !elements_.finite()) return not_finite(time, nodes, message);
  for (const NeuronKind& neuron : layout_.laws().neurons) {
    if (require_derivatives(*neuron.component, message) != SPRINGNET_OK) return SPRINGNET_FAILED;
  }
  for (int c = 0; c < 3; ++c) {
    force_[c].resize(n);
    acceleration_[c].resize(n);
  }
  for (Blocks* each : {&by_force_, &by_position_, &by_velocity_}) each->resize(9 * n);
  const springnet_status status =
      evaluator_.evaluate(time, nodes, external, {force_[0].data(), force_[1].data(), force_[2].data()}, {}, message);
  if (status != SPRINGNET_OK) return status;
  const double* force[3] = {force_[0].data(), force_[1].data(), force_[2].data()};
  double* acceleration[3] = {acceleration_[0].data(), acceleration_[1].data(), acceleration_[2].data()};
  const springnet_status neurons =
      evaluator_.accelerations(0, static_cast<std::uint32_t>(n), time, nodes, force, acceleration, by_force_.data(),
                               by_position_.data(), by_velocity_.data(), message);
  if (neurons != SPRINGNET_OK) return neurons;
  find_scales();
  const springnet_status checked =
      std::all_of(scales_.begin(), scales_.end(), [](double each) { return std::isfinite(each); }) && !scales_.empty()
          ? SPRINGNET_OK
          : check_neurons(message);
  known_ = checked == SPRINGNET_OK;
  return checked;
}

void Linearisation::find_scales() {
  const std::size_t n = layout_.node_count();
  scales_.resize(3 * n);
  const Blocks* const kinds[] = {&by_force_, &by_position_, &by_velocity_};
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const double* const b = kinds[kind]->data() + 9 * k;
      scales_[3 * k + kind] = b[0];
      const bool is_scale = (b[4] == b[0]) & (b[8] == b[0]) & (b[1] == 0.0) & (b[2] == 0.0) & (b[3] == 0.0) &
                            (b[5] == 0.0) & (b[6] == 0.0) & (b[7] == 0.0);  // without branches
      if (is_scale) continue;
      scales_.clear();
      return;
    }
  }
}

void Linearisation::need_spring_blocks() {
  if (has_blocks_) return;
  for (std::size_t g = 0; g < layout_.laws().groups.size(); ++g) {
    for (const std::uint32_t s : layout_.springs_of(g)) {
      const SpringBlocks blocks = axial_->blocks(s);
      Eigen::Map<Block>(stiffness_.data() + 9 * std::size_t{s}) = blocks.stiffness;
      Eigen::Map<Block>(damping_.data() + 9 * std::size_t{s}) = blocks.damping;
    }
  }
  has_blocks_ = true;
}

springnet_status Linearisation::not_finite(double time, const NodeArrays& nodes, springnet_message& message) const {
  const std::string reason =
      explain_failure(layout_, evaluator_.instruction_set(), time, nodes, Requested::forces_and_derivatives);
  set_message(message,
              reason.empty() ? "a law's force or derivative was not finite, but is when evaluated again" : reason);
  return SPRINGNET_RECOVERABLE;
}

springnet_status Linearisation::check_neurons(springnet_message& message) const {
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    if (constrained_[k] != 0 ||
        (block(by_force_, k).allFinite() && block(by_position_, k).allFinite() && block(by_velocity_, k).allFinite()))
      continue;
    set_message(message, fmt::format("{} answered a derivative that is not finite for node {}",
                                     full_name(*layout_.laws().neurons[layout_.neuron_kind()[k]].component),
                                     layout_.ordering().user[k]));
    return SPRINGNET_RECOVERABLE;
  }
  return SPRINGNET_OK;
}

void Linearisation::times(const double* dp, const double* dv, double* out) {
  const std::size_t n = layout_.node_count();
  const bool elements = elements_.any();
  if (elements) elements_.prepare(dp, dv);
  const auto at = [n](const double* values, std::size_t k) {
    return Vector3(values[k], values[n + k], values[2 * n + k]);
  };
  if (are_axial_) {
    four_.resize(12 * n);
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        four_[4 * k + c] = dp[c * n + k];
        four_[4 * (n + k) + c] = dv[c * n + k];
      }
      four_[4 * k + 3] = four_[4 * (n + k) + 3] = 0.0;
    }
    std::fill(four_.begin() + static_cast<std::ptrdiff_t>(8 * n), four_.end(), 0.0);
    axial_->subtract_product(four_.data(), four_.data() + 4 * n, four_.data() + 8 * n);
  } else {
    layout_.need_incidence();  // before threads do
    need_spring_blocks();
  }
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t node = 0; node < static_cast<std::int64_t>(n); ++node) {
    const auto k = static_cast<std::uint32_t>(node);
    Vector3 result = Vector3::Zero();
    if (constrained_[k] == 0) {
      const Vector3 p = at(dp, k), v = at(dv, k);
      Vector3 force = Vector3::Zero();
      if (elements) force = elements_.force(k, dp, dv);
      if (are_axial_)
        force += Eigen::Map<const Vector3>(&four_[4 * (2 * n + k)]);
      else
        for (const Incident* i = layout_.incident_begin(k); i != layout_.incident_end(k); ++i)
          force -= block(stiffness_, i->spring) * (p - at(dp, i->other)) +
                   block(damping_, i->spring) * (v - at(dv, i->other));
      if (!scales_.empty()) {
        const double* const scale = &scales_[3 * std::size_t{k}];
        result = scale[0] * force + scale[1] * p + scale[2] * v;
      } else {
        result = block(by_force_, k) * force + block(by_position_, k) * p + block(by_velocity_, k) * v;
      }
    }
    out[k] = result[0];
    out[n + k] = result[1];
    out[2 * n + k] = result[2];
  }
  for (const Bond& bond : bonds_) {
    const Vector3 force = bond.stiffness * (at(dp, bond.first) - at(dp, bond.second));
    for (const std::uint32_t k : {bond.first, bond.second}) {
      if (constrained_[k] != 0) continue;
      const Vector3 change = block(by_force_, k) * (k == bond.first ? Vector3(-force) : force);
      for (std::size_t c = 0; c < 3; ++c) out[c * n + k] += change[static_cast<Eigen::Index>(c)];
    }
  }
  for (const Drag& drag : drags_) {
    double rate = 0.0;
    for_each_dragged(drag, [&](std::uint32_t k, double weight) { rate += weight * drag.row.direction.dot(at(dv, k)); });
    for_each_dragged(drag, [&](std::uint32_t k, double weight) {
      const Vector3 change = block(by_force_, k) * (-drag.damping * rate * weight * drag.row.direction);
      for (std::size_t c = 0; c < 3; ++c) out[c * n + k] += change[static_cast<Eigen::Index>(c)];
    });
  }
}

void Linearisation::accelerations(const double* force, double* out) const {
  const std::size_t n = layout_.node_count();
  for (std::uint32_t k = 0; k < n; ++k) {
    Vector3 result = Vector3::Zero();
    if (constrained_[k] == 0) result = block(by_force_, k) * Vector3(force[k], force[n + k], force[2 * n + k]);
    for (std::size_t c = 0; c < 3; ++c) out[c * n + k] = result[static_cast<Eigen::Index>(c)];
  }
}

bool Linearisation::neurons_dissipate() const {
  const auto dissipates = [](const auto& own) { return own.isDiagonal(0.0) && own.diagonal().maxCoeff() <= 0.0; };
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k)
    if (constrained_[k] == 0 && !(dissipates(block(by_position_, k)) && dissipates(block(by_velocity_, k))))
      return false;
  return true;
}

void Linearisation::set_weights(double velocity_weight, double position_weight) {
  need_spring_blocks();
  weighted_.resize(stiffness_.size());
  for (std::size_t i = 0; i < weighted_.size(); ++i)
    weighted_[i] = velocity_weight * damping_[i] + position_weight * stiffness_[i];
  position_weight_ = position_weight;
  elements_.set_weights(velocity_weight, position_weight);
  bond_ends_.clear();
  for (std::uint32_t b = 0; b < bonds_.size(); ++b)
    for (const std::uint32_t end : {bonds_[b].first, bonds_[b].second}) bond_ends_.emplace_back(end, b);
  std::sort(bond_ends_.begin(), bond_ends_.end());
}

Vector3 Linearisation::off_diagonal_product(std::uint32_t node, const double* const u[3]) const {
  if (constrained_[node] != 0) return Vector3::Zero();
  const auto at = [&](std::uint32_t k) { return Vector3(u[0][k], u[1][k], u[2][k]); };
  Vector3 force = Vector3::Zero();
  for (const Incident* i = layout_.incident_begin(node); i != layout_.incident_end(node); ++i)
    force += block(weighted_, i->spring) * at(i->other);
  if (elements_.any()) force += elements_.off_diagonal_force(node, u);
  for (auto end = std::lower_bound(bond_ends_.begin(), bond_ends_.end(), std::pair(node, std::uint32_t{0}));
       end != bond_ends_.end() && end->first == node; ++end) {
    const Bond& bond = bonds_[end->second];
    force += position_weight_ * (bond.stiffness * at(bond.first == node ? bond.second : bond.first));
  }
  return block(by_force_, node) * force;
}

void Linearisation::diagonal_blocks(double velocity_weight, double position_weight, double* out) {
  need_spring_blocks();
  diagonal_blocks(velocity_weight, position_weight, true, out);
}

void Linearisation::diagonal_blocks(double velocity_weight, double position_weight, bool vectors, double* out) const {
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    Block sum = elements_.diagonal(k, velocity_weight, position_weight, vectors);
    for (const Incident* i = layout_.incident_begin(k); i != layout_.incident_end(k); ++i)
      sum += velocity_weight * block(damping_, i->spring) + position_weight * block(stiffness_, i->spring);
    Eigen::Map<Block> result(out + 9 * std::size_t{k});
    result.setIdentity();
    if (constrained_[k] == 0)
      result += block(by_force_, k) * sum - velocity_weight * block(by_velocity_, k) -
                position_weight * block(by_position_, k);
  }
  for (const Bond& bond : bonds_) {
    for (const std::uint32_t k : {bond.first, bond.second}) {
      if (constrained_[k] != 0) continue;
      Eigen::Map<Block>(out + 9 * std::size_t{k}) += position_weight * block(by_force_, k) * bond.stiffness;
    }
  }
  for (const Drag& drag : drags_)
    for_each_dragged(drag, [&](std::uint32_t k, double weight) {
      if (!vectors) return;
      const Vector3& e = drag.row.direction;
      Eigen::Map<Block>(out + 9 * std::size_t{k}) +=
          velocity_weight * drag.damping * weight * weight * block(by_force_, k) * e * e.transpose();
    });
}

// Column 3 j + c has the rows 3 i + r, r = 0, 1, 2, of node j and its neighbours i, sorted.
void Linearisation::make_pattern() {
  const std::uint32_t n = layout_.node_count();
  const std::vector<std::uint32_t>& start = layout_.neighbour_start();
  const std::vector<std::uint32_t>& neighbours = layout_.neighbours();
  system_->matrix.resize(3 * static_cast<Eigen::Index>(n), 3 * static_cast<Eigen::Index>(n));
  system_->matrix.resizeNonZeros(9 * (static_cast<Eigen::Index>(neighbours.size()) + static_cast<Eigen::Index>(n)));
  std::vector<std::uint32_t> rows;
  int at = 0;
  for (std::uint32_t j = 0; j < n; ++j) {
    rows.assign(neighbours.begin() + start[j], neighbours.begin() + start[j + 1]);
    rows.push_back(j);
    std::sort(rows.begin(), rows.end());
    for (int c = 0; c < 3; ++c) {
      system_->matrix.outerIndexPtr()[3 * j + static_cast<std::uint32_t>(c)] = at;
      for (const std::uint32_t i : rows)
        for (int r = 0; r < 3; ++r) system_->matrix.innerIndexPtr()[at++] = static_cast<int>(3 * i) + r;
    }
  }
  system_->matrix.outerIndexPtr()[3 * n] = at;
  std::fill_n(system_->matrix.valuePtr(), at, 0.0);
  system_->factors.analyzePattern(system_->matrix);
  pattern_known_ = true;
}

// Borders the matrix by constraint rows. The pattern is kept while the rows join the same nodes.
void Linearisation::factorise_bound(const std::vector<ConstraintRow>& rows) {
  const auto same = [](const ConstraintRow& a, const ConstraintRow& b) {
    return a.first == b.first && a.second == b.second && a.third == b.third && a.fourth == b.fourth;
  };
  if (!std::equal(rows.begin(), rows.end(), rows_.begin(), rows_.end(), same)) bordered_known_ = false;
  rows_ = rows;
  const Eigen::Index size = system_->matrix.rows(), count = static_cast<Eigen::Index>(rows.size());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(system_->matrix.nonZeros() + 13 * count));
  for (Eigen::Index column = 0; column < size; ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(system_->matrix, column); entry; ++entry)
      entries.emplace_back(static_cast<int>(entry.row()), static_cast<int>(column), entry.value());
  double trace = 0.0;
  for (Eigen::Index r = 0; r < count; ++r) {
    const ConstraintRow& row = rows[static_cast<std::size_t>(r)];
    const int border = static_cast<int>(size + r);
    row.for_each_end([&](std::size_t, std::uint32_t node, double weight) {
      const Vector3 direction = weight * row.direction;
      const Vector3 moved = constrained_[node] != 0 ? Vector3::Zero() : Vector3(block(by_force_, node) * direction);
      trace += direction.dot(moved);
      for (int c = 0; c < 3; ++c) {
        entries.emplace_back(static_cast<int>(3 * node) + c, border, moved[c]);
        entries.emplace_back(border, static_cast<int>(3 * node) + c, direction[c]);
      }
    });
  }
  // Makes redundant rows factorisable; violates the constraints by about 1e-12 of the velocities.
  const double shift = -1e-12 * (trace > 0.0 ? trace / static_cast<double>(count) : 1.0);
  for (Eigen::Index r = 0; r < count; ++r)
    entries.emplace_back(static_cast<int>(size + r), static_cast<int>(size + r), shift);
  system_->bordered.resize(size + count, size + count);
  system_->bordered.setFromTriplets(entries.begin(), entries.end());
  system_->bordered.makeCompressed();
  if (!bordered_known_) system_->bordered_factors.analyzePattern(system_->bordered);
  bordered_known_ = true;
  system_->bordered_factors.factorize(system_->bordered);
}

void Linearisation::fill(double velocity_weight, double position_weight) {
  if (!pattern_known_) make_pattern();
  need_spring_blocks();
  const std::uint32_t n = layout_.node_count();
  double* values = system_->matrix.valuePtr();
  std::fill_n(values, system_->matrix.nonZeros(), 0.0);
  std::vector<double> diagonal(9 * std::size_t{n});
  diagonal_blocks(velocity_weight, position_weight, false, diagonal.data());
  const auto add = [&](std::uint32_t i, std::uint32_t j, const Block& value) {
    const int column = system_->matrix.outerIndexPtr()[3 * j];
    const int height = system_->matrix.outerIndexPtr()[3 * j + 1] - column;
    const int* places = system_->matrix.innerIndexPtr() + column;
    const auto place = static_cast<int>(std::lower_bound(places, places + height, static_cast<int>(3 * i)) - places);
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) values[column + c * height + place + r] += value(r, c);
  };
  for (std::uint32_t j = 0; j < n; ++j) {
    add(j, j, block(diagonal, j));
    for (const Incident* i = layout_.incident_begin(j); i != layout_.incident_end(j); ++i) {
      if (constrained_[i->other] != 0) continue;
      add(i->other, j,
          -(block(by_force_, i->other) *
            (velocity_weight * block(damping_, i->spring) + position_weight * block(stiffness_, i->spring))));
    }
  }
  for (const Bond& bond : bonds_) {
    if (constrained_[bond.first] == 0)
      add(bond.first, bond.second, -position_weight * block(by_force_, bond.first) * bond.stiffness);
    if (constrained_[bond.second] == 0)
      add(bond.second, bond.first, -position_weight * block(by_force_, bond.second) * bond.stiffness);
  }
  if (elements_.any()) {
    elements_.for_each_block(velocity_weight, position_weight,
                             [&](std::uint32_t i, std::uint32_t j, const Block& value) {
                               if (constrained_[i] == 0) add(i, j, block(by_force_, i) * value);
                             });
  }
}

void Linearisation::for_each_entry(double velocity_weight, double position_weight,
                                   const std::function<void(int row, int column, double value)>& visit) {
  fill(velocity_weight, position_weight);
  for (int column = 0; column < system_->matrix.outerSize(); ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(system_->matrix, column); entry; ++entry)
      visit(static_cast<int>(entry.row()), column, entry.value());
}

springnet_status Linearisation::factorise(double velocity_weight, double position_weight,
                                          const std::vector<ConstraintRow>& rows, springnet_message& message) {
  if (!known_) {
    set_message(message, "factorise was called before linearise");
    return SPRINGNET_FAILED;
  }
  fill(velocity_weight, position_weight);
  if (rows.empty()) {
    rows_.clear();
    system_->factors.factorize(system_->matrix);
  } else {
    factorise_bound(rows);
  }
  const auto& factors = rows.empty() ? system_->factors : system_->bordered_factors;
  if (factors.info() != Eigen::Success) {
    set_message(message, fmt::format("the linear system of the step is singular: {}", factors.lastErrorMessage()));
    return SPRINGNET_RECOVERABLE;
  }
  set_vectors(velocity_weight, position_weight);
  if (vectors_.is_singular(plain_solver())) {
    set_message(
        message,
        "the linear system of the step is singular: the stiffness of the enclosed volumes, or friction of "
        "bodies in contact, cancels that of the rest of the network and its inertia; reduce their overpressure");
    return SPRINGNET_RECOVERABLE;
  }
  return SPRINGNET_OK;
}

// Rank-one terms that enclosures and drags add to the factorised matrix.
void Linearisation::set_vectors(double velocity_weight, double position_weight) {
  const std::size_t live = layout_.elements().live_enclosures();
  const Eigen::Index size = system_->matrix.rows() + static_cast<Eigen::Index>(rows_.size());
  const auto count = static_cast<Eigen::Index>(live > 0 ? elements_.vector_count() : 0);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(size, count + static_cast<Eigen::Index>(drags_.size()));
  Eigen::MatrixXd weights = columns;
  if (count > 0) {
    elements_.for_each_vector(
        velocity_weight, position_weight,
        [&](std::size_t enclosure, std::uint32_t node, const Vector3& gradient, const Vector3& weight) {
          const auto column = static_cast<Eigen::Index>(enclosure), at = 3 * static_cast<Eigen::Index>(node);
          if (constrained_[node] == 0) columns.block<3, 1>(at, column) = block(by_force_, node) * gradient;
          weights.block<3, 1>(at, column) = weight;
        });
  }
  for (std::size_t d = 0; d < drags_.size(); ++d)
    for_each_dragged(drags_[d], [&](std::uint32_t k, double weight) {
      const Eigen::Index column = count + static_cast<Eigen::Index>(d), at = 3 * static_cast<Eigen::Index>(k);
      const Vector3 along = weight * drags_[d].row.direction;
      columns.block<3, 1>(at, column) = velocity_weight * drags_[d].damping * (block(by_force_, k) * along);
      weights.block<3, 1>(at, column) = along;
    });
  vectors_.set(std::move(columns), std::move(weights));
}

LowRank::Solve Linearisation::plain_solver() {
  auto& factors = rows_.empty() ? system_->factors : system_->bordered_factors;
  return [&factors](bool transposed, const Eigen::MatrixXd& b) -> Eigen::MatrixXd {
    return transposed ? Eigen::MatrixXd(factors.transpose().solve(b)) : Eigen::MatrixXd(factors.solve(b));
  };
}

Eigen::VectorXd Linearisation::solve_factorised(bool transposed, const Eigen::VectorXd& right_side) {
  const LowRank::Solve plain = plain_solver();
  if (vectors_.empty()) return plain(transposed, right_side);
  // The matrix without the rank-one terms may be far worse conditioned than the whole: refine the solution once.
  const Eigen::SparseMatrix<double>& matrix = rows_.empty() ? system_->matrix : system_->bordered;
  Eigen::VectorXd x = vectors_.solve(transposed, right_side, plain);
  const Eigen::VectorXd product = transposed ? Eigen::VectorXd(matrix.transpose() * x) : Eigen::VectorXd(matrix * x);
  x += vectors_.solve(transposed, right_side - product - vectors_.times(transposed, x), plain);
  return x;
}

springnet_status Linearisation::solve(bool transposed, const double* right_side, double* x,
                                      springnet_message& message) {
  const std::size_t n = layout_.node_count();
  const auto& factors = rows_.empty() ? system_->factors : system_->bordered_factors;
  const auto size = static_cast<Eigen::Index>(3 * n + rows_.size());
  if (factors.info() != Eigen::Success || factors.rows() != size) {
    set_message(message, "solve was called without a factorisation");
    return SPRINGNET_FAILED;
  }
  work_.resize(size);
  const auto at = [](std::size_t k, std::size_t c) { return static_cast<Eigen::Index>(3 * k + c); };
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t c = 0; c < 3; ++c) work_[at(k, c)] = right_side[c * n + k];
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const ConstraintRow& row = rows_[r];
    double rate = 0.0;
    row.for_each_end([&](std::size_t, std::uint32_t node, double weight) {
      rate += weight * row.direction.dot(Vector3(work_.segment<3>(at(node, 0))));
    });
    work_[static_cast<Eigen::Index>(3 * n + r)] = transposed ? 0.0 : rate;
  }
  Eigen::VectorXd solution = solve_factorised(transposed, work_);
  if (transposed) {
    // The right-hand side is b = (r, G r), so its adjoint adds G^T of the rows' solution to the nodes.
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const ConstraintRow& row = rows_[r];
      const double value = solution[static_cast<Eigen::Index>(3 * n + r)];
      row.for_each_end([&](std::size_t, std::uint32_t node, double weight) {
        solution.segment<3>(at(node, 0)) += value * weight * row.direction;
      });
    }
  }
  for (std::size_t i = 0; i < 3 * n; ++i) x[i] = solution[at(i % n, i / n)];
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
