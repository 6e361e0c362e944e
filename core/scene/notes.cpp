#include <algorithm>

#include <fmt/format.h>

#include <springnet/scene.hpp>

namespace springnet {
namespace {

std::string named(const std::string& what, const std::string& name, std::size_t index) {
  return name.empty() ? fmt::format("{} {}", what, index) : fmt::format("{} '{}'", what, name);
}

// Collects events outside of [0, duration].
class Unreached {
 public:
  explicit Unreached(double duration) : duration_(duration) {}

  void cut(double time, std::size_t index) {
    if (time > duration_) add(fmt::format("Cut {} at {:g} s", index, time));
  }
  void change(double time, std::size_t index) {
    if (time > duration_) add(fmt::format("Change {} at {:g} s", index, time));
  }
  void window(const std::string& what, double from, double until) {
    if (from >= duration_) add(fmt::format("{}, which starts at {:g} s,", what, from));
    if (until <= 0) add(fmt::format("{}, which ends at {:g} s,", what, until));
  }
  // A motion or a turn (`what`) of the object `whose`.
  template <class Course>
  void course(std::string_view what, const std::string& whose, const Course& course) {
    const bool table = !course.times.empty();
    window(fmt::format("The {} of {}", what, whose), table ? course.times.front() : course.from,
           table ? course.times.back() : course.until);
  }
  template <class PlaneOrInstrument>
  void obstacle(const std::string& kind, const PlaneOrInstrument& obstacle, std::size_t index) {
    const std::string whose = named(kind, obstacle.name, index);
    if (obstacle.motion) course("motion", whose, *obstacle.motion);
    if (obstacle.turn) course("turn", whose, *obstacle.turn);
  }
  [[nodiscard]] std::vector<std::string> take() { return std::move(notes_); }

 private:
  void add(const std::string& what) {
    notes_.push_back(fmt::format("{} is outside of the simulated time, 0 to {:g} s.", what, duration_));
  }

  double duration_;  // s
  std::vector<std::string> notes_;
};

// Notes options without effect.
void add_idle_output(const OutputOptions& output, std::vector<std::string>& notes) {
  if (output.precision == OutputOptions::Precision::float32 && output.format == OutputOptions::Format::csv &&
      !output.vtk) {
    notes.emplace_back(
        "output.precision = \"single\" has no effect: numbers in text have all their digits; it applies to "
        "output.format = \"binary\" and output.vtk = true.");
  }
  if (output.vtk_interval > 0 && !output.vtk) {
    notes.emplace_back("output.vtk_interval has no effect without output.vtk = true.");
  }
}

}  // namespace

std::vector<std::string> notes_of(const Scene& scene) {
  std::vector<std::string> notes = scene.notes;
  add_idle_output(scene.output, notes);
  if (!(scene.duration > 0)) return notes;  // such a scene only shows its start
  const Network& network = scene.network;
  // Tolerates rounding of a duration that is a multiple of the time step.
  if (const double step = scene.options.time_step; step > 1.000001 * scene.duration) {
    notes.push_back(
        fmt::format("time_step, {:g} s, is longer than the duration, {:g} s: the run is one time step of {:g} s.", step,
                    scene.duration, scene.duration));
  }
  Unreached unreached(scene.duration);
  for (std::size_t k = 0; k < network.loads().size(); ++k) {
    const Load& load = network.loads()[k];
    unreached.window(fmt::format("Force {}", k), load.from, load.until);
    if (!load.course.times.empty())
      unreached.window(fmt::format("The table of force {}", k), load.course.times.front(), load.course.times.back());
    const auto is_fixed = [&](NodeIndex node) { return network.nodes()[node].fixed; };
    if (std::all_of(load.nodes.begin(), load.nodes.end(), is_fixed) &&
        std::all_of(load.faces.begin(), load.faces.end(),
                    [&](const Face& face) { return std::all_of(face.begin(), face.end(), is_fixed); }))
      notes.push_back(fmt::format("Force {} acts on fixed or moved nodes only: it moves nothing.", k));
  }
  for (std::size_t k = 0; k < network.cuts().size(); ++k) unreached.cut(network.cuts()[k].time, k);
  for (std::size_t k = 0; k < network.changes().size(); ++k) unreached.change(network.changes()[k].time, k);
  for (std::size_t k = 0; k < network.moves().size(); ++k) {
    unreached.course("motion", fmt::format("the nodes of move {}", k), network.moves()[k].motion);
  }
  for (std::size_t k = 0; k < network.planes().size(); ++k) unreached.obstacle("plane", network.planes()[k], k);
  for (std::size_t k = 0; k < network.instruments().size(); ++k) {
    unreached.obstacle("instrument", network.instruments()[k], k);
  }
  for (std::string& note : unreached.take()) notes.push_back(std::move(note));
  return notes;
}

}  // namespace springnet
