#include "layers/layout.hpp"

#include <omp.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <numeric>

#include "layers/layout_units.hpp"

namespace springnet::layers {
namespace {

// Springs from which on several threads lay them out.
constexpr std::size_t laid_out_in_parallel = 100'000;

}  // namespace

Layout::Layout(const Network& network, const PluginHost& plugins, bool renumber, unsigned threads)
    : laws_(compile_laws(network, plugins)),
      ordering_(order_nodes(network, renumber)),
      elements_(network, laws_, ordering_->engine),
      loaded_faces_(network, ordering_->engine) {
  const SpringList& springs = network.springs();
  const Ordering& order = *ordering_;
  const std::size_t nodes = order.user.size();
  alive_.assign(springs.size(), 1);
  live_count_ = springs.size();
  std::vector<std::uint32_t> ends(2 * springs.size());
  for (std::size_t s = 0; s < springs.size(); ++s) {
    ends[2 * s] = order.engine[springs[s].first];
    ends[2 * s + 1] = order.engine[springs[s].second];
  }
  ends_ = std::move(ends);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> rigid_pairs;
  for (const Rigid& rigid : network.rigids()) {
    const std::uint32_t a = order.engine[rigid.first], b = order.engine[rigid.second];
    rigid_pairs.insert(rigid_pairs.end(), {{a, b}, {b, a}});
  }
  std::sort(rigid_pairs.begin(), rigid_pairs.end());
  rigid_ = std::move(rigid_pairs);
  std::vector<std::uint32_t> kinds(nodes);
  for (std::size_t k = 0; k < nodes; ++k) kinds[k] = laws_.neuron_number[network.nodes()[order.user[k]].neuron];
  neuron_kind_ = std::move(kinds);

  units_.resize(order.unit_start.size() - 1);
  for (std::size_t u = 0; u < units_.size(); ++u) {
    units_[u].first_node = order.unit_start[u];
    units_[u].node_count = order.unit_start[u + 1] - order.unit_start[u];
  }
  lay_out(threads);
}

Layout::Layout(const Layout& other)
    : laws_(other.laws_),
      ordering_(other.ordering_),
      elements_(other.elements_),
      loaded_faces_(other.loaded_faces_),
      internal_(other.internal_),
      ends_(other.ends_),
      rigid_(other.rigid_),
      alive_(other.alive_),
      live_count_(other.live_count_),
      revision_(other.revision_),
      value_revision_(other.value_revision_),
      original_(other.original_ ? std::make_unique<Original>(*other.original_) : nullptr),
      variant_users_(other.variant_users_),
      neuron_users_(other.neuron_users_),
      free_neurons_(other.free_neurons_),
      units_due_(other.units_due_),
      elements_due_(other.elements_due_),
      all_due_(other.all_due_),
      neuron_kind_(other.neuron_kind_),
      units_(other.units_),
      found_(other.found_) {
  laws_.share_signals();
  elements_.read(laws_, internal_);
}

std::uint32_t Layout::unit_of(std::uint32_t node) const noexcept {
  const std::uint32_t size = ordering_->unit_start[1];  // all but the last are equal
  return size == 0 ? 0 : node / size;
}

void Layout::lay_out(unsigned threads) {
  // Springs by unit.
  std::vector<std::size_t> start(units_.size() + 1, 0);
  for (std::uint32_t s = 0; s < alive_.size(); ++s)
    for_units_of(s, [&](std::uint32_t u, const UnitSpring&) { ++start[u + 1]; });
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<std::uint32_t> springs(start.back());
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  for (std::uint32_t s = 0; s < alive_.size(); ++s)
    for_units_of(s, [&](std::uint32_t u, const UnitSpring&) { springs[next[u]++] = s; });

  if (threads == 0) threads = static_cast<unsigned>(std::max(1, omp_get_num_procs()));
  if (alive_.size() < laid_out_in_parallel) threads = 1;
  std::exception_ptr failure;
#pragma omp parallel num_threads(static_cast <int>(threads))
  {
    UnitBuilder builder(laws_.groups, node_count(), spring_count());
    std::vector<UnitSpring> of_unit;
#pragma omp for schedule(dynamic, 1)
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(units_.size()); ++i) {
      const auto u = static_cast<std::size_t>(i);
      try {
        of_unit.clear();
        for (std::size_t k = start[u]; k < start[u + 1]; ++k)
          for_units_of(springs[k], [&](std::uint32_t unit, const UnitSpring& spring) {
            if (unit == u) of_unit.push_back(spring);
          });
        builder.build(units_[u], of_unit);
        units_[u].all = units_[u].laid_out;
      } catch (...) {  // an exception that leaves the region would end the process
#pragma omp critical(springnet_lay_out)
        failure = std::current_exception();
      }
    }
  }
  if (failure) std::rethrow_exception(failure);
  if (std::none_of(laws_.groups.begin(), laws_.groups.end(), [](const Group& g) { return g.state_count() > 0; }))
    return;
  std::vector<std::uint32_t> order;
  for (const Unit& unit : units_)
    std::copy_if(unit.spring.begin(), unit.spring.end(), std::back_inserter(order),
                 [](std::uint32_t s) { return s != no_spring; });
  // Places stay as they were when springs are laid out again: the state is where they say.
  if (!internal_.any()) {
    internal_ = InternalLayout(laws_, order, spring_count(), elements_.count());
    elements_.take_places(internal_);
  }
  for (Unit& unit : units_) place_internal(unit);
}

