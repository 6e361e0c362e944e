// Changes of the values that laws and neurons read, while the network is simulated.
//
// A spring or element that is changed gets a row of its own in its group; the rows that were there at first stay as
// they are. Where units hold copies of values, a change writes them in place: a segment whose springs shared a row, or
// some columns of it, first gets an array for each column. So the layout, and with it the order of every sum, stays.
// Only a law that prepares something of its parameters needs another group, in which its springs are laid out anew.
#include "layers/layout.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

#include "layers/layout_units.hpp"
#include "layers/ordering.hpp"

namespace springnet::layers {

void Layout::remember_original() {
  if (original_) return;
  auto original = std::make_unique<Original>();
  original->group = laws_.group;
  original->row = laws_.row;
  original->element_group = laws_.element_group;
  original->element_row = laws_.element_row;
  original->neuron_kind = neuron_kind_;
  original->groups = laws_.groups.size();
  original->neurons = laws_.neurons.size();
  original->signals = laws_.signals->count();
  original_ = std::move(original);
}

void Layout::take_back_changes() {
  if (!original_) return;
  laws_.group = std::move(original_->group);
  laws_.row = std::move(original_->row);
  laws_.element_group = std::move(original_->element_group);
  laws_.element_row = std::move(original_->element_row);
  neuron_kind_ = std::move(original_->neuron_kind);
  laws_.groups.erase(laws_.groups.begin() + static_cast<std::ptrdiff_t>(original_->groups), laws_.groups.end());
  laws_.neurons.erase(laws_.neurons.begin() + static_cast<std::ptrdiff_t>(original_->neurons), laws_.neurons.end());
  laws_.signals->drop_constants_from(original_->signals);
  internal_.drop_groups_from(original_->groups);
  for (Group& group : laws_.groups) {
    if (group.row_count() == group.first_rows) continue;
    for (Column<double>& column : group.columns.own()) {
      Column<double> first;
      first.reserve(group.first_rows);
      for (std::size_t row = 0; row < group.first_rows; ++row) first.push_back(column[row]);
      column = std::move(first);
    }
  }
  original_.reset();
  variant_users_.clear();
  neuron_users_.clear();
  free_neurons_.clear();
  units_due_.clear();
  elements_due_ = all_due_ = true;
  ++value_revision_;
}

// A copy of a row, which is then the spring's or element's own. Both groups have the same laws.
std::uint32_t Layout::add_row(std::uint32_t to_group, std::uint32_t from_group, std::uint32_t row) {
  Group& to = laws_.groups[to_group];
  const auto added = static_cast<std::uint32_t>(to.row_count());
  for (std::size_t c = 0; c < to.columns.size(); ++c) {
    const double value = laws_.groups[from_group].columns[c][row];
    to.columns.own()[c].push_back(value);
  }
  return added;
}

std::shared_ptr<const Prepared> Layout::prepare(const Group& group, std::uint32_t row, const ValueChange& change) {
  const Law& law = *group.laws()[change.law];
  if (!law.prepared || change.column < law.first_column || change.column >= law.first_column + law.parameter_count)
    return nullptr;
  std::vector<double> parameters;
  for (std::size_t k = 0; k < law.parameter_count; ++k)
    parameters.push_back(law.first_column + k == change.column ? change.value
                                                               : group.columns[law.first_column + k][row]);
  return prepared_.of(law.component, parameters, law.tables);
}

// The group with the same laws of which one has other tables.
std::uint32_t Layout::variant_of(std::uint32_t group, const ValueChange& change) {
  const Group& from = laws_.groups[group];
  const auto prepared_in = [](const Group& each, std::size_t law) { return each.laws()[law]->prepared.get(); };
  const std::size_t first = original_->groups;
  std::size_t place = laws_.groups.size();
  for (std::size_t g = first; g < laws_.groups.size(); ++g) {
    const Group& other = laws_.groups[g];
    if (other.spring.component != from.spring.component || other.viscosity.component != from.viscosity.component ||
        internal_of(g) != internal_of(group))
      continue;
    if (variant_users_[g - first] == 0) {
      place = g;
    } else if (prepared_in(other, change.law) == change.prepared.get() &&
               prepared_in(other, 1 - change.law) == prepared_in(from, 1 - change.law)) {
      return static_cast<std::uint32_t>(g);
    }
  }
  Group variant = from;
  (change.law == 0 ? variant.spring : variant.viscosity).prepared = change.prepared;
  for (Column<double>& column : variant.columns.own()) column = {};
  variant.first_rows = 0;
  if (place < laws_.groups.size()) {
    laws_.groups[place] = std::move(variant);
    return static_cast<std::uint32_t>(place);
  }
  laws_.groups.push_back(std::move(variant));
  variant_users_.push_back(0);
  internal_.add_group_like(group);
  return static_cast<std::uint32_t>(place);
}

// Where the states of a group's laws begin.
std::uint64_t Layout::internal_of(std::size_t group) const noexcept {
  return internal_.has(group) ? internal_.group(group).first : 0;
}

// A member moves to another group.
void Layout::count_variants(std::uint32_t from, std::uint32_t to) noexcept {
  if (from >= original_->groups) --variant_users_[from - original_->groups];
  ++variant_users_[to - original_->groups];
}

void Layout::set_spring_value(std::uint32_t spring, const ValueChange& change) {
  remember_original();
  ++value_revision_;
  const std::uint32_t group = laws_.group[spring], row = laws_.row[spring];
  const bool moves = change.prepared && change.prepared != laws_.groups[group].laws()[change.law]->prepared;
  const std::uint32_t next = moves ? variant_of(group, change) : group;
  if (moves || row < laws_.groups[group].first_rows) {
    laws_.row.set(spring, add_row(next, group, row), spring_count());
    if (moves) {
      laws_.group.own().set(spring, next);
      count_variants(group, next);
    }
    update_incidence(spring);
  }
  laws_.groups[next].columns.own()[change.column].set(laws_.row[spring], change.value);
  if (moves) forget_springs_of_groups();
  if (!alive(spring) || all_due_) return;
  for_units_of(spring, [&](std::uint32_t unit, const UnitSpring& seen) {
    if (moves)
      units_due_.push_back(unit);
    else
      write_value(unit, seen.own, spring, change);
  });
}

void Layout::write_value(std::uint32_t unit_number, std::uint32_t own, std::uint32_t spring,
                         const ValueChange& change) {
  Unit& unit = units_[unit_number];
  const Tile& tile = unit.tiles[(own - unit.first_node) / tile_nodes];
  if (tile.segment_begin == tile.segment_end) return;
  const Segment& last = unit.segments[tile.segment_end - 1];
  const auto begin = unit.spring.begin() + unit.segments[tile.segment_begin].begin;
  const auto found = std::find(begin, unit.spring.begin() + last.begin + last.count, spring);
  const auto place = static_cast<std::uint32_t>(found - unit.spring.begin());
  std::uint32_t s = tile.segment_begin;
  while (place >= unit.segments[s].begin + unit.segments[s].count) ++s;
  Segment& segment = unit.segments.own()[s];
  if (laws_.group[spring] != segment.group) return;  // it is laid out again
  const Group& group = laws_.groups[segment.group];
  if (segment.row == mixed_rows && segment.value_columns == group.columns.size()) {
    unit.values.own()[segment.value_begin + change.column * segment.count + (place - segment.begin)] = change.value;
    unit.settle_value(s, change.column, place - segment.begin);
    return;
  }
  segment.row = mixed_rows;
  std::vector<double>& values = unit.values.own();
  segment.value_begin = values.size();
  segment.value_columns = static_cast<std::uint32_t>(group.columns.size());
  for (const Column<double>& column : group.columns) {
    for (std::uint32_t slot = segment.begin; slot < segment.begin + segment.count; ++slot) {
      const std::uint32_t other = unit.spring[slot];
      values.push_back(other == no_spring ? 0.0 : column[laws_.row[other]]);
    }
  }
  unit.settle_values(s);
}

void Layout::forget_springs_of_groups() {
  if (found_.is_shared()) found_ = Shared<Found>();
  found_->has_springs.store(false, std::memory_order_relaxed);
}

// Group and row of a live spring, in the lists of its ends.
void Layout::update_incidence(std::uint32_t spring) {
  if (!found_->has_incidence.load(std::memory_order_relaxed) || !alive(spring)) return;
  if (found_.is_shared()) {  // found anew when asked for
    found_ = Shared<Found>();
    return;
  }
  for (const std::uint32_t node : {first(spring), second(spring)}) {
    Incident* const begin = found_->incident.data() + found_->incident_start[node];
    Incident* const end = found_->incident.data() + found_->incident_stop[node];
    Incident* const found = std::find_if(begin, end, [&](const Incident& each) { return each.spring == spring; });
    const bool moves = found->group != laws_.group[spring];
    found->group = laws_.group[spring];
    found->row = laws_.row[spring];
    if (!moves) continue;
    std::sort(begin, end, [](const Incident& a, const Incident& b) {
      return std::pair(a.group, a.spring) < std::pair(b.group, b.spring);
    });
  }
}

void Layout::set_element_value(std::uint32_t element, const ValueChange& change) {
  remember_original();
  ++value_revision_;
  const std::uint32_t group = laws_.element_group[element], row = laws_.element_row[element];
  const bool moves = change.prepared && change.prepared != laws_.groups[group].laws()[change.law]->prepared;
  const std::uint32_t next = moves ? variant_of(group, change) : group;
  if (moves || row < laws_.groups[group].first_rows) {
    laws_.element_row.own().set(element, add_row(next, group, row));
    laws_.element_group.own().set(element, next);
    if (moves) count_variants(group, next);
  }
  laws_.groups[next].columns.own()[change.column].set(laws_.element_row[element], change.value);
  if (moves)
    elements_due_ = true;
  else if (!elements_due_)
    elements_.row_changed(element);
}

// Signals that were added for one input of one spring or element.
bool Layout::is_private(double signal) const noexcept {
  return original_ && signal >= static_cast<double>(original_->signals);
}

void Layout::set_spring_input(std::uint32_t spring, std::size_t column, double value) {
  remember_original();
  ++value_revision_;
  const double signal = laws_.groups[laws_.group[spring]].columns[column][laws_.row[spring]];
  if (is_private(signal))
    signals().set_constant(static_cast<std::uint32_t>(signal), value);
  else
    set_spring_value(spring, {column, static_cast<double>(signals().add_constant(value))});
}

void Layout::set_element_input(std::uint32_t element, std::size_t column, double value) {
  remember_original();
  ++value_revision_;
  const double signal = laws_.groups[laws_.element_group[element]].columns[column][laws_.element_row[element]];
  if (is_private(signal))
    signals().set_constant(static_cast<std::uint32_t>(signal), value);
  else
    set_element_value(element, {column, static_cast<double>(signals().add_constant(value))});
}

// Nodes that get the same value share a neuron, as before.
void Layout::set_neuron_parameter(std::span<const std::uint32_t> nodes, std::size_t parameter,
                                  std::span<const double> values) {
  remember_original();
  ++value_revision_;
  if (neuron_users_.empty()) {
    neuron_users_.assign(laws_.neurons.size(), 0);
    for (const std::uint32_t kind : neuron_kind_) ++neuron_users_[kind];
  }
  std::map<std::pair<std::uint32_t, std::uint64_t>, std::uint32_t> made;
  std::vector<std::uint32_t> left;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    std::uint32_t& kind = neuron_kind_.own()[nodes[i]];
    const double value = values[values.size() == 1 ? 0 : i];
    if (detail::SameBits<double>::of(laws_.neurons[kind].parameters[parameter], value)) continue;
    if (kind >= original_->neurons && neuron_users_[kind] == 1) {
      laws_.neurons[kind].parameters[parameter] = value;
      continue;
    }
    const auto [known, is_new] = made.try_emplace({kind, std::bit_cast<std::uint64_t>(value)}, kind);
    if (is_new) {
      NeuronKind next = laws_.neurons[kind];
      next.parameters[parameter] = value;
      if (free_neurons_.empty()) {
        known->second = static_cast<std::uint32_t>(laws_.neurons.size());
        laws_.neurons.push_back(std::move(next));
        neuron_users_.push_back(0);
      } else {
        known->second = free_neurons_.back();
        free_neurons_.pop_back();
        laws_.neurons[known->second] = std::move(next);
      }
    }
    if (--neuron_users_[kind] == 0 && kind >= original_->neurons) left.push_back(kind);
    kind = known->second;
    ++neuron_users_[kind];
  }
  free_neurons_.insert(free_neurons_.end(), left.begin(), left.end());
}

