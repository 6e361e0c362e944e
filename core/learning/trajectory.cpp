#include "learning/trajectory.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/checkpoints.hpp"

namespace springnet::learning {
namespace {

// States of a part. Of the net alone, so that the budget changes no bits. Where a part begins integrators estimate anew
// what they know of the motion, which takes the recurrent network some eight steps: parts are long, unless their states
// are large. Those of small nets are short, so that they fit small budgets.
constexpr std::size_t most_of_part = 64, most_of_large_net = 256, least_of_part = 4;
constexpr std::size_t bytes_of_large_net = std::size_t{1} << 16, bytes_of_part = std::size_t{1} << 27;

std::size_t bytes_of(const Eigen::VectorXd& p, const Eigen::VectorXd& v, const Eigen::VectorXd& z) {
  return sizeof(double) * static_cast<std::size_t>(p.size() + v.size() + z.size());
}
std::size_t bytes_of(const std::vector<StepPart>& parts) {
  std::size_t result = 0;
  for (const StepPart& each : parts) {
    result += sizeof each + sizeof(LocatedEvent) * each.events.size() + bytes_of(each.p, each.v, each.z);
    for (const LocatedEvent& event : each.events) result += sizeof(NodeChange) * event.cluster.size();
  }
  return result;
}
// One at the end of each part, and one at each event.
std::size_t states_within(const std::vector<StepPart>& parts) {
  std::size_t result = parts.size();
  for (const StepPart& each : parts) result += each.events.size();
  return result;
}

double mebibytes(std::size_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

}  // namespace

void Trajectory::record() {
  State& to = states_[count_++];
  record_(to);
  to.parts = recorder_.parts();
  if (to.parts.empty()) return;
  const std::size_t own = bytes_of(to.parts);
  divided_ += own;
  most_of_step_ = std::max(most_of_step_, own);
  most_passed_ = std::max(most_passed_, states_within(to.parts) * each_);
}

void Trajectory::clear() {
  times_.clear();
  saved_.clear();
  saved_bytes_ = largest_saved_ = divided_ = most_divided_ = most_of_step_ = most_passed_ = 0;
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
  record_(first);
  steps_ = steps;
  each_ = sizeof first + bytes_of(first.p, first.v, first.z);
  largest_saved_ = simulation_.save().size();  // lays out what was changed
  events_ = simulation_.events().size();
  use_ = {};
  use_.part =
      std::clamp(bytes_of_part / each_, least_of_part, each_ < bytes_of_large_net ? most_of_part : most_of_large_net);
  if (reserved_ < memory_ && steps < (memory_ - reserved_) / each_) {
    states_.resize(steps + 1);
    return;
  }
  use_.places = find_places();
  states_.resize(use_.part);
  states_.shrink_to_fit();
}

std::size_t Trajectory::find_places() const {
  const std::size_t states =
      (std::min(use_.part, steps_ + 1) + 1) * each_ + reserved_ + most_divided_ + most_of_step_ + most_passed_;
  if (memory_ >= states + largest_saved_) return (memory_ - states) / largest_saved_;
  std::string beside = most_divided_ == 0 ? "" : fmt::format(", with events until {:g} s,", times_.back());
  if (reserved_ > 0) beside += ", with what changes of the net have replaced,";
  throw Error(ErrorKind::input,
              fmt::format("learning: {:.3g} MiB of memory are too few for the states of {} steps in a row{} and a "
                          "saved one; give at least {:.3g} MiB{}",
                          mebibytes(memory_), use_.part, beside, mebibytes(states + largest_saved_),
                          most_divided_ == 0 ? "" : ", and more for later events"));
}

std::size_t Trajectory::bytes() const noexcept {
  const bool any_beside = beside_number_ != none;
  return (count_ + (any_beside ? 1 : 0)) * each_ + divided_ + (any_beside ? bytes_of(beside_.parts) : 0) +
         most_passed_ + saved_bytes_ + reserved_;
}

void Trajectory::count() {
  use_.states = count_ + (beside_number_ == none ? 0 : 1);
  use_.most_states = std::max(use_.most_states, use_.states);
  use_.saved = saved_.size();
  use_.most_saved = std::max(use_.most_saved, use_.saved);
  use_.most_bytes = std::max(use_.most_bytes, bytes());
}

void Trajectory::stay_within_memory() {
  if (use_.places == 0) {
    // Without divided steps the plan holds.
    if (divided_ == 0 || bytes() <= memory_) return;
    keep_last_part();
  }
  most_divided_ = std::max(most_divided_, divided_);
  use_.places = find_places();
  while (saved_.size() > use_.places) drop_saved();
}

void Trajectory::keep_last_part() {
  const std::size_t last = first_ + count_ - 1, begin = last / use_.part * use_.part;
  for (std::size_t k = 0, in_part = 0; k < begin; ++k) {
    in_part = (k % use_.part == 0 ? 0 : in_part) + bytes_of(states_[k].parts);
    most_divided_ = std::max(most_divided_, in_part);
  }
  if (begin > 0) {
    beside_ = std::move(states_[begin - 1]);
    beside_number_ = begin - 1;
    std::move(states_.begin() + static_cast<std::ptrdiff_t>(begin),
              states_.begin() + static_cast<std::ptrdiff_t>(last + 1), states_.begin());
  }
  states_.resize(use_.part);
  states_.shrink_to_fit();
  first_ = begin;
  count_ = last - begin + 1;
  divided_ = 0;
  for (std::size_t i = 0; i < count_; ++i) divided_ += bytes_of(states_[i].parts);
}

void Trajectory::save(std::size_t part) {
  const Saved& own = saved_.emplace_back(Saved{part, simulation_.save(), recorder_.parts()});
  const std::size_t size = own.bytes.size() + bytes_of(own.parts);
  saved_bytes_ += size;
  largest_saved_ = std::max(largest_saved_, size);
}

void Trajectory::drop_saved() {
  saved_bytes_ -= saved_.back().bytes.size() + bytes_of(saved_.back().parts);
  saved_.pop_back();
}

void Trajectory::begin_window(std::size_t first) {
  first_ = first;
  count_ = 0;
  divided_ = 0;
  for (State& each : states_) each.parts.clear();
}

// The first one is kept in any case if steps may be divided, so that the others can be dropped.
bool Trajectory::keeps(std::size_t part, std::size_t target) const {
  if (saved_.empty()) return use_.places > 0 || recorder_.divides();
  if (saved_.size() >= use_.places) return false;
  const std::size_t last = saved_.back().part, left = target - last + 1;
  return part > last && left > 1 && part >= last + parts_until_kept(left, use_.places - saved_.size() + 1);
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
    save(part);
  else if (is_other)
    largest_saved_ = std::max(largest_saved_, simulation_.save().size());
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
          begin_window(k);
        }
      }
      record();
      times_.push_back(states_[count_ - 1].time);
      here_ = k;
      stay_within_memory();
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
    while (saved_.back().part > part) drop_saved();
  } else {
    std::swap(beside_, states_[count_ - 1]);
    beside_number_ = first_ + count_ - 1;
  }
  begin_window(begin);
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
  for (;;) {
    record();
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
