// Gravity and forces on nodes: those of the scene, which change over time, and those of the embedding program.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "layers/evaluator.hpp"
#include "network/load_course.hpp"
#include "text/archive.hpp"

namespace springnet {

class Loads {
 public:
  // The layout must outlive it.
  Loads(const Network& network, const layers::Layout& layout);

  enum class Change {
    none,
    varied,   // a factor changed
    switched  // a load started or ended, at least for a part of the step
  };
  // Averages the scene's loads over [from, until], s, so that their impulse is exact for any step. If the interval is
  // not finite, or empty, takes the loads right after `from`.
  Change set_interval(double from, double until);
  // In its scope loads that vary over the present interval are those at a time of it, s, not their means.
  class Instant {
   public:
    Instant(Loads& loads, double time);
    ~Instant();
    Instant(const Instant&) = delete;
    Instant& operator=(const Instant&) = delete;

   private:
    Loads& loads_;
    std::vector<std::pair<std::size_t, double>> means_;  // of entries that vary: their weights
  };
  // From now on the loads are those at the time last given to follow().
  Change begin_following(double time);
  // After begin_following(): takes the loads right after `time`, s. Otherwise does nothing.
  void follow(double time) {
    if (follows_ && time != time_) static_cast<void>(set_time(time));
  }
  // The next time after `time` at which a load is switched or its course has a kink; infinity if none.
  [[nodiscard]] double next_switch(double time) const noexcept;
  // To be called after faces were removed from the layout.
  void faces_changed();

  void set_host_force(std::uint32_t node, const Vector3& force);
  [[nodiscard]] Vector3 host_force(std::uint32_t node) const {
    return host_[0].empty() ? Vector3(Vector3::Zero()) : Vector3(host_[0][node], host_[1][node], host_[2][node]);
  }
  // Of a load's forces, tractions and pressures: 1 unless set.
  void set_factor(std::size_t load, double factor);
  [[nodiscard]] double factor(std::size_t load) const { return entries_[load].factor; }
  [[nodiscard]] std::size_t count() const noexcept { return entries_.size(); }
  void set_gravity(const Vector3& acceleration) noexcept { gravity_ = acceleration; }
  [[nodiscard]] const Vector3& gravity() const noexcept { return gravity_; }
  // Gravity and forces of the program, of the network before it was extended.
  void take_over(const Loads& before, const layers::NumbersBefore& numbers);
  // What changes over time, and what the program has set.
  void archive(Archive& archive);
  // Valid until the next change.
  [[nodiscard]] layers::ExternalForces external() noexcept;
  // Greatest force of one load on a node at any time, N; of a following pressure, with the faces as at the start.
  [[nodiscard]] double greatest() const noexcept { return greatest_; }

 private:
  struct Entry {
    std::vector<std::uint32_t> nodes;  // engine's
    Vector3 force;                     // N, on each
    // Loads on faces with a fixed direction, summed up by node, in the engine's order.
    std::vector<std::pair<std::uint32_t, Vector3>> on_faces;
    std::vector<Vector3> face_third;  // N, [face] on each of its nodes
    double pressure;                  // Pa, if it follows the faces; else 0
    LoadCourse course;
    double from, until;
    double share;   // of the step within the window
    double weight;  // share times the course
    double factor = 1.0;
  };
  Change set_time(double time);
  [[nodiscard]] static Change weigh(Entry& entry, double share, double weight) noexcept;
  void sum_faces(std::size_t load);
  void gather();

  const layers::Layout& layout_;
  Vector3 gravity_;
  std::vector<Entry> entries_;
  double greatest_ = 0.0;
  bool follows_ = false;
  double time_ = 0.0, from_ = 0.0, until_ = 0.0;  // s
  std::vector<double> host_[3];                   // empty: none set
  std::vector<double> total_[3];                  // empty: no loads at all
  std::vector<double> pressure_;                  // [load] Pa, of following pressures
  bool any_pressure_ = false;                     // now
  std::size_t node_count_;
};

}  // namespace springnet
