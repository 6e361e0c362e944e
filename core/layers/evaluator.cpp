// Units of the layout, each by one thread: the springs of a tile, then what the caller does with the forces on its
// nodes. The head of a unit, up to the last node that springs of the unit before lead to, waits for that unit.

#include <omp.h>

#include <algorithm>
#include <utility>

#include "layers/evaluator.hpp"
#include "layers/unit_scratch.hpp"
#include "plugin_host/call.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {

namespace {

constexpr std::size_t springs_in_an_element = 4;  // by the time that its evaluation takes

void copy_forces(const ForceArrays& from, std::size_t count, const ForceArrays& to) noexcept {
  std::copy_n(from.x, count, to.x);
  std::copy_n(from.y, count, to.y);
  std::copy_n(from.z, count, to.z);
}

}  // namespace

unsigned useful_threads(unsigned wanted, std::size_t springs, std::size_t units) {
  constexpr std::size_t springs_worth_a_thread = 8000;
  const auto machine = static_cast<unsigned>(std::max(1, omp_get_num_procs()));
  if (wanted == 0) {
    wanted = springs < springs_worth_a_thread ? 1 : machine;
  }
  return std::max(1u, std::min(wanted, static_cast<unsigned>(std::max<std::size_t>(1, units))));
}

Evaluator::Evaluator(const Layout& layout, const std::vector<double>& mass, InstructionSet set, unsigned threads)
    : layout_(layout),
      mass_(mass),
      set_(choose_instruction_set(set)),
      kernels_(kernels_for(set_)),
      threads_(useful_threads(threads, layout.spring_count() + springs_in_an_element * layout.elements().count(),
                              layout.units().size())) {
  const ElementLayout& elements = layout.elements();
  for (std::vector<double>& component : corner_force_)
    component.resize(max_corners * elements.count());  // removed ones may be put back
  enclosure_force_.resize(elements.enclosures().size());
  for (std::uint32_t s = 0; s < elements.enclosures().size(); ++s) {
    const auto size = static_cast<std::uint32_t>(elements.enclosures()[s].shape.size());
    enclosure_gradient_.emplace_back(size, Vector3::Zero());
    for (std::uint32_t begin = 0; begin < size; begin += enclosure_chunk)
      chunks_.push_back({s, begin, std::min(size, begin + static_cast<std::uint32_t>(enclosure_chunk))});
  }
  enclosure_shares_.resize(chunks_.size());
}

// Units of a thread, in order, so that most find the unit before done; who has done all of them takes from others.
struct alignas(64) Evaluator::Share {
  std::atomic<std::uint32_t> next{0};
  std::uint32_t begin = 0, end = 0;
};

Evaluator::~Evaluator() = default;

void Evaluator::prepare_units() const {
  const std::vector<Unit>& units = layout_.units();
  if (revision_ != layout_.revision()) {
    revision_ = 0;
    scratch_.resize(threads_);
    for (std::unique_ptr<UnitScratch>& scratch : scratch_) {
      if (!scratch) scratch = std::make_unique<UnitScratch>();
      scratch->reserve(layout_);
    }
    if (!shares_) shares_ = std::make_unique<Share[]>(threads_);
    if (!arrivals_) arrivals_ = std::make_unique<std::atomic<std::uint8_t>[]>(units.size());
    for (unsigned t = 0; t < threads_; ++t) {
      shares_[t].begin = static_cast<std::uint32_t>(units.size() * t / threads_);
      shares_[t].end = static_cast<std::uint32_t>(units.size() * (t + 1) / threads_);
    }
    std::size_t size = 0;
    for (std::uint32_t u = 0; u < units.size(); ++u) size += 3 * (std::size_t{units[u].halo} + head_size(u));
    halo_memory_.resize(size);
    double* next = halo_memory_.data();
    const auto take = [&next](std::size_t count) {
      const ForceArrays arrays{next, next + count, next + 2 * count};
      next += 3 * count;
      return arrays;
    };
    halo_.clear();
    head_.clear();
    for (std::uint32_t u = 0; u < units.size(); ++u) {
      halo_.push_back(take(units[u].halo));
      head_.push_back(take(head_size(u)));
    }
    revision_ = layout_.revision();
  }
  for (unsigned t = 0; t < threads_; ++t) shares_[t].next.store(shares_[t].begin, std::memory_order_relaxed);
  for (std::size_t u = 0; u < units.size(); ++u) arrivals_[u].store(0, std::memory_order_relaxed);
}

bool Evaluator::take_unit(unsigned thread, std::uint32_t& unit) const noexcept {
  for (unsigned i = 0; i < threads_; ++i) {
    Share& share = shares_[(thread + i) % threads_];
    unit = share.next.fetch_add(1, std::memory_order_relaxed);
    if (unit < share.end) return true;
  }
  return false;
}

