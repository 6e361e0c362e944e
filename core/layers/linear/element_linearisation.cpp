#include "layers/linear/element_linearisation.hpp"

#include <algorithm>

#include "layers/elements/several.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

// Enclosures come last among the elements of a node.
template <class What>
void for_each_enclosure(std::span<const ElementShare> shares, const What& what) {
  for (std::size_t i = shares.size(); i > 0 && shares[i - 1].enclosure != no_enclosure; --i) what(shares[i - 1]);
}

}  // namespace

// Of one batch at a time.
struct ElementLinearisation::SeveralWork {
  SeveralGeometry geometry;
  SeveralAnswers answers;
  SeveralTangent tangent;
  SeveralRateGradients rate_gradients;
  SeveralBlocks blocks;
  SeveralSpread stiffness, damping;
};

ElementLinearisation::ElementLinearisation(const Layout& layout, const Evaluator& evaluator)
    : layout_(layout), evaluator_(evaluator) {}
ElementLinearisation::~ElementLinearisation() = default;

// Q and its derivatives for elements with the same laws.
springnet_status ElementLinearisation::evaluate_elements(const ElementBatch& batch, double time,
                                                         const NodeArrays& nodes, const std::uint32_t* members,
                                                         const double* q, const double* rate, ElementForce* forces,
                                                         springnet_message& message) {
  const profile::Tile measured;
  const profile::Part part("elements");
  const Group& group = layout_.laws().groups[batch.group];
  const InternalLayout& internal = layout_.internal();
  std::uint32_t rows[element_batch], places[element_batch];
  for (std::size_t i = 0; i < batch.count; ++i) {
    rows[i] = layout_.elements().row(members[i]);
    if (internal.has(batch.group)) places[i] = internal.of_element(members[i]);
  }
  PairAnswers<element_batch> answers;
  const LawBatch laws{group,
                      batch.count,
                      {rows, 0},
                      q,
                      rate,
                      nullptr,
                      {internal, batch.group, nodes, places},
                      nullptr,
                      {CalledMembers::Are::elements, static_cast<std::uint32_t>(batch.count), 1, members}};
  const springnet_status status =
      evaluate_laws(laws, evaluator_.instruction_set(), time, answers.outputs(true, false), message);
  if (status != SPRINGNET_OK) return status;
  for (std::size_t i = 0; i < batch.count; ++i) {
    forces[i] = element_force(group, answers, i, true);
    finite_ = finite_ && forces[i].is_finite();
  }
  return SPRINGNET_OK;
}

void ElementLinearisation::make_pattern() {
  const ElementLayout& elements = layout_.elements();
  const LoadedFaces& faces = layout_.loaded_faces();
  rows_.make(layout_.node_count(), [&](std::uint32_t node, std::vector<std::uint32_t>& columns) {
    elements.add_neighbours(node, columns);
    faces.add_neighbours(node, columns);
  });
  mirrored_.clear();
  for (std::uint32_t node = 0; node < layout_.node_count(); ++node)
    for (std::size_t b = rows_.begin(node); b < rows_.end(node); ++b)
      mirrored_.push_back(rows_.find(rows_.other(b), node));
  targets_.clear();
  for (const std::uint32_t e : elements.batched()) {
    const std::span<const std::uint32_t> own = elements.nodes(e);
    for (const std::uint32_t i : own)
      for (const std::uint32_t j : own) targets_.push_back(rows_.find(i, j));
  }
  enclosure_targets_.clear();
  for (const ElementLayout::EnclosureElement& s : elements.enclosures()) {
    if (!elements.alive(s.element)) continue;
    for (std::size_t place = 0; place < s.shape.size(); ++place)
      for (const Enclosure::Spoke& to : s.shape.spokes(place))
        enclosure_targets_.push_back(rows_.find(s.shape.nodes()[place], to.other));
  }
  face_targets_.clear();
  for (std::uint32_t node = 0; faces.any_following() && node < layout_.node_count(); ++node)
    for (const LoadedFaces::NodeFace& face : faces.faces_at(node))
      for (const std::uint32_t other : {node, face.next, face.last}) face_targets_.push_back(rows_.find(node, other));
  pattern_known_ = true;
}

