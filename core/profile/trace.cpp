// The trace in the format of Chrome's trace events: a complete event ("X") for each stage, in microseconds.

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/version.hpp>

#include "profile/recording.hpp"

namespace springnet {
namespace {

using profile::TraceEvent;

constexpr double event_bytes = 110.0;

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

double microseconds(profile::Nanoseconds time) { return 1e-3 * static_cast<double>(time); }

// In the order of their beginning, a stage before its parts.
std::vector<TraceEvent> in_order(const profile::Trace& trace) {
  std::vector<TraceEvent> events = trace.first();
  events.insert(events.end(), trace.last().begin(), trace.last().end());
  std::stable_sort(events.begin(), events.end(), [](const TraceEvent& a, const TraceEvent& b) {
    return a.begin != b.begin ? a.begin < b.begin : a.end > b.end;
  });
  return events;
}

}  // namespace

double Profiler::trace_bytes(std::size_t trace_events) noexcept {
  return 10000.0 + event_bytes * static_cast<double>(trace_events);
}

void Profiler::write_trace(std::ostream& out) const {
  const profile::Recording& recording = *recording_;
  const std::vector<profile::Node>& nodes = recording.lanes().front()->nodes();
  std::vector<std::string> labels(nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k)
    labels[k] = fmt::format(R"("name":{},"cat":"{}")", quoted(nodes[k].name), name_of(nodes[k].kind));
  out << fmt::format(R"({{"displayTimeUnit":"ms","otherData":{{"program":"springnet {}","left_out_events":{}}},)",
                     version(), recording.trace().dropped)
      << "\"traceEvents\":[\n"
      << R"({"name":"process_name","ph":"M","pid":1,"tid":0,"args":{"name":"springnet"}})";
  for (const std::unique_ptr<profile::Lane>& lane : recording.lanes())
    out << fmt::format(
        ",\n"
        R"({{"name":"thread_name","ph":"M","pid":1,"tid":{},"args":{{"name":"{}"}}}})",
        lane->number(), lane->number() == 0 ? std::string("simulation") : fmt::format("thread {}", lane->number() + 1));
  const std::vector<TraceEvent> events = in_order(recording.trace());
  for (const TraceEvent& event : events)
    out << fmt::format(
        ",\n"
        R"({{{},"ph":"X","pid":1,"tid":{},"ts":{:.3f},"dur":{:.3f}}})",
        labels[event.node], event.thread, microseconds(event.begin - recording.origin()),
        microseconds(event.end - event.begin));
  if (recording.trace().dropped > 0 && !recording.trace().last().empty())
    out << fmt::format(
        ",\n"
        R"({{"name":"{} stages before this are left out","ph":"i","s":"g","pid":1,"tid":0,"ts":{:.3f}}})",
        recording.trace().dropped, microseconds(recording.trace().last().front().begin - recording.origin()));
  out << "\n]}\n";
}

}  // namespace springnet
