// batches, speed: the same bits however a law is called, and what a call costs.
#include <algorithm>
#include <atomic>
#include <numeric>
#include <string>
#include <thread>

#include <fmt/format.h>

#include "check/child.hpp"
#include "check/instruction_sets.hpp"
#include "check/law_checks.hpp"
#include "check/sharing.hpp"

namespace springnet::check {
namespace {

// Empty if parts of `size` elements give the bits of the whole.
std::string compare_parts(const LawCall& call, const std::vector<Point>& points, const Answer& whole, std::size_t size,
                          const How& how) {
  for (std::size_t first = 0; first < points.size(); first += size) {
    const std::size_t end = std::min(points.size(), first + size);
    const Answer part = call(
        {points.begin() + static_cast<std::ptrdiff_t>(first), points.begin() + static_cast<std::ptrdiff_t>(end)}, how);
    std::string text = difference(call, whole, part, first, how.time_step > 0.0);
    if (!text.empty()) return text;
  }
  return {};
}

std::string check_calls(const LawCall& call, const std::vector<Point>& points, How how, const char* what) {
  const Answer whole = call(points, how);
  if (whole.status == SPRINGNET_FAILED) return fmt::format("{} fails: {}", what, whole.message);
  if (whole.status != SPRINGNET_OK) return {};
  for (const InstructionSetName& set : instruction_sets()) {
    for (const std::size_t size : {points.size(), std::size_t{1}, std::size_t{5}, std::size_t{8}, std::size_t{33}}) {
      for (const std::size_t offset : {0u, 1u, 3u}) {
        for (const std::uint64_t shared : {share_nothing, share_all}) {
          how.instruction_set = set.number;
          how.offset = offset;
          how.shared = shared;
          const std::string text = compare_parts(call, points, whole, size, how);
          if (text.empty()) continue;
          return fmt::format("{} with the instruction set {}, {} elements at a time{}{}: {}", what, set.name, size,
                             shared == share_all ? ", strides of 0" : "", offset > 0 ? ", other alignment" : "", text);
        }
      }
    }
  }
  return {};
}

// Some references, parameters and inputs are shared, and the others not.
std::string check_sharings(const LawCall& call, const std::vector<Point>& points, How how, const char* what) {
  for (const std::uint64_t shared : mixed_sharings(call)) {
    const std::vector<Point> mixed = with_shared(call, points, shared);
    how.shared = share_nothing;
    how.instruction_set = SPRINGNET_GENERIC;
    const Answer whole = call(mixed, how);
    if (whole.status != SPRINGNET_OK) continue;  // parameters that do not go together
    how.shared = shared;
    for (const InstructionSetName& set : instruction_sets()) {
      how.instruction_set = set.number;
      const std::string text = difference(call, whole, call(mixed, how), 0, how.time_step > 0.0);
      if (!text.empty())
        return fmt::format("{} with the instruction set {}, {}: {}", what, set.name, told_sharing(call, shared), text);
    }
  }
  return {};
}

// Each output alone, and those without derivatives.
std::string check_outputs(const LawCall& call, const std::vector<Point>& points, How how, const char* what) {
  how.derivatives = true;
  const Answer whole = call(points, how);
  if (whole.status != SPRINGNET_OK) return {};
  for (const InstructionSetName& set : instruction_sets()) {
    how.instruction_set = set.number;
    how.derivatives = false;
    how.only.reset();
    std::string text = difference(call, whole, call(points, how), 0, how.time_step > 0.0);
    if (!text.empty())
      return fmt::format("{} with the instruction set {}, with derivatives and without: {}", what, set.name, text);
    how.derivatives = true;
    for (std::size_t output = 0; output < whole.outputs; ++output) {
      how.only = output;
      text = difference(call, whole, call(points, how), 0, how.time_step > 0.0);
      if (!text.empty())
        return fmt::format("{} with the instruction set {}, asked for together with all others and alone: {}", what,
                           set.name, text);
    }
  }
  return {};
}

// Every count up to that of some elements, and large ones up to more than a host has at a time.
std::string check_counts(const LawCall& call, const std::vector<Point>& points, How how, const char* what) {
  constexpr std::size_t every = 67, one_by_one = 5;
  const auto first = [&](std::size_t count) {
    return std::vector<Point>(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count));
  };
  std::vector<std::size_t> counts(every);
  std::iota(counts.begin(), counts.end(), std::size_t{1});
  for (const std::size_t count : {96u, 128u, 200u, 256u, 333u, 448u, 449u}) counts.push_back(count);
  for (const InstructionSetName& set : instruction_sets()) {
    how.instruction_set = set.number;
    const Answer whole = call(points, how);
    if (whole.status != SPRINGNET_OK) return {};
    std::string text = compare_parts(call, points, whole, one_by_one, how);
    if (!text.empty())
      return fmt::format("{} with the instruction set {}, {} and {} elements at a time: {}", what, set.name,
                         points.size(), one_by_one, text);
    for (const std::size_t count : counts) {
      text = difference(call, whole, call(first(count), how), 0, how.time_step > 0.0);
      if (!text.empty())
        return fmt::format("{} with the instruction set {}, {} and {} elements at a time: {}", what, set.name,
                           points.size(), count, text);
    }
  }
  return {};
}

// Each thread has elements of its own, so that memory that they share shows.
std::string check_threads(const LawCall& call, const std::vector<Point>& points) {
  constexpr std::size_t count = 4, share = 16;
  constexpr int calls = 20'000;
  std::vector<std::vector<Point>> parts;
  std::vector<Answer> expected;
  for (std::size_t t = 0; t < count; ++t) {
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(t * share);
    parts.emplace_back(first, first + share);
    expected.push_back(call(parts.back()));
    if (expected.back().status != SPRINGNET_OK) return expected.back().message;
  }
  std::vector<int> different(count, 0);
  std::vector<std::thread> threads;
  std::atomic<std::size_t> waiting{count};
  for (std::size_t t = 0; t < count; ++t)
    threads.emplace_back([&, t] {
      --waiting;
      while (waiting > 0) std::this_thread::yield();
      try {
        different[t] = call.different_calls(parts[t], expected[t], calls);
      } catch (const std::exception&) {
        different[t] = calls;
      }
    });
  for (std::thread& thread : threads) thread.join();
  const int all = std::accumulate(different.begin(), different.end(), 0);
  if (all == 0) return {};
  return fmt::format(
      "called from {} threads at a time, {} of {} calls answer otherwise than from one: keep no memory "
      "between or within calls that threads share",
      count, all, count * static_cast<std::size_t>(calls));
}

// ns for each element of a batch of 64: the force alone, the fastest of some.
double cost(const LawSubject& subject) {
  constexpr std::size_t count = 64;
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const std::vector<Point> points(count, ready.points().any());
  const InstructionSetName best = instruction_sets().back();
  double fastest = 1e300;
  for (int k = 0; k < 5; ++k)
    fastest = std::min(fastest, call.time_of(points, {.instruction_set = best.number, .shared = share_all}, 2000));
  return fastest / static_cast<double>(count) * 1e9;
}

}  // namespace

