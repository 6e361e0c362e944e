// Elements at which laws are checked: within the domain that the law declares, and near its edges.
#pragma once

#include <random>
#include <vector>

#include "check/geometry.hpp"
#include "check/law_call.hpp"
#include "check/scene_laws.hpp"

namespace springnet::check {

// An element over several scalars, where its nodal forces or rates are wanted.
struct Placed {
  Corners rest, now;
};

class Points {
 public:
  // typical: values of the parameters around which others are drawn. scene: its elements and parameters are taken as
  // they are, in place of others; null: none. fixed: the law has prepared a table for these parameters, so that others
  // would not fit.
  Points(const LawCall& call, std::vector<double> typical, const SceneLaw* scene, bool fixed, std::uint64_t seed);

  // The stretches q / reference that are checked: those declared, but from a millionth to 2 where the law declares
  // more.
  [[nodiscard]] double lowest() const noexcept { return lowest_; }
  [[nodiscard]] double highest() const noexcept { return highest_; }

  // Elements at rest: no rates, typical parameters, states at their start, inputs without a signal. Lengths of 1 m,
  // 0.37 m and a micrometre; of a scene the median, the smallest and the largest.
  static constexpr std::size_t sizes = 3;
  [[nodiscard]] Point at_rest(std::size_t size = 0, Placed* placed = nullptr) const;
  // Random arguments, well within all bounds.
  [[nodiscard]] Point any();
  [[nodiscard]] std::vector<Point> several(std::size_t count);
  // Invariants as stretched, of a law over one.
  void stretch(Point& point, double stretch) const;
  // Each parameter, state and input at each of its bounds, all else as in `point`. What excludes its bound stays off
  // it by a twentieth of its scale.
  [[nodiscard]] std::vector<Point> edges(const Point& point) const;
  // Random values for the start of a step, close to those of its end.
  void draw_start(Point& point);

  [[nodiscard]] std::mt19937_64& random() noexcept { return random_; }
  [[nodiscard]] double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  // Typical magnitude of a column, for steps of differences.
  [[nodiscard]] double magnitude(std::size_t column, const Point& point) const;

 private:
  [[nodiscard]] double draw(const springnet_parameter& parameter, double typical, double factor);
  void draw_geometry(Point& point, const UsedElement* used);
  void put_parameters(Point& point, const UsedElement* used) const;
  void set_states_at_start(Point& point) const;
  [[nodiscard]] const UsedElement* any_used();  // null: none

  const LawCall& call_;
  std::vector<double> typical_;
  const SceneLaw* scene_;  // null, or one with elements
  bool fixed_;
  std::mt19937_64 random_;
  double lowest_, highest_;
};

// The value of each parameter that a scene would likely give: the default, else the scale, within the bounds.
[[nodiscard]] std::vector<double> typical_parameters(const springnet_component& component);

}  // namespace springnet::check