void ElementLinearisation::add_pressures(const NodeArrays& nodes, const double* pressure) {
  const LoadedFaces& faces = layout_.loaded_faces();
  if (pressure == nullptr || !faces.any_following()) return;
  const std::uint32_t* target = face_targets_.data();
  for (std::uint32_t node = 0; node < layout_.node_count(); ++node)
    for (const LoadedFaces::NodeFace& face : faces.faces_at(node))
      for (const Block& block : LoadedFaces::blocks(node, face, nodes, pressure[face.load]))
        stiffness_[*target++] += block;
}

void ElementLinearisation::add(const ElementBlocks& blocks, std::size_t count, const std::uint32_t* targets) {
  const std::uint32_t* target = targets;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j) stiffness_[*target++] += blocks.stiffness[i][j];
  if (blocks.damping == 0.0) return;
  if (!damped_) damping_.assign(rows_.count(), Block::Zero());
  damped_ = true;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j) damping_[*targets++] += blocks.damping_block(i, j);
}

springnet_status ElementLinearisation::update_several(const ElementBatch& batch, double time, const NodeArrays& nodes,
                                                      const std::uint32_t*& targets, springnet_message& message) {
  const profile::Tile measured;
  const profile::Part part("elements");
  if (several_ == nullptr) several_ = std::make_unique<SeveralWork>();
  SeveralWork& work = *several_;
  const Group& group = layout_.laws().groups[batch.group];
  const InstructionSet set = evaluator_.instruction_set();
  const Kernels& kernels = kernels_for(set);
  const SeveralMembers members = members_of(layout_.elements(), batch);
  kernels.several.geometry(group.scalars, members.corners, members.reference, nodes, group.reads_rate(), work.geometry);
  const springnet_status status =
      evaluate_several(group, members, work.geometry, set, time, SeveralWanted::tangent, work.answers, message);
  if (status != SPRINGNET_OK) return status;
  finite_ = tangent_of(kernels, group, work.answers, batch.count, work.tangent) && finite_;
  if (work.tangent.has_rates && !damped_) {
    damping_.assign(rows_.count(), Block::Zero());
    damped_ = true;
  }
  const auto add = [](Block& block, const double* entries) {
    double* const to = block.data();
    for (std::size_t k = 0; k < 9; ++k) to[k] += entries[k];
  };
  const std::size_t corners = group.scalars.corners;
  for (std::size_t begin = 0; begin < batch.count; begin += several_at_once) {
    const std::size_t count = std::min(several_at_once, batch.count - begin);
    several_blocks(kernels, group.scalars, work.geometry, begin, count, work.tangent, work.rate_gradients, work.blocks);
    kernels.several.spread(work.blocks.stiffness, corners, work.stiffness);
    if (work.tangent.has_rates) kernels.several.spread(work.blocks.damping, corners, work.damping);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t b = 0; b < corners * corners; ++b, ++targets) {
        add(stiffness_[*targets], work.stiffness.entries[i] + 9 * b);
        if (work.tangent.has_rates) add(damping_[*targets], work.damping.entries[i] + 9 * b);
      }
  }
  return SPRINGNET_OK;
}

springnet_status ElementLinearisation::update(double time, const NodeArrays& nodes, const double* pressure,
                                              springnet_message& message) {
  const ElementLayout& elements = layout_.elements();
  finite_ = true;
  if (!any()) return SPRINGNET_OK;
  if (!pattern_known_) make_pattern();
  stiffness_.assign(rows_.count(), Block::Zero());
  damped_ = false;
  Corners corners[element_batch];
  FirstOrder geometry[element_batch];
  double q[element_batch], rate[element_batch];
  ElementForce forces[element_batch];
  ElementBlocks blocks;
  const std::uint32_t* targets = targets_.data();
  for (const ElementBatch& batch : elements.batches()) {
    if (reads_several(batch.invariant)) {
      const springnet_status status = update_several(batch, time, nodes, targets, message);
      if (status != SPRINGNET_OK) return status;
      continue;
    }
    const std::uint32_t* members = elements.batched().data() + batch.begin;
    for (std::size_t i = 0; i < batch.count; ++i) {
      const std::span<const std::uint32_t> own = elements.nodes(members[i]);
      gather(own.data(), own.size(), nodes, corners[i]);
      first_order(batch.invariant, corners[i], geometry[i]);
      q[i] = nearest_turn(batch.invariant, geometry[i].value, elements.reference(members[i]));
      rate[i] = geometry[i].rate;
    }
    const springnet_status status = evaluate_elements(batch, time, nodes, members, q, rate, forces, message);
    if (status != SPRINGNET_OK) return status;
    const std::size_t count = corners_of(batch.invariant);
    for (std::size_t i = 0; i < batch.count; ++i, targets += count * count) {
      linearise(batch.invariant, corners[i], geometry[i], forces[i], blocks);
      add(blocks, count, targets);
    }
  }
  add_pressures(nodes, pressure);
  return update_enclosures(time, nodes, message);
}

