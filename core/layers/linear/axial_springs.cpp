#include "layers/linear/axial_springs.hpp"

#include <algorithm>
#include <cmath>

namespace springnet::layers {

AxialSprings::AxialSprings(const Layout& layout, const Evaluator& evaluator)
    : layout_(layout),
      evaluator_(evaluator),
      linear_kernels_(spring_kernels_for(evaluator.instruction_set())),
      order_(layout),
      segments_(layout, evaluator) {}

void AxialSprings::follow() {
  if (!order_.follow() && is_laid_out_) return;
  is_laid_out_ = false;  // memory may run out below
  const std::vector<Unit>& units = layout_.units();
  begin_.clear();
  std::size_t count = 0;
  for (const SpringsOfUnit& unit : order_.units())
    for (const SpringsOfUnit::Part* part : {&unit.within, &unit.leaving}) {
      begin_.push_back(count);
      count += part->second.size();
    }
  values_.assign(count, Values{});
  by_length_.assign(count, 0.0);
  place_.assign(layout_.spring_count(), 0);
  place_of_slot_.assign(units.size(), {});
  copies_.clear();
  for (std::size_t u = 0; u < units.size(); ++u) {
    place_of_slot_[u].assign(units[u].spring.size(), 0);
    for (const Segment& segment : units[u].segments) {
      for (std::uint32_t slot = segment.begin; slot < segment.begin + segment.count; ++slot) {
        const std::uint32_t s = units[u].spring[slot];
        if (s == no_spring) continue;
        place_of_slot_[u][slot] = place_[s] = static_cast<std::uint32_t>(begin_[2 * u] + order_.units()[u].place[slot]);
      }
    }
    for (const SpringsOfUnit::Incoming& each : order_.units()[u].incoming)
      copies_.emplace_back(static_cast<std::uint32_t>(begin_[2 * u - 1] + each.from),
                           static_cast<std::uint32_t>(begin_[2 * u + 1] + each.place));
  }
  is_laid_out_ = true;
}

bool AxialSprings::update(double time, const NodeArrays& nodes, const std::vector<std::uint8_t>& constrained) {
  follow();
  segments_.reserve();
  const auto units = static_cast<std::int64_t>(layout_.units().size());
  std::vector<std::uint8_t> done(layout_.units().size(), 0);
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t u = 0; u < units; ++u)
    done[static_cast<std::size_t>(u)] = update_unit(static_cast<std::size_t>(u), time, nodes, constrained) ? 1 : 0;
  if (std::find(done.begin(), done.end(), std::uint8_t{0}) != done.end()) return false;
  for (const auto& [from, to] : copies_) {
    values_[to] = values_[from];
    by_length_[to] = by_length_[from];
  }
  return true;
}

bool AxialSprings::update_unit(std::size_t index, double time, const NodeArrays& nodes,
                               const std::vector<std::uint8_t>& constrained) {
  const FlushDenormals flush;  // in every thread
  return segments_.for_each(index, time, nodes, place_of_slot_[index], [&](const AxialAnswers& answers) {
    return linear_kernels_.write_axial(answers, values_.data()->number, by_length_.data()) ||
           is_finite_where_it_matters(answers, constrained);
  });
}

bool AxialSprings::is_finite_where_it_matters(const AxialAnswers& answers,
                                              const std::vector<std::uint8_t>& constrained) const {
  for (std::size_t i = 0; i < answers.count; ++i) {
    const std::uint32_t s = answers.spring[i];
    if (s == no_spring || (constrained[layout_.first(s)] != 0 && constrained[layout_.second(s)] != 0)) continue;
    for (std::size_t k = 0; k < 2; ++k)
      if (answers.tension[k] != nullptr &&
          !std::isfinite(answers.tension[k][i] + answers.by_length[k][i] + answers.by_rate[k][i]))
        return false;
  }
  return true;
}

SpringBlocks AxialSprings::blocks(std::uint32_t spring) const {
  const std::size_t place = place_[spring];
  const double* const from = values_[place].number;
  const Vector3 normal(from[0], from[1], from[2]), across(from[4], from[5], from[6]);
  return {AxialTerms(from[3], across), by_length_[place], from[7], normal};
}

template <class Function>
void AxialSprings::for_each_unit(const Function& function) const {
  const std::vector<Unit>& units = layout_.units();
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t index = 0; index < static_cast<std::int64_t>(units.size()); ++index) {
    const FlushDenormals flush;  // in every thread
    const auto u = static_cast<std::size_t>(index);
    const NodeRange nodes{units[u].first_node, std::size_t{units[u].first_node} + units[u].node_count};
    const SpringsOfUnit& own = order_.units()[u];
    for (const bool is_within : {true, false}) {
      const SpringsOfUnit::Part& part = is_within ? own.within : own.leaving;
      const std::size_t begin = begin_[2 * u + (is_within ? 0 : 1)];
      function(AxialRows{part.start.data(), part.second.data(), values_.data()->number + 8 * begin,
                         by_length_.data() + begin},
               nodes, is_within);
    }
  }
}

void AxialSprings::subtract_transposed(double velocity_weight, double position_weight, const double* x,
                                       double* y) const {
  for_each_unit([&](const AxialRows& rows, NodeRange nodes, bool is_within) {
    linear_kernels_.subtract_transposed(rows, nodes, velocity_weight, position_weight, x, is_within, y);
  });
}

void AxialSprings::subtract_product(const double* p, const double* v, double* y) const {
  for_each_unit([&](const AxialRows& rows, NodeRange nodes, bool is_within) {
    linear_kernels_.subtract_product(rows, nodes, p, v, is_within, y);
  });
}

}  // namespace springnet::layers