void Layout::settle_changes() {
  std::sort(units_due_.begin(), units_due_.end());
  units_due_.erase(std::unique(units_due_.begin(), units_due_.end()), units_due_.end());
  for (const std::uint32_t unit : units_due_) lay_out_again(units_[unit]);
  if (!units_due_.empty()) ++revision_;
  units_due_.clear();
  if (elements_due_) {
    elements_.groups_changed();
    ++revision_;
  }
  elements_due_ = false;
  prepared_ = {};
}

void Layout::take_over_row(const Layout& before, std::uint32_t member, bool is_element) {
  const auto place = [&](const Layout& of) {
    return is_element ? std::pair(of.laws_.element_group[member], of.laws_.element_row[member])
                      : std::pair(of.laws_.group[member], of.laws_.row[member]);
  };
  const auto [group_before, row_before] = place(before);
  const Group& from = before.laws_.groups[group_before];
  if (row_before < from.first_rows) return;
  for (std::size_t c = 0; c < from.columns.size(); ++c) {
    const double value = from.columns[c][row_before];
    if (c >= from.spring.first_input_column) {
      if (!before.is_private(value)) continue;
      const double input = before.signals().at(static_cast<std::uint32_t>(value), 0.0);
      is_element ? set_element_input(member, c, input) : set_spring_input(member, c, input);
      continue;
    }
    const auto [group, row] = place(*this);
    if (detail::SameBits<double>::of(laws_.groups[group].columns[c][row], value)) continue;
    ValueChange change{c, value, 0, {}};
    const Law& viscosity = laws_.groups[group].viscosity;
    if (viscosity && c >= viscosity.first_column) change.law = 1;
    change.prepared = prepare(laws_.groups[group], row, change);
    is_element ? set_element_value(member, change) : set_spring_value(member, change);
  }
}

