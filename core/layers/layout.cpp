#include "layers/layout.hpp"

#include <algorithm>

namespace springnet::layers {
namespace {

// Springs of equal offset that make a run; fewer are faster read through indices.
constexpr std::uint32_t shortest_run = 8;
// Springs of a tile with equal parameters that make a segment of their own, whose law reads one value per parameter.
constexpr std::size_t smallest_uniform = 24;

}  // namespace

Layout::Layout(const Network& network, const PluginHost& plugins, bool renumber)
    : laws_(compile_laws(network, plugins)),
      ordering_(order_nodes(network, renumber)),
      elements_(network, laws_, ordering_.engine),
      loaded_faces_(network, ordering_.engine) {
  const SpringList& springs = network.springs();
  const std::size_t nodes = ordering_.user.size();
  alive_.assign(springs.size(), 1);
  live_count_ = springs.size();
  ends_.resize(2 * springs.size());
  for (std::size_t s = 0; s < springs.size(); ++s) {
    ends_[2 * s] = ordering_.engine[springs[s].first];
    ends_[2 * s + 1] = ordering_.engine[springs[s].second];
  }
  for (const Rigid& rigid : network.rigids()) {
    const std::uint32_t a = ordering_.engine[rigid.first], b = ordering_.engine[rigid.second];
    rigid_.insert(rigid_.end(), {{a, b}, {b, a}});
  }
  std::sort(rigid_.begin(), rigid_.end());
  neuron_kind_.resize(nodes);
  for (std::size_t k = 0; k < nodes; ++k) neuron_kind_[k] = network.nodes()[ordering_.user[k]].neuron;

  unit_of_.resize(nodes);
  units_.resize(ordering_.unit_start.size() - 1);
  for (std::size_t u = 0; u < units_.size(); ++u) {
    units_[u].first_node = ordering_.unit_start[u];
    units_[u].node_count = ordering_.unit_start[u + 1] - ordering_.unit_start[u];
    std::fill_n(unit_of_.begin() + units_[u].first_node, units_[u].node_count, static_cast<std::uint32_t>(u));
  }
  for (std::uint32_t s = 0; s < springs.size(); ++s) {
    const std::uint32_t a = unit_of_[first(s)], b = unit_of_[second(s)];
    units_[a].springs.push_back(s);
    if (b != a) units_[b].springs.push_back(s);
  }
  for (Unit& unit : units_) lay_out(unit);
  build_groups();
  build_incidence();
}

void Layout::lay_out(Unit& unit) {
  unit.tiles.clear();
  unit.segments.clear();
  unit.runs.clear();
  unit.first.clear();
  unit.second.clear();
  unit.row.clear();

  // Springs of each tile: those inside the unit, and those across its boundary.
  const std::uint32_t tile_count = (unit.node_count + tile_nodes - 1) / tile_nodes;
  std::vector<std::vector<std::uint32_t>> inside(tile_count), across(tile_count);
  const std::uint32_t unit_index = unit.node_count == 0 ? 0 : unit_of_[unit.first_node];
  for (const std::uint32_t s : unit.springs) {
    if (!alive(s)) continue;
    const std::uint32_t a = first(s), b = second(s);
    const bool a_in = unit_of_[a] == unit_index, b_in = unit_of_[b] == unit_index;
    const std::uint32_t own = a_in && b_in ? std::min(a, b) : a_in ? a : b;
    (a_in && b_in ? inside : across)[(own - unit.first_node) / tile_nodes].push_back(s);
  }
  for (std::uint32_t t = 0; t < tile_count; ++t) {
    Tile tile{};
    tile.first_node = unit.first_node + t * tile_nodes;
    tile.node_count = std::min(tile_nodes, unit.first_node + unit.node_count - tile.first_node);
    tile.segment_begin = static_cast<std::uint32_t>(unit.segments.size());
    add_segments(unit, inside[t], false);
    add_segments(unit, across[t], true);
    tile.segment_end = static_cast<std::uint32_t>(unit.segments.size());
    unit.tiles.push_back(tile);
  }
}

// Sorts the springs of a tile by group and row; frequent rows get segments of their own, the others mixed ones.
void Layout::add_segments(Unit& unit, std::vector<std::uint32_t>& slots, bool boundary) {
  std::sort(slots.begin(), slots.end(), [this](std::uint32_t s, std::uint32_t t) {
    if (laws_.group[s] != laws_.group[t]) return laws_.group[s] < laws_.group[t];
    if (laws_.row[s] != laws_.row[t]) return laws_.row[s] < laws_.row[t];
    return s < t;
  });
  std::vector<std::uint32_t> mixed;
  std::size_t begin = 0;
  while (begin < slots.size()) {
    const std::uint32_t group = laws_.group[slots[begin]];
    mixed.clear();
    while (begin < slots.size() && laws_.group[slots[begin]] == group) {
      std::size_t end = begin;
      while (end < slots.size() && laws_.group[slots[end]] == group && laws_.row[slots[end]] == laws_.row[slots[begin]])
        ++end;
      if (end - begin >= smallest_uniform) {
        add_segment(unit, slots.data() + begin, end - begin, boundary, false);
      } else {
        mixed.insert(mixed.end(), slots.begin() + static_cast<std::ptrdiff_t>(begin),
                     slots.begin() + static_cast<std::ptrdiff_t>(end));
      }
      begin = end;
    }
    add_segment(unit, mixed.data(), mixed.size(), boundary, true);
  }
}

void Layout::add_segment(Unit& unit, const std::uint32_t* slots, std::size_t count, bool boundary, bool mixed) {
  if (count == 0) return;
  struct Ends {
    std::uint32_t own, other, spring;
  };
  std::vector<Ends> ends(count);
  const std::uint32_t unit_index = unit_of_[unit.first_node];
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t a = first(slots[i]), b = second(slots[i]);
    // The force is the same seen from either end. First comes the lower node, or the one inside the unit.
    if (boundary ? unit_of_[a] != unit_index : b < a) std::swap(a, b);
    ends[i] = {a, b, slots[i]};
  }
  const auto offset = [](const Ends& e) { return std::int64_t{e.other} - std::int64_t{e.own}; };
  std::sort(ends.begin(), ends.end(), [&](const Ends& x, const Ends& y) {
    if (offset(x) != offset(y)) return offset(x) < offset(y);
    return x.own != y.own ? x.own < y.own : x.spring < y.spring;
  });

