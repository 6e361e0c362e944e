#include "learning/trajectory.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/checkpoints.hpp"

namespace springnet::learning {
namespace {

// States of a part: few if they are large. Of the net alone, so that the budget changes no bits.
constexpr std::size_t most_of_part = 64, least_of_part = 4, bytes_of_part = std::size_t{1} << 27;

std::size_t bytes_of(const Trajectory::State& state) {
  return sizeof state + sizeof(double) * static_cast<std::size_t>(state.p.size() + state.v.size() + state.z.size());
}

}  // namespace

void Trajectory::record(State& to) {
  record_(to);
  to.parts = recorder_.parts();
}

void Trajectory::clear() {
  times_.clear();
  saved_.clear();
  count_ = 0;
  beside_number_ = none;
}

void Trajectory::hold(State first, State second) {
  clear();
  times_ = {first.time, second.time};
  states_.resize(2);
  states_[0] = std::move(first);
  states_[1] = std::move(second);
  first_ = 0;
  count_ = 2;
}

void Trajectory::plan(std::size_t steps) {
  State first;
  record(first);
  const std::size_t each = bytes_of(first), saved_size = simulation_.save().size();  // lays out what was changed
  events_ = simulation_.events().size();
  use_ = {};
  use_.part = std::clamp(bytes_of_part / each, least_of_part, most_of_part);
  if (steps < memory_ / each) {
    states_.resize(steps + 1);
    return;
  }
  const std::size_t window = (std::min(use_.part, steps + 1) + 1) * each;
  if (memory_ < window + saved_size)
    throw Error(ErrorKind::input,
                fmt::format("learning: {:.3g} MiB of memory are too few for the states of {} steps in a row and a "
                            "saved one; give at least {:.3g} MiB",
                            static_cast<double>(memory_) / (1 << 20), use_.part,
                            static_cast<double>(window + saved_size) / (1 << 20)));
  use_.places = (memory_ - window) / saved_size;
  states_.resize(use_.part);
  states_.shrink_to_fit();
}

void Trajectory::count() {
  use_.states = count_ + (beside_number_ == none ? 0 : 1);
  use_.most_states = std::max(use_.most_states, use_.states);
  use_.saved = saved_.size();
  use_.most_saved = std::max(use_.most_saved, use_.saved);
}

bool Trajectory::keeps(std::size_t part, std::size_t target) const {
  if (saved_.size() >= use_.places) return false;
  if (saved_.empty()) return true;
  const std::size_t last = saved_.back().part, left = target - last + 1;
  return part > last && left > 1 && part == last + parts_until_kept(left, use_.places - saved_.size() + 1);
}

// What follows is the same after a saved state is taken up, after it was saved, and after the history was dropped,
// unless springs were removed or changed since: where it is saved they are laid out anew.
void Trajectory::begin_part(std::size_t part, std::size_t target) {
  const std::vector<Event>& events = simulation_.events();
  const bool is_other =
      saves_ || std::any_of(events.begin() + static_cast<std::ptrdiff_t>(events_), events.end(), [](const Event& each) {
        return each.kind == Event::Kind::cut || each.kind == Event::Kind::ruptured;
      });
  events_ = events.size();
  if (keeps(part, target))
    saved_.push_back({part, simulation_.save(), recorder_.parts()});
  else if (is_other)
    static_cast<void>(simulation_.save());
  else
    simulation_.drop_history();
}

void Trajectory::run(std::size_t steps, const std::function<void(std::size_t)>& made) {
  clear();
  recorder_.take_up({});
  try {
    plan(steps);
    times_.reserve(steps + 1);
    const std::size_t target = steps / use_.part;
    first_ = 0;
    for (std::size_t k = 0;; ++k) {
      if (k % use_.part == 0) {
        begin_part(k / use_.part, target);
        if (use_.places > 0 && k > 0) {
          std::swap(beside_, states_.back());
          beside_number_ = k - 1;
          first_ = k;
          count_ = 0;
        }
      }
      record(states_[count_]);
      times_.push_back(states_[count_++].time);
      here_ = k;
      count();
      if (k == steps) return;
      recorder_.step(simulation_, true);
      made(k + 1);
    }
  } catch (...) {
    clear();
    throw;
  }
}

const Trajectory::State* Trajectory::find(std::size_t state) const noexcept {
  if (state == beside_number_) return &beside_;
  return state >= first_ && state < first_ + count_ ? &states_[state - first_] : nullptr;
}

void Trajectory::step_on() {
  recorder_.step(simulation_, false);
  ++here_;
  ++use_.steps_again;
}

// Forwards, places are used for the way back from the end; backwards, for that from the part.
void Trajectory::load(std::size_t part) {
  const std::size_t begin = part * use_.part, end = std::min(begin + use_.part, times_.size());
  const bool back = begin < first_;
  if (back) {
    std::swap(beside_, states_.front());
    beside_number_ = first_;
    while (saved_.back().part > part) saved_.pop_back();
  } else {
    std::swap(beside_, states_[count_ - 1]);
    beside_number_ = first_ + count_ - 1;
  }
  count_ = 0;
  const auto last = std::prev(std::upper_bound(
      saved_.begin(), saved_.end(), part, [](std::size_t number, const Saved& each) { return number < each.part; }));
  if (here_ > begin || here_ < last->part * use_.part) {
    simulation_.restore(last->bytes);
    events_ = simulation_.events().size();
    recorder_.take_up(last->parts);
    here_ = last->part * use_.part;
  }
  const std::size_t target = back ? part : parts() - 1;
  while (here_ < begin) {
    step_on();
    if (here_ % use_.part == 0) begin_part(here_ / use_.part, target);
  }
  first_ = begin;
  for (;;) {
    record(states_[count_++]);
    if (here_ + 1 == end) break;
    step_on();
  }
  count();
}

const Trajectory::State& Trajectory::at(std::size_t state) {
  if (find(state) == nullptr) load(state / use_.part);
  return *find(state);
}

Trajectory::Step Trajectory::step(std::size_t until) {
  // Where a part begins, the second of both is asked for once more in case that the first has taken its place.
  static_cast<void>(at(until));
  static_cast<void>(at(until - 1));
  static_cast<void>(at(until));
  return {*find(until - 1), *find(until)};
}

}  // namespace springnet::learning
