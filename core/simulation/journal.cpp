#include "simulation/journal.hpp"

#include <algorithm>
#include <utility>

#include <springnet/printable.hpp>

namespace springnet {
namespace {

constexpr std::size_t max_notes = 200, max_numbers = 500, max_note_length = 2000;

}  // namespace

void Journal::take_over(const Journal& before, const layers::NumbersBefore& numbers) {
  events_ = before.events_;
  for (Event& event : events_) event.surface = numbers.surface(event.surface);
  notes_ = before.notes_;
  numbers_ = before.numbers_;
}

void Journal::archive(Archive& archive) {
  const std::lock_guard guard(lock_);
  constexpr std::size_t least_event = 137;  // bytes
  events_.resize(archive.count(events_.size(), least_event, "events"));
  for (Event& each : events_) {
    archive.below(each.kind, 7, "a kind of events");
    archive.number(each.time);
    archive.number(each.index);
    archive.flag(each.element);
    archive.number(each.surface);
    for (Vector3* vector : {&each.impulse, &each.position, &each.velocity, &each.normal}) archive.vector(*vector);
    archive.number(each.value);
    archive.number(each.force);
  }
  notes_.resize(archive.count(notes_.size(), sizeof(std::uint64_t), "notes"));
  for (std::string& each : notes_) archive.text(each);
  std::vector<std::pair<std::string, double>> numbers(numbers_.begin(), numbers_.end());
  numbers.resize(archive.count(numbers.size(), sizeof(std::uint64_t) + sizeof(double), "numbers"));
  for (auto& [name, value] : numbers) {
    archive.text(name);
    archive.number(value);
  }
  if (archive.reads()) numbers_ = {numbers.begin(), numbers.end()};
}

void Journal::note(const std::string& text) {
  const std::lock_guard guard(lock_);
  const std::string shown = printable(text, max_note_length);
  if (notes_.size() < max_notes && std::find(notes_.begin(), notes_.end(), shown) == notes_.end())
    notes_.push_back(shown);
}

void Journal::set_number(const std::string& name, double value) {
  if (numbers_.size() < max_numbers || numbers_.contains(name)) numbers_[name] = value;
}

void Journal::report(const std::string& name, double value) {
  const std::lock_guard guard(lock_);
  set_number(printable(name), value);
}

double Journal::count(const std::string& name) {
  const std::lock_guard guard(lock_);
  const auto known = numbers_.find(name);
  const double sum = known == numbers_.end() ? 1.0 : known->second + 1.0;
  set_number(name, sum);
  return sum;
}

}  // namespace springnet