  // Maximal runs; those of shortest_run springs or more come first.
  struct Piece {
    std::size_t begin, end;
  };
  std::vector<Piece> runs, rest;
  for (std::size_t begin = 0; begin < count;) {
    std::size_t end = begin + 1;
    while (end < count && offset(ends[end]) == offset(ends[begin]) && ends[end].own == ends[end - 1].own + 1) ++end;
    (end - begin >= shortest_run ? runs : rest).push_back({begin, end});
    begin = end;
  }
  std::vector<Ends> ordered;
  ordered.reserve(count);
  std::vector<Piece> pieces = runs;
  pieces.insert(pieces.end(), rest.begin(), rest.end());
  std::vector<std::uint8_t> in_run;
  in_run.reserve(count);
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    for (std::size_t i = pieces[p].begin; i < pieces[p].end; ++i) {
      ordered.push_back(ends[i]);
      in_run.push_back(p < runs.size() ? 1 : 0);
    }
  }
  const std::size_t run_total = static_cast<std::size_t>(std::count(in_run.begin(), in_run.end(), std::uint8_t{1}));
  std::sort(ordered.begin() + static_cast<std::ptrdiff_t>(run_total), ordered.end(), [](const Ends& x, const Ends& y) {
    if (x.own != y.own) return x.own < y.own;
    return x.other != y.other ? x.other < y.other : x.spring < y.spring;
  });

  // Cut into segments that fit the scratch arrays.
  for (std::size_t begin = 0; begin < count; begin += max_segment) {
    const std::size_t end = std::min(count, begin + max_segment);
    Segment segment{};
    segment.group = laws_.group[slots[0]];
    segment.row = mixed ? mixed_rows : laws_.row[slots[0]];
    segment.begin = static_cast<std::uint32_t>(unit.first.size());
    segment.count = static_cast<std::uint32_t>(end - begin);
    segment.run_begin = static_cast<std::uint32_t>(unit.runs.size());
    segment.boundary = boundary;
    for (std::size_t i = begin; i < end; ++i) {
      const Ends& e = ordered[i];
      if (i < run_total) {
        const bool continues = i > begin && offset(e) == offset(ordered[i - 1]) && e.own == ordered[i - 1].own + 1;
        if (continues)
          ++unit.runs.back().count;
        else
          unit.runs.push_back({e.own, e.other, 1});
        ++segment.run_springs;
      }
      unit.first.push_back(e.own);
      unit.second.push_back(e.other);
      unit.row.push_back(laws_.row[e.spring]);
    }
    segment.run_count = static_cast<std::uint32_t>(unit.runs.size()) - segment.run_begin;
    unit.segments.push_back(segment);
  }
}