springnet_status Evaluator::evaluate(double time, const NodeArrays& nodes, const ExternalForces& external,
                                     const ForceArrays& force, TileFinished finished,
                                     springnet_message& message) const {
  if (layout_.elements().live_count() > 0) {
    if (const springnet_status status = evaluate_elements(time, nodes, message); status != SPRINGNET_OK) return status;
  }
  prepare_units();
  const Pass pass{time, nodes, external, force, finished};
  const auto units = static_cast<std::uint32_t>(layout_.units().size());
  if (threads_ == 1) {
    const FlushDenormals flush;
    for (std::uint32_t u = 0; u < units; ++u)
      if (const springnet_status status = evaluate_unit(u, pass, *scratch_[0], message); status != SPRINGNET_OK)
        return status;
    return SPRINGNET_OK;
  }
  std::uint32_t failed_unit = units;
  springnet_status failure = SPRINGNET_OK;
  const profile::Region region(threads_);
#pragma omp parallel num_threads(static_cast <int>(threads_))
  {
    const FlushDenormals flush;
    const profile::Share share(region, omp_get_thread_num(), omp_get_num_threads());
    const auto thread = static_cast<unsigned>(omp_get_thread_num());
    for (std::uint32_t u = 0; take_unit(thread, u);) {
      springnet_message unit_message{};
      // An exception that leaves the region would end the process.
      const springnet_status status =
          sdk::detail::guarded(&unit_message, [&] { return evaluate_unit(u, pass, *scratch_[thread], unit_message); });
      if (status != SPRINGNET_OK) {
#pragma omp critical(springnet_evaluate)
        if (u < failed_unit) {
          failed_unit = u;
          failure = status;
          message = unit_message;
        }
      }
    }
  }
  return failure;
}

springnet_status Evaluator::evaluate_unit(std::uint32_t index, const Pass& pass, UnitScratch& scratch,
                                          springnet_message& message) const {
  const Unit& unit = layout_.units()[index];
  const ForceArrays& force = scratch.force;
  for (double* of : {force.x, force.y, force.z}) std::fill_n(of + unit.node_count, unit.halo, 0.0);
  scratch.open_window(unit);
  const std::uint32_t head = head_end(index);
  const bool waits = head > unit.first_node && arrivals_[index].load(std::memory_order_acquire) == 0;
  std::uint32_t begun = unit.first_node, filled = unit.first_node;
  scratch.pending.springs.count = 0;
  scratch.unsummed = nullptr;
  const Tile* before = nullptr;  // whose forces were pending
  const auto end_before = [&]() -> springnet_status {
    return before == nullptr ? SPRINGNET_OK
                             : end_tile(index, *std::exchange(before, nullptr), waits, pass, scratch, message);
  };
  for (const Tile& tile : unit.tiles) {
    const profile::Tile measured;
    const std::uint32_t ahead = std::min(layout_.node_count(), tile.first_node + std::max(unit.reach, tile_nodes));
    const std::uint32_t own_ahead = std::min(ahead, unit.end_node());
    begin_forces(begun, own_ahead, pass, force, unit.first_node);
    begun = own_ahead;
    if (unit.window > 0) {
      kernels_.fill_window(pass.nodes, filled, ahead, scratch.window);
      filled = ahead;
    }
    springnet_status status = evaluate_tile(unit, tile, pass, scratch, message);
    if (status == SPRINGNET_OK) status = end_before();
    if (status != SPRINGNET_OK) return status;
    before = &tile;
    if (unit.window == 0) continue;
    settle_pending(unit, scratch);  // before the window moves on
    if (status = end_before(); status != SPRINGNET_OK) return status;
  }
  settle_pending(unit, scratch);
  if (const springnet_status status = end_before(); status != SPRINGNET_OK) return status;
  if (unit.window > 0)
    kernels_.drain_window(scratch.window, unit.end_node(), unit.end_node() + unit.halo, force, unit.first_node);
  copy_forces({force.x + unit.node_count, force.y + unit.node_count, force.z + unit.node_count}, unit.halo,
              halo_[index]);
  if (waits)
    if (const springnet_status status = arrive_at(index, pass, message); status != SPRINGNET_OK) return status;
  return unit.halo > 0 ? arrive_at(index + 1, pass, message) : SPRINGNET_OK;
}

// Forces of gravity, loads and elements.
void Evaluator::begin_forces(std::uint32_t begin, std::uint32_t end, const Pass& pass, const ForceArrays& force,
                             std::uint32_t origin) const {
  const ForceArrays& loads = pass.external.loads;
  const auto from_begin = [&](const double* load) { return load == nullptr ? nullptr : load + begin; };
  const double* const load[3] = {from_begin(loads.x), from_begin(loads.y), from_begin(loads.z)};
  const std::uint32_t place = begin - origin;
  double* const own[3] = {force.x + place, force.y + place, force.z + place};
  kernels_.weigh(end - begin, mass_.data() + begin, pass.external.gravity.data(), load, own);
  if (pass.external.pressure != nullptr && layout_.loaded_faces().any_following()) {
    for (std::uint32_t k = begin; k < end; ++k) {
      const Vector3 push = layout_.loaded_faces().force(k, pass.nodes, pass.external.pressure);
      force.x[k - origin] += push[0];
      force.y[k - origin] += push[1];
      force.z[k - origin] += push[2];
    }
  }
  if (layout_.elements().live_count() > 0 && begin < end) {
    const profile::Part part("elements");
    add_elements(begin, end, force, origin);
  }
}