// A spring that is in two units is written by that of its lower node.
void Layout::place_internal(Unit& unit) const {
  std::vector<std::uint32_t> internal(unit.spring.size(), InternalLayout::silent);
  const auto u = static_cast<std::uint32_t>(&unit - units_.data());
  for (std::size_t slot = 0; slot < unit.spring.size(); ++slot) {
    const std::uint32_t s = unit.spring[slot];
    if (s == no_spring || !internal_.has(laws_.group[s])) continue;
    const bool is_owner = unit_of(std::min(first(s), second(s))) == u;
    internal[slot] = internal_.of_spring(s) | (is_owner ? 0u : InternalLayout::silent);
  }
  unit.internal = std::move(internal);
  for (std::size_t s = 0; s < unit.segments.size(); ++s) unit.settle_values(s);
}

// Without the springs that were removed.
void Layout::lay_out_again(Unit& unit) {
  std::vector<UnitSpring> springs;
  springs.reserve(unit.live);
  const auto u = static_cast<std::uint32_t>(&unit - units_.data());
  for (const std::uint32_t s : unit.spring) {
    if (s == no_spring) continue;
    for_units_of(s, [&](std::uint32_t of, const UnitSpring& spring) {
      if (of == u) springs.push_back(spring);
    });
  }
  UnitBuilder(laws_.groups, node_count(), spring_count()).build(unit, springs);
  if (internal_.any()) place_internal(unit);
}

const std::vector<std::uint32_t>& Layout::springs_of(std::size_t group) const {
  if (!found_->has_springs.load(std::memory_order_acquire)) build_springs();
  return found_->springs_of_group[group];
}

void Layout::build_springs() const {
  const std::lock_guard guard(found_->building);
  if (found_->has_springs.load(std::memory_order_relaxed)) return;
  std::vector<std::vector<std::uint32_t>>& springs = found_->springs_of_group;
  springs.assign(laws_.groups.size(), {});
  for (std::uint32_t s = 0; s < alive_.size(); ++s)
    if (alive(s)) springs[laws_.group[s]].push_back(s);
  found_->has_springs.store(true, std::memory_order_release);
}

void Layout::build_incidence() const {
  const std::lock_guard guard(found_->building);
  if (found_->has_incidence.load(std::memory_order_relaxed)) return;
  const std::size_t nodes = node_count();
  std::vector<std::uint64_t>&incident_start = found_->incident_start, &incident_stop = found_->incident_stop;
  std::vector<Incident>& incident = found_->incident;
  incident_start.assign(nodes + 1, 0);
  for (std::uint32_t s = 0; s < alive_.size(); ++s) {
    if (!alive(s)) continue;
    ++incident_start[first(s) + 1];
    ++incident_start[second(s) + 1];
  }
  for (std::size_t k = 0; k < nodes; ++k) incident_start[k + 1] += incident_start[k];
  incident.resize(incident_start[nodes]);
  incident_stop.assign(incident_start.begin(), incident_start.end() - 1);
  for (std::uint32_t s = 0; s < alive_.size(); ++s) {
    if (!alive(s)) continue;
    const std::uint32_t a = first(s), b = second(s);
    incident[incident_stop[a]++] = {b, laws_.group[s], laws_.row[s], s};
    incident[incident_stop[b]++] = {a, laws_.group[s], laws_.row[s], s};
  }
  if (laws_.groups.size() > 1) {
    for (std::size_t k = 0; k < nodes; ++k)
      std::stable_sort(incident.begin() + static_cast<std::ptrdiff_t>(incident_start[k]),
                       incident.begin() + static_cast<std::ptrdiff_t>(incident_stop[k]),
                       [](const Incident& a, const Incident& b) { return a.group < b.group; });
  }
  found_->has_incidence.store(true, std::memory_order_release);
}