springnet_status ElementLinearisation::update_enclosures(double time, const NodeArrays& nodes,
                                                         springnet_message& message) {
  const ElementLayout& elements = layout_.elements();
  enclosures_.resize(elements.enclosures().size());
  const std::uint32_t* target = enclosure_targets_.data();
  for (std::size_t s = 0; s < enclosures_.size(); ++s) {
    const std::uint32_t e = elements.enclosures()[s].element;
    if (!elements.alive(e)) continue;
    const Enclosure& enclosure = elements.enclosures()[s].shape;
    EnclosureDerivatives& own = enclosures_[s];
    const Enclosure::Values values = enclosure.values(nodes);
    const springnet_status status = evaluate_elements({Invariant::enclosed_volume, elements.group(e), 0, 1}, time,
                                                      nodes, &e, &values.volume, &values.rate, &own.law, message);
    if (status != SPRINGNET_OK) return status;
    own.gradient.resize(enclosure.size());
    own.rate_gradient.resize(enclosure.size());
    for (std::size_t place = 0; place < enclosure.size(); ++place) {
      own.gradient[place] = enclosure.gradient(place, nodes);
      own.rate_gradient[place] = enclosure.rate_gradient(place, nodes);
      for (const Enclosure::Spoke& to : enclosure.spokes(place))
        stiffness_[*target++] += cross_matrix(own.law.force * Enclosure::across(to, nodes));
    }
  }
  return SPRINGNET_OK;
}

void ElementLinearisation::prepare(const double* dp, const double* dv) {
  const ElementLayout& elements = layout_.elements();
  const std::size_t n = layout_.node_count();
  const auto at = [n](const double* values, std::size_t k) {
    return Vector3(values[k], values[n + k], values[2 * n + k]);
  };
  for (std::size_t s = 0; s < enclosures_.size(); ++s) {
    EnclosureDerivatives& own = enclosures_[s];
    own.product = 0.0;
    if (!elements.alive(elements.enclosures()[s].element)) continue;
    const std::vector<std::uint32_t>& nodes = elements.enclosures()[s].shape.nodes();
    for (std::size_t place = 0; place < nodes.size(); ++place) {
      const Vector3 p = at(dp, nodes[place]), v = at(dv, nodes[place]);
      own.product += own.law.by_q * own.gradient[place].dot(p) +
                     own.law.by_rate * (own.rate_gradient[place].dot(p) + own.gradient[place].dot(v));
    }
  }
}

Vector3 ElementLinearisation::force(std::uint32_t node, const double* dp, const double* dv) const {
  const ElementLayout& elements = layout_.elements();
  const std::size_t n = layout_.node_count();
  const auto at = [n](const double* values, std::size_t k) {
    return Vector3(values[k], values[n + k], values[2 * n + k]);
  };
  Vector3 sum = Vector3::Zero();
  const std::size_t begin = rows_.begin(node), end = rows_.end(node);
  for (std::size_t b = begin; b < end; ++b) sum -= stiffness_[b] * at(dp, rows_.other(b));
  if (damped_)
    for (std::size_t b = begin; b < end; ++b) sum -= damping_[b] * at(dv, rows_.other(b));
  for_each_enclosure(elements.shares(node), [&](const ElementShare& share) {
    const EnclosureDerivatives& own = enclosures_[share.enclosure];
    sum -= own.product * own.gradient[share.place];
  });
  return sum;
}

void ElementLinearisation::prepare_transposed(const double* weights) {
  const ElementLayout& elements = layout_.elements();
  const std::size_t n = layout_.node_count();
  for (std::size_t s = 0; s < enclosures_.size(); ++s) {
    EnclosureDerivatives& own = enclosures_[s];
    own.product = 0.0;
    if (!elements.alive(elements.enclosures()[s].element)) continue;
    const std::vector<std::uint32_t>& nodes = elements.enclosures()[s].shape.nodes();
    for (std::size_t place = 0; place < nodes.size(); ++place) {
      const std::uint32_t k = nodes[place];
      own.product += own.gradient[place].dot(Vector3(weights[k], weights[n + k], weights[2 * n + k]));
    }
  }
}