void Layout::take_over(const Layout& before, const NumbersBefore& numbers) {
  // Laid out once all is known, as where a state is restored: sums have the same order.
  all_due_ = before.original_ != nullptr;
  for (std::uint32_t s = 0; s < before.spring_count() && before.original_; ++s) take_over_row(before, s, false);
  for (std::uint32_t e = 0; e < before.elements_.count() && before.original_; ++e) take_over_row(before, e, true);
  numbers.for_each_node([&](std::uint32_t k, std::uint32_t old) {
    if (!before.original_ || before.neuron_kind_[old] == before.original_->neuron_kind[old]) return;
    const std::vector<double> parameters = before.laws_.neurons[before.neuron_kind_[old]].parameters;
    for (std::size_t p = 0; p < parameters.size(); ++p) set_neuron_parameter({&k, 1}, p, {&parameters[p], 1});
  });
  settle_changes();
  if (all_due_) put_back_all();
  const auto removed = [](auto count, const auto& alive) {
    std::vector<decltype(count)> list;
    for (decltype(count) i = 0; i < count; ++i)
      if (!alive(i)) list.push_back(i);
    return list;
  };
  remove(removed(static_cast<std::uint32_t>(before.spring_count()), [&](std::uint32_t s) { return before.alive(s); }));
  remove_elements(removed(static_cast<std::uint32_t>(before.elements_.count()),
                          [&](std::uint32_t e) { return before.elements_.alive(e); }));
  remove_faces(removed(before.loaded_faces_.count(), [&](std::size_t f) { return before.loaded_faces_.alive(f); }));
}

