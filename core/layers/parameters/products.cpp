#include "layers/parameters/products.hpp"

#include <omp.h>

#include <algorithm>
#include <array>

#include <springnet/sdk/message.hpp>

#include "layers/parameters/answers.hpp"

namespace springnet::layers {
namespace {

constexpr std::size_t nodes_of_piece = 256;

Vector3 at(const double* values, std::size_t n, std::size_t k) { return {values[k], values[n + k], values[2 * n + k]}; }
void add(double* values, std::size_t n, std::size_t k, const Vector3& change) {
  for (std::size_t c = 0; c < 3; ++c) values[c * n + k] += change[static_cast<Eigen::Index>(c)];
}

// The partial sums of sets with one number, added up piece by piece.
void add_ones(const ResolvedSets& sets, const std::vector<double>& partial) {
  const std::size_t count = sets.sets().size();
  for (std::size_t i = 0; i < count; ++i) {
    if (!sets.sets()[i].is_one()) continue;
    double sum = 0.0;
    for (std::size_t place = i; place < partial.size(); place += count) sum += partial[place];
    sets.sets()[i].values[0] += sum;
  }
}

}  // namespace

std::vector<ParameterPiece> ParameterProducts::pieces_of_laws(const ResolvedSets& sets) const {
  using Of = ParameterPiece::Of;
  std::vector<ParameterPiece> pieces;
  const ElementLayout& elements = layout_.elements();
  for (std::uint32_t g = 0; g < layout_.laws().groups.size(); ++g) {
    if (sets.of(g, false).empty()) continue;
    const std::size_t size = layout_.springs_of(g).size();
    for (std::size_t begin = 0; begin < size; begin += max_segment)
      pieces.push_back({Of::springs, g, begin, std::min(max_segment, size - begin)});
  }
  for (std::size_t b = 0; b < elements.batches().size(); ++b)
    if (!sets.of(elements.batches()[b].group, true).empty())
      pieces.push_back({Of::elements, elements.batches()[b].group, b, elements.batches()[b].count});
  for (std::size_t s = 0; s < elements.enclosures().size(); ++s) {
    const std::uint32_t e = elements.enclosures()[s].element;
    if (elements.alive(e) && !sets.of(elements.group(e), true).empty())
      pieces.push_back({Of::enclosure, elements.group(e), s, 1});
  }
  return pieces;
}

std::vector<ParameterPiece> ParameterProducts::pieces_of_nodes() const {
  std::vector<ParameterPiece> pieces;
  const std::vector<std::uint32_t>& kinds = layout_.neuron_kind();
  for (std::size_t begin = 0; begin < kinds.size();) {
    std::size_t end = begin + 1;
    while (end < kinds.size() && end - begin < nodes_of_piece && kinds[end] == kinds[begin]) ++end;
    pieces.push_back({ParameterPiece::Of::nodes, kinds[begin], begin, end - begin});
    begin = end;
  }
  return pieces;
}

template <class Scratch, class Work>
springnet_status ParameterProducts::for_each(const std::vector<ParameterPiece>& pieces, springnet_message& message,
                                             const Work& work) const {
  const auto count = static_cast<std::int64_t>(pieces.size());
  std::int64_t failed = count;
  springnet_status failure = SPRINGNET_OK;
  const auto threads = static_cast<int>(evaluator_.threads());
#pragma omp parallel num_threads(threads) if (threads > 1)
  {
    const FlushDenormals flush;
    std::unique_ptr<Scratch> scratch;
#pragma omp for schedule(static)
    for (std::int64_t i = 0; i < count; ++i) {
      springnet_message own{};
      // An exception that left the region would end the process.
      const springnet_status status = sdk::detail::guarded(&own, [&] {
        if (!scratch) scratch = std::make_unique<Scratch>(layout_, evaluator_);
        return work(static_cast<std::size_t>(i), *scratch, own);
      });
      if (status == SPRINGNET_OK) continue;
#pragma omp critical(springnet_parameter_products)
      if (i < failed) {
        failed = i;
        failure = status;
        message = own;
      }
    }
  }
  return failure;
}

springnet_status ParameterProducts::force_change(const ResolvedSets& sets, const HeldState& held, double* force,
                                                 double* internal, springnet_message& message) {
  const std::size_t n = layout_.node_count();
  std::fill_n(force, 3 * n, 0.0);
  if (sets.with_states()) std::fill_n(internal, layout_.internal().count(), 0.0);
  const std::vector<ParameterPiece> pieces = pieces_of_laws(sets);
  if (pieces.empty()) return SPRINGNET_OK;
  const bool springs = pieces.front().of == ParameterPiece::Of::springs;
  axial_.assign(springs ? layout_.spring_count() : 0, 0.0);
  along_.assign(springs ? layout_.spring_count() : 0, 0.0);
  generalised_.assign(layout_.elements().count(), 0.0);
  corner_change_.assign(layout_.elements().slot_count(), Vector3::Zero());
  const springnet_status status =
      for_each<LawAnswers>(pieces, message, [&](std::size_t p, LawAnswers& answers, springnet_message& own) {
        const ParameterPiece& piece = pieces[p];
        if (const springnet_status answered = answers.find(piece, sets, held, own); answered != SPRINGNET_OK)
          return answered;
        const bool several = piece.of == ParameterPiece::Of::elements &&
                             reads_several(layout_.elements().batches()[piece.begin].invariant);
        alignas(64) double changes[max_scalars][several_batch];
        if (several) std::fill_n(changes[0], max_scalars * several_batch, 0.0);
        answers.for_each([&](const LawAnswers::Answer& answer) {
          const ParameterSet& set = sets.sets()[answer.set];
          const double change = answer.derivative * set.values[set.is_one() ? 0 : answer.member];
          if (several)
            changes[answer.scalar][answer.place] += change;
          else if (piece.of != ParameterPiece::Of::springs)
            generalised_[answer.member] += change;
          else
            (answer.is_relative ? along_ : axial_)[answer.member] += change;
        });
        if (several)
          answers.for_each_corner(changes, [&](std::uint32_t element, std::size_t corner, const Vector3& change) {
            corner_change_[layout_.elements().slot(element) + corner] = change;
          });
        if (sets.with_states())
          answers.for_each_state([&](std::uint32_t i, std::uint32_t member, std::uint64_t place, double derivative) {
            const ParameterSet& set = sets.sets()[i];
            internal[place] += derivative * set.values[set.is_one() ? 0 : member];
          });
        return springnet_status{SPRINGNET_OK};
      });
  if (status != SPRINGNET_OK) return status;
  if (springs) scatter_springs(held, force);
  scatter_elements(held, force);
  return SPRINGNET_OK;
}

// Each node sums over its springs, so that no two threads write to the same place.
void ParameterProducts::scatter_springs(const HeldState& held, double* force) const {
  layout_.need_incidence();  // before threads do
  const std::size_t n = layout_.node_count();
  const NodeArrays& nodes = held.nodes;
  const auto unit = [](const Vector3& d) {
    const double length = d.norm();
    return length > 0.0 ? Vector3(d / length) : Vector3(Vector3::Zero());
  };
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t node = 0; node < static_cast<std::int64_t>(n); ++node) {
    const auto k = static_cast<std::uint32_t>(node);
    Vector3 sum = Vector3::Zero();
    for (const Incident* i = layout_.incident_begin(k); i != layout_.incident_end(k); ++i) {
      const double axial = axial_[i->spring], along = along_[i->spring];
      const std::uint32_t o = i->other;
      if (axial != 0.0)
        sum -= axial * unit({nodes.px[k] - nodes.px[o], nodes.py[k] - nodes.py[o], nodes.pz[k] - nodes.pz[o]});
      if (along != 0.0)
        sum -= along * unit({nodes.vx[k] - nodes.vx[o], nodes.vy[k] - nodes.vy[o], nodes.vz[k] - nodes.vz[o]});
    }
    add(force, n, k, sum);
  }
}