void ElementLinearisation::add_transposed(std::uint32_t node, const double* weights, Vector3& by_position,
                                          Vector3& by_velocity) const {
  const std::size_t n = layout_.node_count();
  for (std::size_t b = rows_.begin(node); b < rows_.end(node); ++b) {
    const std::uint32_t other = rows_.other(b);
    const std::uint32_t mirrored = mirrored_[b];
    const Vector3 weight(weights[other], weights[n + other], weights[2 * n + other]);
    by_position -= stiffness_[mirrored].transpose() * weight;
    if (damped_) by_velocity -= damping_[mirrored].transpose() * weight;
  }
  for_each_enclosure(layout_.elements().shares(node), [&](const ElementShare& share) {
    const EnclosureDerivatives& own = enclosures_[share.enclosure];
    const Vector3 &g = own.gradient[share.place], &h = own.rate_gradient[share.place];
    by_position -= own.product * (own.law.by_q * g + own.law.by_rate * h);
    by_velocity -= own.product * own.law.by_rate * g;
  });
}

void ElementLinearisation::track(const double* const u[3]) {
  const ElementLayout& elements = layout_.elements();
  for (std::size_t s = 0; s < enclosures_.size(); ++s) {
    EnclosureDerivatives& own = enclosures_[s];
    own.product = 0.0;
    if (!elements.alive(elements.enclosures()[s].element)) continue;
    const std::vector<std::uint32_t>& nodes = elements.enclosures()[s].shape.nodes();
    for (std::size_t place = 0; place < nodes.size(); ++place)
      own.product += weight_of(own, place).dot(Vector3(u[0][nodes[place]], u[1][nodes[place]], u[2][nodes[place]]));
  }
}

void ElementLinearisation::add_change(std::uint32_t node, const Vector3& change) {
  if (enclosures_.empty()) return;
  for_each_enclosure(layout_.elements().shares(node), [&](const ElementShare& share) {
    EnclosureDerivatives& own = enclosures_[share.enclosure];
    own.product += weight_of(own, share.place).dot(change);
  });
}

Vector3 ElementLinearisation::off_diagonal_force(std::uint32_t node, const double* const u[3]) const {
  const auto at = [&](std::uint32_t k) { return Vector3(u[0][k], u[1][k], u[2][k]); };
  Vector3 sum = Vector3::Zero();
  for (std::size_t b = rows_.begin(node); b < rows_.end(node); ++b) {
    const std::uint32_t other = rows_.other(b);
    if (other == node) continue;
    sum -= position_weight_ * (stiffness_[b] * at(other));
    if (damped_) sum -= velocity_weight_ * (damping_[b] * at(other));
  }
  if (enclosures_.empty()) return sum;
  for_each_enclosure(layout_.elements().shares(node), [&](const ElementShare& share) {
    const EnclosureDerivatives& own = enclosures_[share.enclosure];
    sum -= (own.product - weight_of(own, share.place).dot(at(node))) * own.gradient[share.place];
  });
  return sum;
}

Block ElementLinearisation::diagonal(std::uint32_t node, double velocity_weight, double position_weight,
                                     bool vectors) const {
  Block sum = Block::Zero();
  if (!any()) return sum;
  const std::span<const ElementShare> shares = layout_.elements().shares(node);
  const std::size_t own_block = rows_.begin(node);
  if (own_block == rows_.end(node)) return sum;
  sum = position_weight * stiffness_[own_block];
  if (damped_) sum += velocity_weight * damping_[own_block];
  if (!vectors) return sum;
  for_each_enclosure(shares, [&](const ElementShare& share) {
    const EnclosureDerivatives& own = enclosures_[share.enclosure];
    const Vector3& g = own.gradient[share.place];
    const Vector3 weight = (position_weight * own.law.by_q + velocity_weight * own.law.by_rate) * g +
                           position_weight * own.law.by_rate * own.rate_gradient[share.place];
    sum += g * weight.transpose();
  });
  return sum;
}

}  // namespace springnet::layers
