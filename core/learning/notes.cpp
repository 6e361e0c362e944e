#include "learning/notes.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "text/counted.hpp"

namespace springnet::learning {

namespace {

// "3", "0-3 and 7", "0-3, 7 and 9", "0-3, 7 and 30 more" of ascending numbers.
std::string ranges_of(const std::vector<std::uint32_t>& numbers) {
  constexpr std::size_t most = 24;
  std::vector<std::string> parts;
  std::size_t told = 0;
  for (std::size_t k = 0; k < numbers.size() && parts.size() < most;) {
    std::size_t last = k;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    parts.push_back(last == k ? fmt::format("{}", numbers[k]) : fmt::format("{}-{}", numbers[k], numbers[last]));
    k = told = last + 1;
  }
  if (told < numbers.size()) parts.push_back(fmt::format("{} more", numbers.size() - told));
  std::string text = parts.front();
  for (std::size_t k = 1; k < parts.size(); ++k) text += (k + 1 < parts.size() ? ", " : " and ") + parts[k];
  return text;
}

}  // namespace

std::string list_of(const std::vector<LearnedParameter>& parameters,
                    const std::function<bool(const LearnedParameter&)>& is_meant) {
  struct Kind {
    std::string name, member;
    std::vector<std::uint32_t> members;
  };
  std::vector<Kind> kinds;  // in the order of the parameters
  for (const LearnedParameter& each : parameters) {
    if (!is_meant(each)) continue;
    const std::string name = name_of(each);
    auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const Kind& known) { return known.name == name; });
    if (kind == kinds.end())
      kind = kinds.insert(kind, {name, std::string(member_name(each.kind, each.of_elements)), {}});
    kind->members.push_back(each.member);
  }
  std::string text;
  for (Kind& each : kinds) {
    std::sort(each.members.begin(), each.members.end());
    each.members.erase(std::unique(each.members.begin(), each.members.end()), each.members.end());
    if (!text.empty()) text += "; ";
    text += fmt::format("{} of {}{} {}", each.name, each.member, each.members.size() > 1 ? "s" : "",
                        ranges_of(each.members));
  }
  return text;
}

std::string note_of_events(const std::vector<Event>& events, const std::vector<Event>& at_start) {
  using Key = std::tuple<Event::Kind, bool, std::uint32_t, std::int32_t, double>;
  const auto key = [](const Event& each) { return Key{each.kind, each.element, each.index, each.surface, each.time}; };
  std::multiset<Key> known;
  for (const Event& each : at_start) known.insert(key(each));
  std::size_t ruptures = 0, contacts = 0, moved = 0;
  const Event* first = nullptr;
  for (const Event& each : events) {
    if (each.kind == Event::Kind::cut) continue;  // at a time that is given
    if (first == nullptr) first = &each;
    ++(each.kind == Event::Kind::ruptured ? ruptures : contacts);
    if (const auto found = known.find(key(each)); found != known.end())
      known.erase(found);
    else
      ++moved;
  }
  if (first == nullptr) return {};
  std::string text;
  if (ruptures > 0) text = counted(ruptures, "rupture");
  if (contacts > 0) text += (text.empty() ? "" : " and ") + counted(contacts, "change") + " of contact";
  return fmt::format(
      "The motion has {}, from {:g} s on; {} of them in other steps than with the values at the start. Derivatives are "
      "those of a motion in which the same happens in the same steps: how the times of events move with the values is "
      "not part of them; with events = \"located\" it is, but for steps that are then not divided.",
      text, first->time, moved > 0 ? fmt::format("{}", moved) : "none");
}

void add_notes(LearnedNet& learned) {
  const auto count = [&](const auto& is_meant) {
    return static_cast<std::size_t>(std::count_if(learned.parameters.begin(), learned.parameters.end(), is_meant));
  };
  const auto add = [&](const auto& is_meant, const char* one, const char* several) {
    const std::size_t number = count(is_meant);
    if (number == 0) return;
    learned.notes.push_back(fmt::format("{} {}: {}.", counted(number, "value"), number == 1 ? one : several,
                                        list_of(learned.parameters, is_meant)));
  };
  add([](const LearnedParameter& each) { return !each.has_influence; },
      "has no influence at all on what was observed, and stays as it was",
      "have no influence at all on what was observed, and stay as they were");
  add([](const LearnedParameter& each) { return each.at_bound; },
      "is at a bound; the observations would have it beyond, or the model is not theirs",
      "are at a bound; the observations would have them beyond, or the model is not theirs");
  add([](const LearnedParameter& each) { return each.is_outside; },
      "is outside of its interval, which is what the data alone say: the guess, smoothness or a bound holds it there",
      "are outside of their intervals, which are what the data alone say: the guess, smoothness or a bound holds them "
      "there");
  constexpr double much_greater = 2.0;
  const HeldOut& held_out = learned.held_out;
  if (held_out.observed == 0) return;
  if (held_out.rms > held_out.start_rms)
    learned.notes.push_back(fmt::format(
        "What was held out is described worse by the learned values than by those at the start: the rms of the "
        "weighted differences is {:.4g}, it was {:.4g}.",
        held_out.rms, held_out.start_rms));
  else if (held_out.rms > much_greater * learned.rms)
    learned.notes.push_back(fmt::format(
        "The rms of the weighted differences is {:.4g} for what was held out, and {:.4g} for what was learned "
        "from: the values follow the noise of the latter, or the model does not hold for both.",
        held_out.rms, learned.rms));
}

}  // namespace springnet::learning