Outcome check_batches(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  std::vector<Point> many = ready.points().several(450);
  // Elements of one batch have one time.
  for (Point& point : many) point[l.time()] = many[0][l.time()];
  const std::vector<Point> own(many.begin(), many.begin() + 67), few(many.begin(), many.begin() + 19);
  const std::vector<Point> shared = with_shared(call, own, share_all);
  struct Call {
    How how;
    const char* what;
  };
  std::vector<Call> calls{{{}, "an evaluation"}, {{.derivatives = true}, "an evaluation"}};
  if (l.states > 0) calls.push_back({{.time_step = 0.01, .order = call.law().update_order}, "an update"});
  for (const auto& [how, what] : calls) {
    const bool of_update = how.time_step > 0.0;
    now_doing(of_update ? "updating batches of several sizes" : "evaluating batches of several sizes");
    std::string text = check_calls(call, own, how, what);
    if (text.empty()) text = check_calls(call, shared, how, what);
    if (text.empty()) text = check_counts(call, many, how, what);
    now_doing(of_update ? "updating with some strides of 0" : "evaluating with some strides of 0");
    if (text.empty()) text = check_sharings(call, own, how, what);
    if (!text.empty())
      return {Result::failed, text + ": an element's answers must depend on its own inputs alone, bit by bit"};
    now_doing(of_update ? "updating with one output alone" : "evaluating one output alone");
    text = check_outputs(call, few, how, what);
    if (!text.empty())
      return {Result::failed, text + ": an output must not depend on which others are asked for, bit by bit"};
  }
  if (call.has(SPRINGNET_CALLING_THREAD_ONLY)) return {Result::passed, "called from one thread alone, as declared"};
  now_doing("evaluating from several threads at a time");
  const std::string text = check_threads(call, own);
  if (!text.empty()) return {Result::failed, text + ", or declare SPRINGNET_CALLING_THREAD_ONLY"};
  return {};
}

Outcome check_speed(const LawSubject& subject) {
  const double own = cost(subject);
  const auto linear = subject.host == nullptr ? nullptr : subject.host->find(ComponentKind::spring_function, "linear");
  if (linear == nullptr) return {Result::passed, fmt::format("{:.2g} ns an element", own)};
  LawSubject other = subject;
  other.component = linear;
  other.scene = nullptr;
  const double reference = cost(other);
  return {Result::passed, fmt::format("{:.2g} ns an element, {:.1f} times `linear`", own, own / reference)};
}

}  // namespace springnet::check