// A spring or element in an archive: the values of its row; of inputs the number of a signal, or the value of a private
// one. They are in memory of all rows.
struct Layout::ChangedRow {
  std::uint32_t number = 0;
  double* values = nullptr;            // [column]
  std::uint8_t* is_private = nullptr;  // [column]
  std::size_t count = 0;               // of its columns
  std::shared_ptr<const Prepared> prepared[2];
};

void Layout::archive_row(Archive& archive, ChangedRow& changed, std::uint32_t first_group) const {
  const Group& group = laws_.groups[first_group];
  changed.count = group.columns.size();
  for (std::size_t c = 0; c < changed.count; ++c) {
    double& value = changed.values[c];
    const bool is_input = c >= group.spring.first_input_column;
    bool own = is_input && is_private(value);
    if (own) value = laws_.signals->at(static_cast<std::uint32_t>(value), 0.0);
    if (is_input) archive.flag(own);
    archive.number(value);
    changed.is_private[c] = own ? 1 : 0;
    if (!archive.reads()) continue;
    const std::size_t signals = original_ ? original_->signals : laws_.signals->count();
    if (!std::isfinite(value)) Archive::refuse("a parameter is not finite");
    if (is_input && !own && !(value >= 0.0 && value < static_cast<double>(signals) && value == std::floor(value)))
      Archive::refuse("an input signal does not exist");
  }
  for (const Law* const law : group.laws()) {
    if (!archive.reads() || !*law) continue;
    for (std::size_t k = 0; k < law->parameter_count; ++k)
      if (!check_value(*law->component->description->parameters[k], changed.values[law->first_column + k]).empty())
        Archive::refuse("a parameter is out of its bounds");
  }
}

