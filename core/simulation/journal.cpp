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
  topics_ = before.topics_;
  numbers_ = before.numbers_;
}

void Journal::archive(Archive& archive) {
  const std::lock_guard guard(lock_);
  constexpr std::size_t least_event = 155;  // bytes
  events_.resize(archive.count(events_.size(), least_event, "events"));
  for (Event& each : events_) {
    archive.below(each.kind, 9, "a kind of events");
    archive.number(each.time);
    archive.number(each.index);
    archive.flag(each.element);
    archive.number(each.surface);
    for (Vector3* vector : {&each.impulse, &each.position, &each.velocity, &each.normal}) archive.vector(*vector);
    archive.number(each.value);
    archive.number(each.force);
    archive.numbers(each.pair.data(), each.pair.size());
    archive.number(each.pair_first);
    archive.below(each.pair_count, each.pair.size() + 1, "a node of two bodies in contact");
  }
  for (std::vector<std::string>* texts : {&notes_, &topics_}) {
    texts->resize(archive.count(texts->size(), sizeof(std::uint64_t), "notes"));
    for (std::string& each : *texts) archive.text(each);
  }
  std::vector<std::pair<std::string, double>> numbers(numbers_.begin(), numbers_.end());
  numbers.resize(archive.count(numbers.size(), sizeof(std::uint64_t) + sizeof(double), "numbers"));
  for (auto& [name, value] : numbers) {
    archive.text(name);
    archive.number(value);
  }
  if (archive.reads()) numbers_ = {numbers.begin(), numbers.end()};
}

void Journal::note(const std::string& text, const std::string& topic) {
  const std::lock_guard guard(lock_);
  const auto has = [](const std::vector<std::string>& texts, const std::string& each) {
    return std::find(texts.begin(), texts.end(), each) != texts.end();
  };
  const std::string shown = printable(text, max_note_length), of = printable(topic, max_note_length);
  if (notes_.size() >= max_notes || has(notes_, shown) || has(topics_, of)) return;
  notes_.push_back(shown);
  if (!of.empty()) topics_.push_back(of);
}

void Journal::set_number(const std::string& name, double value) {
  if (numbers_.size() < max_numbers || numbers_.contains(name)) numbers_[name] = value;
}

void Journal::report(const std::string& name, double value) {
  const std::lock_guard guard(lock_);
  set_number(printable(name), value);
}

double Journal::count(const std::string& name, double more) {
  const std::lock_guard guard(lock_);
  const std::string shown = printable(name);
  const auto known = numbers_.find(shown);
  const double sum = known == numbers_.end() ? more : known->second + more;
  set_number(shown, sum);
  return sum;
}

}  // namespace springnet