void ParameterProducts::scatter_elements(const HeldState& held, double* force) const {
  const std::size_t n = layout_.node_count();
  const ElementLayout& elements = layout_.elements();
  Corners corners;
  FirstOrder geometry;
  for (const std::uint32_t e : elements.batched()) {
    const std::span<const std::uint32_t> own = elements.nodes(e);
    for (std::size_t c = 0; reads_several(elements.invariant(e)) && c < own.size(); ++c)
      add(force, n, own[c], corner_change_[elements.slot(e) + c]);
    if (generalised_[e] == 0.0) continue;
    gather(own.data(), own.size(), held.nodes, corners);
    first_order(elements.invariant(e), corners, geometry);
    for (std::size_t i = 0; i < own.size(); ++i) add(force, n, own[i], -generalised_[e] * geometry.gradient[i]);
  }
  for (const ElementLayout::EnclosureElement& enclosure : elements.enclosures()) {
    if (!elements.alive(enclosure.element) || generalised_[enclosure.element] == 0.0) continue;
    for (std::size_t place = 0; place < enclosure.shape.size(); ++place)
      add(force, n, enclosure.shape.nodes()[place],
          -generalised_[enclosure.element] * enclosure.shape.gradient(place, held.nodes));
  }
}

springnet_status ParameterProducts::weigh_forces(const ResolvedSets& sets, const HeldState& held, const double* weights,
                                                 const double* internal_weights, springnet_message& message) {
  const std::vector<ParameterPiece> pieces = pieces_of_laws(sets);
  const std::size_t count = sets.sets().size();
  ones_.assign(pieces.size() * count, 0.0);
  const springnet_status status =
      for_each<LawAnswers>(pieces, message, [&](std::size_t p, LawAnswers& answers, springnet_message& own) {
        if (const springnet_status answered = answers.find(pieces[p], sets, held, own); answered != SPRINGNET_OK)
          return answered;
        answers.weigh(weights, held.nodes);
        answers.for_each_set([&](std::uint32_t i, const auto& for_each_answer) {
          const ParameterSet& set = sets.sets()[i];
          if (set.is_one())
            for_each_answer([sum = &ones_[p * count + i]](const LawAnswers::Answer& answer) {
              *sum += answer.derivative * answer.weight;
            });
          else
            for_each_answer([values = set.values](const LawAnswers::Answer& answer) {
              values[answer.member] += answer.derivative * answer.weight;
            });
        });
        if (sets.with_states())
          answers.for_each_state([&](std::uint32_t i, std::uint32_t member, std::uint64_t place, double derivative) {
            const ParameterSet& set = sets.sets()[i];
            double& sum = set.is_one() ? ones_[p * count + i] : set.values[member];
            sum += derivative * internal_weights[place];
          });
        return springnet_status{SPRINGNET_OK};
      });
  if (status == SPRINGNET_OK) add_ones(sets, ones_);
  return status;
}

