// Where the time of a simulation goes: the stages of its steps, its laws, its integrator, and what else a program does
// between the steps. Give SimulationOptions a profiler; results do not depend on it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/export.hpp>

namespace springnet {

namespace profile {
class Recording;
}

// A part of the work, by name, within the stage that it is a part of.
struct ProfileStage {
  enum class Kind : std::uint8_t { stage, integrator, spring_function, viscosity_function, neuron, output };
  Kind kind = Kind::stage;
  std::string name;            // that of the component, for instance "linear", or of the stage: core/docs/output.md
  std::ptrdiff_t parent = -1;  // index in Profile::stages, smaller than its own; -1: part of no other
  double seconds = 0.0;        // of the clock. Where several threads share the work, their mean
  double own_seconds = 0.0;    // of these, outside of its own parts
  std::uint64_t calls = 0;     // of all threads
  bool estimated = false;      // seconds and calls, from calls picked at random: too short for a clock each time
};

struct Profile {
  double seconds = 0.0;              // of all stages that are part of no other; own_seconds of all stages add up to it
  std::vector<ProfileStage> stages;  // parts after the stage they belong to, the longest first
};
// "stage", "integrator", "spring function", …
[[nodiscard]] SPRINGNET_API std::string_view name_of(ProfileStage::Kind kind) noexcept;
// "sweep", "view.html"; of a component with its kind: "spring function linear".
[[nodiscard]] SPRINGNET_API std::string label_of(const ProfileStage& stage);

// Takes the time of what runs within its scopes; Simulation opens one for each step. A step costs it about 0.1 us for
// each call of a host function, and a percent of the work within. It records one thread at a time, with those that help
// it: a scope that is opened while another thread has one open records nothing.
class SPRINGNET_API Profiler {
 public:
  // trace_events: of how many stages the times are kept for write_trace(): the first half of them, and the last. About
  // 24 bytes each.
  explicit Profiler(std::size_t trace_events = 0);
  ~Profiler();
  Profiler(Profiler&&) noexcept;
  Profiler& operator=(Profiler&&) noexcept;

  // So far; of stages that have not ended, up to now.
  [[nodiscard]] Profile profile() const;
  // Forgets everything so far. Has no effect within a scope.
  void clear();

  // The course of the stages that have ended as Chrome trace events, JSON that ui.perfetto.dev and chrome://tracing
  // open. Its size is at most trace_bytes() of that number of events, unless names are very long.
  void write_trace(std::ostream& out) const;
  [[nodiscard]] static double trace_bytes(std::size_t trace_events) noexcept;

  // A stage of the program itself, as long as this lives: drawing, for instance. Stages of the engine within it are its
  // parts. `profiler` may be null.
  class Scope {
   public:
    Scope(Profiler* profiler, const char* name) noexcept;
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    profile::Recording* recording_;
    void* outer_stages_ = nullptr;  // what this thread recorded before
    void* outer_parts_ = nullptr;
    bool entered_ = false;
    bool begun_ = false;
  };

 private:
  std::unique_ptr<profile::Recording> recording_;
};

}  // namespace springnet
