#include "profile/recording.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>

namespace springnet::profile {
namespace {

constexpr Nanoseconds interrupted = 16;  // times the mean of a part

}  // namespace

// ---- one thread -----------------------------------------------------------------------------------------------------

bool Lane::Key::is(const Node& node) const noexcept {
  return node.kind == kind && node.region == region && node.team == team && node.of_region == of_region &&
         std::strcmp(node.name.c_str(), name) == 0;
}

bool Lane::enter(const Key& key, Nanoseconds time) noexcept {
  std::uint32_t child = nodes_[present_].first_child, last = none;
  while (child != none && !key.is(nodes_[child])) {
    last = child;
    child = nodes_[child].next;
  }
  if (child == none) {
    try {
      Node node;
      node.name = key.name;
      node.kind = key.kind;
      node.region = key.region;
      node.of_region = key.of_region;
      node.team = key.team;
      node.parent = present_;
      child = static_cast<std::uint32_t>(nodes_.size());
      nodes_.push_back(std::move(node));
    } catch (const std::exception&) {
      return false;
    }
    (last == none ? nodes_[present_].first_child : nodes_[last].next) = child;
  }
  nodes_[child].started = time;
  present_ = child;
  ++depth_;
  return true;
}

void Lane::leave(Nanoseconds time) noexcept {
  Node& node = nodes_[present_];
  node.time += time - node.started;
  ++node.calls;
  present_ = node.parent;
  --depth_;
}

void Lane::end() noexcept {
  const std::uint32_t node = present_;
  const Nanoseconds time = now();
  leave(time);
  if (!recording_.traces() || number_ > 0) return;
  keep({node, number_, nodes_[node].started, time});
  // Time steps, or the parts of a run: the trace keeps or drops them whole. No other thread is at work here.
  if (depth_ <= 1) recording_.collect();
}

void Lane::end_share(std::uint32_t stage) noexcept {
  const Nanoseconds started = nodes_[present_].started, time = now();
  leave(time);
  // The first thread has the stage itself in its row of the trace.
  if (recording_.traces() && number_ > 0) keep({stage, number_, started, time});
}

bool Lane::measure(Node& stage) noexcept {
  if (stage.measure_all > 0) {
    --stage.measure_all;
    weight_ = 1;
    return true;
  }
  // At random, because tiles differ in an order that repeats with every sweep: 0 to 2 (sampling - 1) are skipped.
  random_ ^= random_ << 13;
  random_ ^= random_ >> 7;
  random_ ^= random_ << 17;
  stage.skip = static_cast<std::uint32_t>(random_ % (2 * Node::sampling - 1));
  weight_ = Node::sampling;
  return true;
}

// Parts of a tile run on a clock that leaves out what the parts within them add.
bool Lane::begin_part(Kind kind, const char* name) noexcept {
  if (!enter({name, kind, false, none, 0}, 0)) return false;
  Node& part = nodes_[present_];
  part.estimated = true;
  part.started = now() - overhead_;
  return true;
}

void Lane::end_part() noexcept {
  Node& part = nodes_[present_];
  const PartCost& cost = recording_.part_cost();
  const Nanoseconds time = std::max<Nanoseconds>(0, now() - overhead_ - part.started - cost.inside);
  // A thread that was interrupted here was not in the tiles that this one stands for.
  const Nanoseconds others = part.calls > 0 && weight_ > 1
                                 ? std::min(time, interrupted * part.time / static_cast<Nanoseconds>(part.calls))
                                 : time;
  part.time += time + (weight_ - 1) * others;
  part.calls += weight_;
  overhead_ += cost.outside;
  present_ = part.parent;
  --depth_;
}

void Lane::keep(const TraceEvent& event) noexcept {
  try {
    if (events.size() < recording_.trace().half()) {
      events.push_back(event);
      return;
    }
  } catch (const std::exception&) {  // out of memory: the trace is shorter
  }
  ++dropped;
}

void Lane::clear() {
  nodes_.assign(1, Node{});
  present_ = depth_ = 0;
  random_ = 0x9e3779b97f4a7c15u + number_;
  events.clear();
  dropped = 0;
}

// ---- the trace ------------------------------------------------------------------------------------------------------

void Trace::add(const std::vector<TraceEvent>& step) {
  if (!first_is_full_ && first_.size() + step.size() <= half_) {
    first_.insert(first_.end(), step.begin(), step.end());
    return;
  }
  first_is_full_ = true;
  if (step.size() > half_) {
    dropped += step.size();
    return;
  }
  while (last_.size() + step.size() > half_) {
    const std::size_t oldest = last_steps_.front();
    last_steps_.pop_front();
    last_.erase(last_.begin(), last_.begin() + static_cast<std::ptrdiff_t>(oldest));
    dropped += oldest;
  }
  last_steps_.push_back(step.size());
  last_.insert(last_.end(), step.begin(), step.end());
}

void Trace::clear() {
  first_.clear();
  last_.clear();
  last_steps_.clear();
  first_is_full_ = false;
  dropped = 0;
}

// ---- all threads ----------------------------------------------------------------------------------------------------

Recording::Recording(std::size_t trace_events, const PartCost& part_cost)
    : trace_(trace_events), part_cost_(part_cost), origin_(now()) {
  lanes_.push_back(std::make_unique<Lane>(*this, 0));
}

bool Recording::prepare(std::uint32_t count) noexcept {
  try {
    while (lanes_.size() < count)
      lanes_.push_back(std::make_unique<Lane>(*this, static_cast<std::uint32_t>(lanes_.size())));
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

void Recording::collect() noexcept {
  try {
    step_.clear();
    for (const std::unique_ptr<Lane>& lane : lanes_)
      step_.insert(step_.end(), lane->events.begin(), lane->events.end());
    trace_.add(step_);
  } catch (const std::exception&) {  // out of memory: the trace is shorter
    trace_.dropped += step_.size();
  }
  for (const std::unique_ptr<Lane>& lane : lanes_) {
    trace_.dropped += std::exchange(lane->dropped, 0);
    lane->events.clear();
  }
}

void Recording::clear() {
  for (const std::unique_ptr<Lane>& lane : lanes_) lane->clear();
  trace_.clear();
  origin_ = now();
}

// ---- the clock ------------------------------------------------------------------------------------------------------

const PartCost& measured_part_cost() {
  static const PartCost cost = [] {
    Recording scratch(0, {});
    Lane& lane = scratch.first();
    constexpr int rounds = 20, parts = 20;
    PartCost least{std::numeric_limits<Nanoseconds>::max(), std::numeric_limits<Nanoseconds>::max()};
    for (int round = 0; round < rounds; ++round) {
      const Nanoseconds begin = now();
      for (int i = 0; i < parts; ++i)
        if (lane.begin_part(Kind::stage, "part")) lane.end_part();
      const Nanoseconds end = now();
      least.outside = std::min(least.outside, (end - begin) / parts);
      least.inside = std::min(least.inside, now() - end);
    }
    return least;
  }();
  return cost;
}

}  // namespace springnet::profile
