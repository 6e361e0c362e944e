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
        for (const bool share : {false, true}) {
          how.instruction_set = set.number;
          how.offset = offset;
          how.share = share;
          const std::string text = compare_parts(call, points, whole, size, how);
          if (text.empty()) continue;
          return fmt::format("{} with the instruction set {}, {} elements at a time{}{}: {}", what, set.name, size,
                             share ? ", strides of 0" : "", offset > 0 ? ", other alignment" : "", text);
        }
      }
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
    fastest = std::min(fastest, call.time_of(points, {.instruction_set = best.number, .share = true}, 2000));
  return fastest / static_cast<double>(count) * 1e9;
}

}  // namespace

Outcome check_batches(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  std::vector<Point> own = ready.points().several(67);
  // Elements of one batch have one time.
  for (Point& point : own) point[l.time()] = own[0][l.time()];
  std::vector<Point> shared = own;
  for (Point& point : shared)
    for (std::size_t c = l.parameter(0); c < l.time(); ++c)
      if (c < l.state(0) || c >= l.input(0)) point[c] = own[0][c];
  for (Point& point : shared)
    for (std::size_t i = 0; i < l.inputs; ++i) point[l.start_input(i)] = own[0][l.start_input(i)];
  for (const auto* points : {&own, &shared}) {
    now_doing("evaluating batches of several sizes");
    std::string text = check_calls(call, *points, {}, "an evaluation");
    if (text.empty()) text = check_calls(call, *points, {.derivatives = true}, "an evaluation");
    if (text.empty() && l.states > 0) {
      now_doing("updating batches of several sizes");
      text = check_calls(call, *points, {.time_step = 0.01, .order = call.law().update_order}, "an update");
    }
    if (!text.empty())
      return {Result::failed, text + ": an element's answers must depend on its own inputs alone, bit by bit"};
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