springnet_status ParameterProducts::acceleration_change(const ResolvedSets& sets, const HeldState& held,
                                                        const double* force, const double* force_change,
                                                        double* acceleration, springnet_message& message) {
  const std::size_t n = layout_.node_count();
  const std::vector<ParameterPiece> pieces = pieces_of_nodes();
  return for_each<NeuronAnswers>(pieces, message, [&](std::size_t p, NeuronAnswers& answers, springnet_message& own) {
    const ParameterPiece& piece = pieces[p];
    if (const springnet_status status = answers.find(piece, sets, held, force, own); status != SPRINGNET_OK)
      return status;
    for (std::size_t i = 0; i < piece.count; ++i) {
      const std::size_t k = piece.begin + i;
      Vector3 sum = answers.by_force(i) * at(force_change, n, k);
      answers.for_each(i, [&](std::uint32_t set, const Vector3& derivative) {
        const ParameterSet& own_set = sets.sets()[set];
        sum += own_set.values[own_set.is_one() ? 0 : k] * derivative;
      });
      for (std::size_t c = 0; c < 3; ++c) acceleration[c * n + k] = sum[static_cast<Eigen::Index>(c)];
    }
    return springnet_status{SPRINGNET_OK};
  });
}

springnet_status ParameterProducts::weigh_accelerations(const ResolvedSets& sets, const HeldState& held,
                                                        const double* force, const double* weights,
                                                        double* force_weights, springnet_message& message) {
  const std::size_t n = layout_.node_count(), count = sets.sets().size();
  const std::vector<ParameterPiece> pieces = pieces_of_nodes();
  ones_.assign(pieces.size() * count, 0.0);
  const springnet_status status =
      for_each<NeuronAnswers>(pieces, message, [&](std::size_t p, NeuronAnswers& answers, springnet_message& own) {
        const ParameterPiece& piece = pieces[p];
        if (const springnet_status answered = answers.find(piece, sets, held, force, own); answered != SPRINGNET_OK)
          return answered;
        for (std::size_t i = 0; i < piece.count; ++i) {
          const std::size_t k = piece.begin + i;
          const Vector3 weight = at(weights, n, k);
          add(force_weights, n, k, answers.by_force(i).transpose() * weight);
          answers.for_each(i, [&](std::uint32_t set, const Vector3& derivative) {
            const ParameterSet& own_set = sets.sets()[set];
            double& sum = own_set.is_one() ? ones_[p * count + set] : own_set.values[k];
            sum += weight.dot(derivative);
          });
        }
        return springnet_status{SPRINGNET_OK};
      });
  if (status == SPRINGNET_OK) add_ones(sets, ones_);
  return status;
}

}  // namespace springnet::layers