void Layout::build_groups() {
  springs_of_group_.assign(laws_.groups.size(), {});
  for (std::uint32_t s = 0; s < alive_.size(); ++s)
    if (alive(s)) springs_of_group_[laws_.group[s]].push_back(s);
}

void Layout::build_incidence() {
  const std::size_t nodes = node_count();
  incident_start_.assign(nodes + 1, 0);
  for (std::uint32_t s = 0; s < alive_.size(); ++s) {
    if (!alive(s)) continue;
    ++incident_start_[first(s) + 1];
    ++incident_start_[second(s) + 1];
  }
  for (std::size_t k = 0; k < nodes; ++k) incident_start_[k + 1] += incident_start_[k];
  incident_.resize(incident_start_[nodes]);
  incident_stop_.assign(incident_start_.begin(), incident_start_.end() - 1);
  // Group by group, so that each node's springs are sorted by group.
  for (const std::vector<std::uint32_t>& springs : springs_of_group_) {
    for (const std::uint32_t s : springs) {
      const std::uint32_t a = first(s), b = second(s);
      incident_[incident_stop_[a]++] = {b, laws_.group[s], laws_.row[s], s};
      incident_[incident_stop_[b]++] = {a, laws_.group[s], laws_.row[s], s};
    }
  }
}

void Layout::build_neighbours() const {
  const std::uint32_t nodes = node_count();
  neighbour_start_.assign(1, 0);
  neighbours_.clear();
  std::vector<std::uint32_t> joined;
  auto rigid = rigid_.begin();
  for (std::uint32_t k = 0; k < nodes; ++k) {
    joined.clear();
    for (const Incident* i = incident_begin(k); i != incident_end(k); ++i) joined.push_back(i->other);
    for (; rigid != rigid_.end() && rigid->first == k; ++rigid) joined.push_back(rigid->second);
    elements_.add_neighbours(k, joined);
    loaded_faces_.add_neighbours(k, joined);
    std::sort(joined.begin(), joined.end(),
              [this](std::uint32_t a, std::uint32_t b) { return ordering_.user[a] < ordering_.user[b]; });
    joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
    neighbours_.insert(neighbours_.end(), joined.begin(), joined.end());
    neighbour_start_.push_back(static_cast<std::uint32_t>(neighbours_.size()));
  }
}

const std::vector<std::uint32_t>& Layout::neighbour_start() const {
  if (neighbour_start_.empty()) build_neighbours();
  return neighbour_start_;
}

const std::vector<std::uint32_t>& Layout::neighbours() const {
  if (neighbour_start_.empty()) build_neighbours();
  return neighbours_;
}

std::vector<std::uint32_t> Layout::remove(const std::vector<std::uint32_t>& springs) {
  std::vector<std::uint32_t> removed;
  std::vector<std::uint8_t> unit_changed(units_.size(), 0);
  for (const std::uint32_t s : springs) {
    if (!alive(s)) continue;
    alive_[s] = 0;
    removed.push_back(s);
    unit_changed[unit_of_[first(s)]] = 1;
    unit_changed[unit_of_[second(s)]] = 1;
  }
  if (removed.empty()) return removed;
  live_count_ -= removed.size();
  for (std::size_t u = 0; u < units_.size(); ++u)
    if (unit_changed[u] != 0) lay_out(units_[u]);
  const auto forget = [this](std::uint32_t node) {
    Incident* begin = incident_.data() + incident_start_[node];
    Incident* end = incident_.data() + incident_stop_[node];
    const Incident* kept = std::remove_if(begin, end, [this](const Incident& i) { return !alive(i.spring); });
    incident_stop_[node] = static_cast<std::uint64_t>(kept - incident_.data());
  };
  std::vector<std::uint8_t> group_changed(springs_of_group_.size(), 0);
  for (const std::uint32_t s : removed) {
    forget(first(s));
    forget(second(s));
    group_changed[laws_.group[s]] = 1;
  }
  for (std::size_t g = 0; g < springs_of_group_.size(); ++g)
    if (group_changed[g] != 0) std::erase_if(springs_of_group_[g], [this](std::uint32_t s) { return !alive(s); });
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

void Layout::note_removal() noexcept {
  neighbour_start_.clear();
  ++revision_;
}

}  // namespace springnet::layers