void Layout::build_neighbours() const {
  const std::lock_guard guard(found_->building);
  if (found_->has_neighbours.load(std::memory_order_relaxed)) return;
  std::vector<std::uint32_t>&neighbour_start = found_->neighbour_start, &neighbours = found_->neighbours;
  const std::uint32_t nodes = node_count();
  // Other ends of each node's springs.
  std::vector<std::size_t> start(nodes + std::size_t{1}, 0);
  for (std::uint32_t s = 0; s < alive_.size(); ++s) {
    if (!alive(s)) continue;
    ++start[first(s) + std::size_t{1}];
    ++start[second(s) + std::size_t{1}];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<std::uint32_t> others(start.back());
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  for (std::uint32_t s = 0; s < alive_.size(); ++s) {
    if (!alive(s)) continue;
    others[next[first(s)]++] = second(s);
    others[next[second(s)]++] = first(s);
  }
  neighbour_start.clear();
  neighbour_start.reserve(nodes + std::size_t{1});
  neighbour_start.push_back(0);
  neighbours.clear();
  neighbours.reserve(others.size());
  std::vector<std::uint32_t> joined;
  auto rigid = rigid_.begin();
  for (std::uint32_t k = 0; k < nodes; ++k) {
    joined.assign(others.begin() + static_cast<std::ptrdiff_t>(start[k]),
                  others.begin() + static_cast<std::ptrdiff_t>(start[k + std::size_t{1}]));
    for (; rigid != rigid_.end() && rigid->first == k; ++rigid) joined.push_back(rigid->second);
    elements_.add_neighbours(k, joined);
    loaded_faces_.add_neighbours(k, joined);
    std::sort(joined.begin(), joined.end(),
              [this](std::uint32_t a, std::uint32_t b) { return ordering_->user[a] < ordering_->user[b]; });
    joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
    neighbours.insert(neighbours.end(), joined.begin(), joined.end());
    neighbour_start.push_back(static_cast<std::uint32_t>(neighbours.size()));
  }
  found_->has_neighbours.store(true, std::memory_order_release);
}

const std::vector<std::uint32_t>& Layout::neighbour_start() const {
  if (!has_neighbours()) build_neighbours();
  return found_->neighbour_start;
}

const std::vector<std::uint32_t>& Layout::neighbours() const {
  if (!has_neighbours()) build_neighbours();
  return found_->neighbours;
}

std::vector<std::uint32_t> Layout::remove(const std::vector<std::uint32_t>& springs) {
  std::vector<std::uint32_t> removed;
  std::vector<std::uint32_t> changed;  // units
  for (const std::uint32_t s : springs) {
    if (!alive(s)) continue;
    alive_.own()[s] = 0;
    removed.push_back(s);
    for_units_of(s, [&](std::uint32_t u, const UnitSpring& spring) {
      units_[u].remove(spring.own, s);
      changed.push_back(u);
    });
  }
  if (removed.empty()) return removed;
  live_count_ -= removed.size();
  // Removed springs cost as much as others; laying out all that are left, once for each halving of their number, costs
  // little.
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  for (const std::uint32_t u : changed)
    if (2 * units_[u].live < units_[u].laid_out) lay_out_again(units_[u]);
  if (found_.is_shared()) found_ = Shared<Found>();
  if (found_->has_incidence.load(std::memory_order_relaxed)) {
    const auto forget = [this](std::uint32_t node) {
      Incident* const begin = found_->incident.data() + found_->incident_start[node];
      Incident* const end = found_->incident.data() + found_->incident_stop[node];
      const Incident* kept = std::remove_if(begin, end, [this](const Incident& i) { return !alive(i.spring); });
      found_->incident_stop[node] = static_cast<std::uint64_t>(kept - found_->incident.data());
    };
    for (const std::uint32_t s : removed) {
      forget(first(s));
      forget(second(s));
    }
  }
  found_->has_springs.store(false, std::memory_order_relaxed);
  note_removal();
  return removed;
}

std::vector<std::uint32_t> Layout::remove_elements(const std::vector<std::uint32_t>& elements) {
  const std::vector<std::uint32_t> removed = elements_.remove(elements);
  if (!removed.empty()) note_removal();
  return removed;
}

std::vector<std::size_t> Layout::remove_faces(const std::vector<std::size_t>& faces) {
  const std::vector<std::size_t> removed = loaded_faces_.remove(faces);
  if (!removed.empty()) note_removal();
  return removed;
}

void Layout::put_back_all() {
  if (live_count_ < alive_.size() || all_due_) {
    all_due_ = false;
    alive_.assign(alive_.size(), 1);
    live_count_ = alive_.size();
    lay_out(1);
    found_ = Shared<Found>();
  }
  if (elements_due_) elements_.groups_changed();
  elements_due_ = false;
  elements_.put_back_all();
  loaded_faces_.put_back_all();
  note_removal();
}

bool Layout::is_as_removed_at_once() const noexcept {
  return std::all_of(units_.begin(), units_.end(), [](const Unit& unit) {
    return unit.laid_out == (2 * unit.live < unit.all ? unit.live : unit.all);
  });
}

void Layout::note_removal() {
  if (found_.is_shared()) found_ = Shared<Found>();
  found_->has_neighbours.store(false, std::memory_order_relaxed);
  ++revision_;
}

}  // namespace springnet::layers