void Layout::take_up_row(const ChangedRow& changed, bool of_element) {
  const auto set = [&](const ValueChange& change) {
    if (of_element)
      set_element_value(changed.number, change);
    else
      set_spring_value(changed.number, change);
  };
  for (std::size_t law = 0; law < 2; ++law)
    if (changed.prepared[law]) set({0, changed.values[0], law, changed.prepared[law]});
  for (std::size_t c = 0; c < changed.count; ++c) {
    const double value =
        changed.is_private[c] != 0 ? static_cast<double>(signals().add_constant(changed.values[c])) : changed.values[c];
    set({c, value});
  }
}

bool Layout::archive_changes(Archive& archive) {
  const auto group_at_first = [this](std::uint32_t number, bool of_element) {
    if (!original_) return of_element ? laws_.element_group[number] : laws_.group[number];
    return of_element ? original_->element_group[number] : original_->group[number];
  };
  std::size_t most_columns = 0;
  for (const Group& group : laws_.groups) most_columns = std::max(most_columns, group.columns.size());
  struct Rows {
    std::vector<ChangedRow> rows;
    std::vector<double> values;            // [row][column]
    std::vector<std::uint8_t> is_private;  // likewise
  };
  const auto list = [&](std::size_t count, bool of_element) {
    Rows all;
    std::vector<ChangedRow>& rows = all.rows;
    for (std::uint32_t i = 0; i < count && original_; ++i) {
      const std::uint32_t group = of_element ? laws_.element_group[i] : laws_.group[i];
      const std::uint32_t row = of_element ? laws_.element_row[i] : laws_.row[i];
      if (row < laws_.groups[group].first_rows) continue;
      rows.emplace_back().number = i;
      for (const Column<double>& column : laws_.groups[group].columns) all.values.push_back(column[row]);
      all.values.resize(most_columns * rows.size());
    }
    rows.resize(archive.count(rows.size(), sizeof(std::uint32_t), "changed springs or elements"));
    if (rows.size() > count) Archive::refuse("more springs or elements were changed than there are");
    all.values.resize(most_columns * rows.size());
    all.is_private.resize(all.values.size());
    for (ChangedRow& row : rows) {
      const std::size_t begin = static_cast<std::size_t>(&row - rows.data()) * most_columns;
      row.values = all.values.data() + begin;
      row.is_private = all.is_private.data() + begin;
      archive.below(row.number, count, of_element ? "an element" : "a spring");
      const std::uint32_t first = group_at_first(row.number, of_element);
      archive_row(archive, row, first);
      if (!archive.reads()) continue;
      const Group& group = laws_.groups[first];
      for (std::size_t law = 0; law < 2; ++law) {
        const Law& own = *group.laws()[law];
        if (!own.prepared) continue;
        const std::vector<double> parameters(row.values + own.first_column,
                                             row.values + own.first_column + own.parameter_count);
        const std::uint32_t at = original_
                                     ? (of_element ? original_->element_row[row.number] : original_->row[row.number])
                                     : (of_element ? laws_.element_row[row.number] : laws_.row[row.number]);
        bool is_other = false;
        for (std::size_t k = 0; k < parameters.size(); ++k)
          is_other = is_other || !detail::SameBits<double>::of(parameters[k], group.columns[own.first_column + k][at]);
        if (is_other) row.prepared[law] = prepared_.of(own.component, parameters, own.tables);
      }
    }
    return all;
  };
  const Rows of_springs = list(spring_count(), false), of_elements = list(elements_.count(), true);
  const std::vector<ChangedRow>&springs = of_springs.rows, &elements = of_elements.rows;

  struct Neuron {
    std::uint32_t node = 0;
    std::vector<double> parameters;
  };
  std::vector<Neuron> neurons;
  for (std::uint32_t k = 0; k < node_count() && original_; ++k)
    if (neuron_kind_[k] != original_->neuron_kind[k]) neurons.push_back({k, laws_.neurons[neuron_kind_[k]].parameters});
  neurons.resize(archive.count(neurons.size(), sizeof(std::uint32_t), "changed neurons"));
  if (neurons.size() > node_count()) Archive::refuse("more neurons were changed than there are");
  for (Neuron& neuron : neurons) {
    archive.below(neuron.node, node_count(), "a node");
    const std::uint32_t first = original_ ? original_->neuron_kind[neuron.node] : neuron_kind_[neuron.node];
    neuron.parameters.resize(laws_.neurons[first].parameters.size());
    archive.numbers(neuron.parameters.data(), neuron.parameters.size());
    const springnet_component& component = *laws_.neurons[first].component->description;
    for (std::size_t k = 0; k < neuron.parameters.size() && archive.reads(); ++k)
      if (!check_value(*component.parameters[k], neuron.parameters[k]).empty())
        Archive::refuse("a parameter of a neuron is out of its bounds");
  }
  if (!archive.reads()) return false;
  if (!original_ && springs.empty() && elements.empty() && neurons.empty()) return false;

  take_back_changes();
  for (const ChangedRow& row : springs) take_up_row(row, false);
  for (const ChangedRow& row : elements) take_up_row(row, true);
  for (const Neuron& neuron : neurons)
    for (std::size_t k = 0; k < neuron.parameters.size(); ++k)
      set_neuron_parameter({&neuron.node, 1}, k, {&neuron.parameters[k], 1});
  if (!springs.empty() || !elements.empty() || !neurons.empty()) all_due_ = true;
  units_due_.clear();  // all are
  elements_due_ = true;
  found_ = Shared<Found>();
  ++value_revision_;
  return true;
}

}  // namespace springnet::layers
