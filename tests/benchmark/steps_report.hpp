// What the table of steps writes: Markdown for core/docs/propagation.md, JSON for tests/benchmark/compare.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace springnet::benchmark {

enum class Kind {
  naive,      // a step, or a sweep, in naive explicit steps of the same net
  reference,  // a whole scene against CVODE
  threads     // two threads against one
};

struct Result {
  std::string name;
  Kind kind = Kind::naive;
  std::size_t nodes = 0, springs = 0, elements = 0;
  std::string unit;                                                 // of what is timed: "step", "sweep", "scene"
  double seconds = std::numeric_limits<double>::quiet_NaN();        // of one unit
  double other_seconds = std::numeric_limits<double>::quiet_NaN();  // naive step, CVODE, one thread
  double sweeps = 0.0, krylov_iterations = 0.0;                     // a step
  std::optional<double> floor{};                                    // that `ratio` should not exceed
  std::string failure{};

  // Less is better in every kind.
  [[nodiscard]] double ratio() const noexcept { return seconds / other_seconds; }
};

// Where and with what the program was built and runs.
struct Surroundings {
  std::string date, compiler, build, processor;
  unsigned processors = 0;
  std::string instruction_set;  // of the engine
};
[[nodiscard]] Surroundings surroundings();

// A line for each result, under the heading of its kind where that changes.
class MarkdownTable {
 public:
  explicit MarkdownTable(const Surroundings& where);
  void print(const Result& result);

 private:
  std::optional<Kind> kind_;
};

// Throws std::runtime_error if the file cannot be written.
void write_json(const std::filesystem::path& file, const Surroundings& where, const std::vector<Result>& results,
                const std::string& arguments);

}  // namespace springnet::benchmark
