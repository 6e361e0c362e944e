#include "layers/linear/block_system.hpp"

#include <algorithm>
#include <cmath>

#include "layers/block.hpp"

namespace springnet::layers {
std::uint32_t BlockSystem::find(std::uint32_t row, std::uint32_t column) const noexcept {
  const auto first = column_.begin() + start_[row], last = column_.begin() + start_[row + 1];
  return static_cast<std::uint32_t>(std::lower_bound(first, last, column) - column_.begin());
}

void BlockSystem::make_pattern(Linearisation& derivatives) {
  const std::uint32_t n = layout_.node_count();
  const std::vector<std::uint32_t>& neighbour_start = layout_.neighbour_start();
  const std::vector<std::uint32_t>& neighbours = layout_.neighbours();
  start_.assign(1, 0);
  column_.clear();
  own_.resize(n);
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::size_t begin = column_.size();
    column_.insert(column_.end(), neighbours.begin() + neighbour_start[k], neighbours.begin() + neighbour_start[k + 1]);
    column_.push_back(k);
    std::sort(column_.begin() + static_cast<std::ptrdiff_t>(begin), column_.end());
    start_.push_back(static_cast<std::uint32_t>(column_.size()));
    own_[k] = find(k, k);
  }
  transposed_.resize(column_.size());
  for (std::uint32_t k = 0; k < n; ++k)
    for (std::uint32_t b = start_[k]; b < start_[k + 1]; ++b) transposed_[b] = find(column_[b], k);
  values_.resize(9 * column_.size() + 1);
  spring_places_.clear();
  for (std::uint32_t k = 0; k < n; ++k) {
    spring_places_.resize(static_cast<std::size_t>(layout_.incident_begin(k) - layout_.incident_begin(0)));
    for (const Incident* i = layout_.incident_begin(k); i != layout_.incident_end(k); ++i)
      spring_places_.push_back(find(k, i->other));
  }
  element_places_.clear();
  if (derivatives.elements().any()) {
    const BlockRows& rows = derivatives.elements().rows();
    for (std::uint32_t k = 0; k < n; ++k)
      for (std::size_t b = rows.begin(k); b < rows.end(k); ++b) element_places_.push_back(find(k, rows.other(b)));
  }
  pattern_known_ = true;
}

void BlockSystem::assemble(Linearisation& derivatives, const SystemWeights& weights) {
  layout_.need_incidence();
  derivatives.need_spring_blocks();  // before threads do
  if (!pattern_known_) make_pattern(derivatives);
#pragma omp parallel num_threads(static_cast <int>(threads_)) if (threads_ > 1)
  {
    const FlushDenormals flush;  // as the calling thread does
#pragma omp for schedule(static)
    for (std::int64_t k = 0; k < static_cast<std::int64_t>(layout_.node_count()); ++k)
      assemble_row(static_cast<std::uint32_t>(k), derivatives, weights);
  }
  for (const Linearisation::Bond& bond : derivatives.bonds()) {
    for (const auto& [k, other] : {std::pair(bond.first, bond.second), std::pair(bond.second, bond.first)}) {
      if (constrained_[k] != 0) continue;
      const Block own = weights.position * mass_[k] * derivatives.by_force(k) * bond.stiffness;
      block(own_[k]) += own;
      if (constrained_[other] == 0) block(find(k, other)) -= own;
    }
  }
  terms_.clear();
  add_enclosures(derivatives, weights);
  add_drags(derivatives, weights);
  measure();
}

