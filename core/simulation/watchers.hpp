// What a host is told without asking: events and steps through its callbacks, snapshots for a thread that draws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include <springnet/simulation.hpp>

namespace springnet {

// The newest snapshot. One thread puts, any thread takes. The memory of those that nobody holds any more is used again:
// a new page of memory costs more than what is written to it.
class SnapshotShelf {
 public:
  void keep(bool wanted) {
    std::shared_ptr<const Snapshot> last;  // ends after the lock
    const std::lock_guard guard(lock_);
    keeps_ = wanted;
    if (!wanted) newest_.swap(last);
  }
  // One to be filled, with whatever it had.
  [[nodiscard]] std::unique_ptr<Snapshot> blank() {
    const std::lock_guard guard(spares_->lock);
    if (spares_->list.empty()) return std::make_unique<Snapshot>();
    std::unique_ptr<Snapshot> spare = std::move(spares_->list.back());
    spares_->list.pop_back();
    return spare;
  }
  // Of the thread that steps.
  [[nodiscard]] bool keeps() const noexcept { return keeps_; }
  void put(std::unique_ptr<Snapshot> filled) {
    // Whoever lets go last gives it back, which the lock of the spares tells the thread that fills it next.
    std::shared_ptr<const Snapshot> snapshot(filled.release(), [spares = spares_](const Snapshot* used) {
      std::unique_ptr<Snapshot> own(const_cast<Snapshot*>(used));
      const std::lock_guard guard(spares->lock);
      if (spares->list.size() < Spares::most) spares->list.push_back(std::move(own));
    });
    const std::lock_guard guard(lock_);
    newest_.swap(snapshot);  // the one before ends after the lock
  }
  [[nodiscard]] std::shared_ptr<const Snapshot> take() const {
    const std::lock_guard guard(lock_);
    return newest_;
  }

 private:
  struct Spares {
    static constexpr std::size_t most = 2;
    std::mutex lock;
    std::vector<std::unique_ptr<Snapshot>> list;
    Spares() { list.reserve(most); }  // so that a snapshot ends without an exception
  };
  std::shared_ptr<Spares> spares_ = std::make_shared<Spares>();
  mutable std::mutex lock_;
  bool keeps_ = false;
  std::shared_ptr<const Snapshot> newest_;
};

struct Watchers {
  std::function<void(const Event&)> on_event;
  std::function<void(const StepReport&)> on_step;
  std::size_t told = 0;     // events that on_event was told, or that happened before there was one
  bool are_called = false;  // a callback is running
  std::shared_ptr<SnapshotShelf> shelf = std::make_shared<SnapshotShelf>();

  // What the program asked for of the simulation before it was extended.
  void take_over(Watchers& before) {
    on_event = std::move(before.on_event);
    on_step = std::move(before.on_step);
    told = before.told;
    shelf = before.shelf;
  }
  // Tells the events that are new. One whose callback throws counts as told; those after it are told next time.
  void tell_events(const std::vector<Event>& events);
  void tell_step(const StepReport& report);
};

// Numbers that are computed when first asked for at a state, and kept until it changes.
struct KeptNumbers {
  std::vector<double> numbers;
  std::uint64_t version = 0;  // of the state; 0: none
};

}  // namespace springnet
