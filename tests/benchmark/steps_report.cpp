#include "steps_report.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <thread>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "layers/instruction_set.hpp"

namespace springnet::benchmark {
namespace {

// Three digits, without an exponent where the number is not small.
std::string digits(double value) {
  if (!(value < 100.0)) return fmt::format("{:.0f}", value);
  return fmt::format("{:.3g}", value);
}

std::string floor_of(const Result& result) { return result.floor ? fmt::format("{:.3g}", *result.floor) : ""; }

std::string processor_name() {
  std::ifstream stream("/proc/cpuinfo");
  for (std::string line; std::getline(stream, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

std::string compiler_name() {
#if defined(__clang__)
  return fmt::format("Clang {}", __clang_version__);
#else
  return fmt::format("GCC {}", __VERSION__);
#endif
}

std::string_view name_of(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx2:
      return "AVX2";
    case InstructionSet::avx512:
      return "AVX-512";
    case InstructionSet::best:
    case InstructionSet::generic:
      break;
  }
  return "generic";
}

std::string_view name_of(Kind kind) {
  switch (kind) {
    case Kind::naive:
      return "naive";
    case Kind::reference:
      return "reference";
    case Kind::threads:
      break;
  }
  return "threads";
}

void print_heading(Kind kind) {
  switch (kind) {
    case Kind::naive:
      fmt::print(
          "| net | nodes | springs | elements | of one | ms | sweeps a step | iterations a step | naive step, ms | "
          "ratio | floor |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
      return;
    case Kind::reference:
      fmt::print("| scene | recurrent, s | CVODE, s | ratio | floor |\n|---|---|---|---|---|\n");
      return;
    case Kind::threads:
      fmt::print("| net | one thread, ms a step | two, ms | times as fast | floor |\n|---|---|---|---|---|\n");
      return;
  }
}

void print_row(const Result& r) {
  constexpr double ms = 1e3;
  switch (r.kind) {
    case Kind::naive:
      fmt::print("| {} | {} | {} | {} | {} | {} | {:.3g} | {} | {:.3g} | {} | {} |\n", r.name, r.nodes, r.springs,
                 r.elements, r.unit, digits(ms * r.seconds), r.sweeps, digits(r.krylov_iterations),
                 ms * r.other_seconds, digits(r.ratio()), floor_of(r));
      return;
    case Kind::reference:
      fmt::print("| {} | {:.3g} | {:.3g} | {:.2f} | {} |\n", r.name, r.seconds, r.other_seconds, r.ratio(),
                 floor_of(r));
      return;
    case Kind::threads:
      fmt::print("| {} | {} | {} | {:.2f} | {} |\n", r.name, digits(ms * r.other_seconds), digits(ms * r.seconds),
                 1.0 / r.ratio(), r.floor ? fmt::format("{:.2g}", 1.0 / *r.floor) : "");
      return;
  }
}

}  // namespace

Surroundings surroundings() {
  Surroundings where;
  where.date =
      fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
  where.compiler = compiler_name();
  where.build = SPRINGNET_BUILD_TYPE;
  where.processor = processor_name();
  where.processors = std::thread::hardware_concurrency();
  where.instruction_set = name_of(layers::choose_instruction_set(InstructionSet::best));
  return where;
}

MarkdownTable::MarkdownTable(const Surroundings& where) {
  fmt::print("Measured {} with {} ({}) on {} of {}, {}.\n", where.date, where.compiler, where.build,
             where.processors == 1 ? "one processor" : fmt::format("{} processors", where.processors), where.processor,
             where.instruction_set);
}

void MarkdownTable::print(const Result& result) {
  if (kind_ != result.kind) {
    fmt::print("\n");
    print_heading(result.kind);
    kind_ = result.kind;
  }
  if (result.failure.empty()) {
    print_row(result);
  } else {
    fmt::print("| {} | failed: {} |\n", result.name, result.failure);
  }
  std::fflush(stdout);
}

void write_json(const std::filesystem::path& file, const Surroundings& where, const std::vector<Result>& results,
                const std::string& arguments) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Result& r : results) {
    nlohmann::ordered_json row{{"name", r.name},       {"kind", name_of(r.kind)}, {"nodes", r.nodes},
                               {"springs", r.springs}, {"elements", r.elements},  {"unit", r.unit}};
    if (r.failure.empty()) {
      row["seconds"] = r.seconds;
      row[r.kind == Kind::naive       ? "naive_seconds"
          : r.kind == Kind::reference ? "cvode_seconds"
                                      : "one_thread_seconds"] = r.other_seconds;
      row["sweeps_per_step"] = r.sweeps;
      row["krylov_iterations_per_step"] = r.krylov_iterations;
      row["ratio"] = r.ratio();
    } else {
      row["failure"] = r.failure;
    }
    if (r.floor) row["floor"] = *r.floor;
    rows.push_back(std::move(row));
  }
  const nlohmann::ordered_json document{
      {"format", "springnet steps table 1"},
      {"date", where.date},
      {"compiler", where.compiler},
      {"build", where.build},
      {"processor", where.processor},
      {"processors", where.processors},
      {"instruction_set", where.instruction_set},
      {"arguments", arguments},
      {"rows", std::move(rows)},
  };
  std::ofstream stream(file);
  stream << document.dump(2) << '\n';
  stream.close();
  if (!stream) throw std::runtime_error(fmt::format("cannot write {}", file.string()));
}

}  // namespace springnet::benchmark