void BlockSystem::assemble_row(std::uint32_t k, const Linearisation& derivatives, const SystemWeights& weights) {
  std::fill(values_.begin() + 9 * static_cast<std::ptrdiff_t>(start_[k]),
            values_.begin() + 9 * static_cast<std::ptrdiff_t>(start_[k + 1]), 0.0);
  const double m = mass_[k];
  if (constrained_[k] != 0) {
    block(own_[k]) = m * Columns::Identity();
    return;
  }
  // -dF/dv and -dF/dp of the node, weighted: blocks with itself and with its neighbours.
  Block own = Block::Zero();
  const std::uint32_t* place = spring_places_.data() + (layout_.incident_begin(k) - layout_.incident_begin(0));
  for (const Incident* i = layout_.incident_begin(k); i != layout_.incident_end(k); ++i, ++place) {
    const Block spring = derivatives.weighted(i->spring, weights.velocity, weights.position);
    own += spring;
    if (constrained_[i->other] == 0) block(*place) -= spring;
  }
  if (!element_places_.empty()) {
    const ElementLinearisation& elements = derivatives.elements();
    const BlockRows& rows = elements.rows();
    for (std::size_t b = rows.begin(k); b < rows.end(k); ++b) {
      const std::uint32_t other = rows.other(b);
      const Block element = elements.weighted(b, weights.velocity, weights.position);
      if (other == k)
        own += element;
      else if (constrained_[other] == 0)
        block(element_places_[b]) += element;
    }
  }
  const Block by_force = m * derivatives.by_force(k);
  if (!((by_force - Block::Identity()).cwiseAbs().maxCoeff() <= point_mass_rounding)) {
    for (std::uint32_t b = start_[k]; b < start_[k + 1]; ++b) block(b) = Columns(by_force * block(b));
    own = by_force * own;
  }
  own -= m * (weights.velocity * derivatives.by_velocity(k) + weights.position * derivatives.by_position(k));
  own.diagonal().array() += m * (1.0 + weights.shift);
  block(own_[k]) += own;
}

void BlockSystem::add_enclosures(const Linearisation& derivatives, const SystemWeights& weights) {
  if (layout_.elements().live_enclosures() == 0) return;
  std::vector<std::uint32_t> index(derivatives.elements().vector_count(), 0xffffffffu);
  derivatives.elements().for_each_vector(
      weights.velocity, weights.position,
      [&](std::size_t enclosure, std::uint32_t node, const Vector3& gradient, const Vector3& weight) {
        if (index[enclosure] == 0xffffffffu) {
          index[enclosure] = static_cast<std::uint32_t>(terms_.size());
          terms_.emplace_back();
          terms_.back().stiffness =
              derivatives.elements().vector_stiffness(enclosure, weights.velocity, weights.position);
        }
        if (constrained_[node] != 0) return;
        RankOne& term = terms_[index[enclosure]];
        const Block by_force = mass_[node] * derivatives.by_force(node);
        const bool plain = (by_force - Block::Identity()).cwiseAbs().maxCoeff() <= point_mass_rounding;
        term.nodes.push_back(node);
        term.g.push_back(plain ? gradient : Vector3(by_force * gradient));
        term.w.push_back(weight);
      });
}

void BlockSystem::add_drags(const Linearisation& derivatives, const SystemWeights& weights) {
  for (const Linearisation::Drag& drag : derivatives.drags()) {
    RankOne term;
    term.stiffness = weights.velocity * drag.damping;
    drag.row.for_each_end([&](std::size_t, std::uint32_t node, double weight) {
      if (constrained_[node] != 0) return;
      const Vector3 along = weight * drag.row.direction;
      term.nodes.push_back(node);
      term.g.push_back(mass_[node] * derivatives.by_force(node) * along);
      term.w.push_back(term.stiffness * along);
    });
    if (!term.nodes.empty()) terms_.push_back(std::move(term));
  }
}

void BlockSystem::measure() {
  double asymmetric = 0.0, all = 0.0;
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    if (constrained_[k] != 0) continue;
    for (std::uint32_t b = start_[k]; b < start_[k + 1]; ++b) {
      if (column_[b] > k) continue;
      const double pair = column_[b] < k ? 2.0 : 1.0;
      all += pair * block(b).squaredNorm();
      asymmetric += pair * (block(b) - block(transposed_[b]).transpose()).squaredNorm();
    }
  }
  for (const RankOne& term : terms_) {
    double gg = 0.0, ww = 0.0, gw = 0.0;
    for (std::size_t i = 0; i < term.nodes.size(); ++i) {
      gg += term.g[i].squaredNorm();
      ww += term.w[i].squaredNorm();
      gw += term.g[i].dot(term.w[i]);
    }
    all += gg * ww;
    asymmetric += 2.0 * std::max(0.0, gg * ww - gw * gw);
  }
  asymmetry_ = all > 0.0 ? std::sqrt(asymmetric / all) : 0.0;
}

}  // namespace springnet::layers