// Afterwards the forces of the tile before are final; those of its own last segment are pending.
springnet_status Evaluator::evaluate_tile(const Unit& unit, const Tile& tile, const Pass& pass, UnitScratch& scratch,
                                          springnet_message& message) const {
  const profile::Part part("springs");
  bool is_first = true;
  for (std::uint32_t s = tile.segment_begin; s < tile.segment_end; ++s) {
    const Segment& segment = unit.segments[s];
    if (segment.dead == segment.count) {
      clear_forces(unit, segment, scratch);
      continue;
    }
    is_first = false;
    find_geometry(unit, segment, pass.nodes, scratch);
    const springnet_status status = apply_laws(unit, segment, pass.time, pass.nodes, scratch, message);
    if (status != SPRINGNET_OK) return status;
  }
  if (is_first) settle_pending(unit, scratch);
  scratch.unsummed = &tile;
  return SPRINGNET_OK;
}

springnet_status Evaluator::end_tile(std::uint32_t index, const Tile& tile, bool waits, const Pass& pass,
                                     UnitScratch& scratch, springnet_message& message) const {
  const Unit& unit = layout_.units()[index];
  const ForceArrays& force = scratch.force;
  if (unit.window > 0)
    kernels_.drain_window(scratch.window, tile.first_node, tile.first_node + tile.node_count, force, unit.first_node);
  const std::uint32_t place = tile.first_node - unit.first_node;
  const ForceArrays of_tile{force.x + place, force.y + place, force.z + place};
  if (!waits || tile.first_node >= head_end(index)) return finish_tile(index, tile, pass, of_tile, message);
  const ForceArrays& head = head_[index];
  copy_forces(of_tile, tile.node_count, {head.x + place, head.y + place, head.z + place});
  return SPRINGNET_OK;
}

// Nodes before it are reached by springs of the unit before.
std::uint32_t Evaluator::head_end(std::uint32_t unit) const noexcept {
  return layout_.units()[unit].first_node + (unit > 0 ? layout_.units()[unit - 1].halo : 0);
}

// Nodes of whole tiles that may wait for the unit before.
std::uint32_t Evaluator::head_size(std::uint32_t unit) const noexcept {
  const std::uint32_t nodes = head_end(unit) - layout_.units()[unit].first_node;
  return (nodes + tile_nodes - 1) / tile_nodes * tile_nodes;
}

// All springs of this unit, and of the one before where they lead here, have been evaluated; `own` are the forces of
// this unit's.
springnet_status Evaluator::finish_tile(std::uint32_t unit, const Tile& tile, const Pass& pass, const ForceArrays& own,
                                        springnet_message& message) const {
  const std::uint32_t end = std::min(tile.first_node + tile.node_count, head_end(unit));
  if (tile.first_node < end) {
    const std::uint32_t place = tile.first_node - layout_.units()[unit].first_node;
    const ForceArrays& before = halo_[unit - 1];
    for (std::uint32_t i = 0; i < end - tile.first_node; ++i) {
      own.x[i] += before.x[place + i];
      own.y[i] += before.y[place + i];
      own.z[i] += before.z[place + i];
    }
  }
  if (pass.force.x != nullptr)
    copy_forces(own, tile.node_count,
                {pass.force.x + tile.first_node, pass.force.y + tile.first_node, pass.force.z + tile.first_node});
  if (pass.finished.call == nullptr) return SPRINGNET_OK;
  return pass.finished.call(pass.finished.user, unit, tile.first_node, tile.node_count, own, message);
}

// By the unit itself, if it waits, and by the one before; who comes second finishes its head.
springnet_status Evaluator::arrive_at(std::uint32_t index, const Pass& pass, springnet_message& message) const {
  if (arrivals_[index].fetch_add(1, std::memory_order_acq_rel) == 0) return SPRINGNET_OK;
  const Unit& unit = layout_.units()[index];
  for (const Tile& tile : unit.tiles) {
    if (tile.first_node >= head_end(index)) break;
    const profile::Tile measured;
    const std::uint32_t place = tile.first_node - unit.first_node;
    const ForceArrays own{head_[index].x + place, head_[index].y + place, head_[index].z + place};
    if (const springnet_status status = finish_tile(index, tile, pass, own, message); status != SPRINGNET_OK)
      return status;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
