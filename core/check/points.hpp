// Elements at which laws are checked: within the domain that the law declares, and near its edges.
#pragma once

#include <random>
#include <vector>

#include "check/geometry.hpp"
#include "check/law_call.hpp"

namespace springnet::check {

// An element over several scalars, where its nodal forces or rates are wanted.
struct Placed {
  Corners rest, now;
};

class Points {
 public:
  // typical: values of the parameters around which others are drawn. from_scene: they are a user's, and others stay
  // close to them. fixed: the law has prepared a table for these parameters, so that others would not fit.
  Points(const LawCall& call, std::vector<double> typical, bool from_scene, bool fixed, std::uint64_t seed);

  // The stretches q / reference that are checked: those declared, but from a millionth to 2 where the law declares
  // more.
  [[nodiscard]] double lowest() const noexcept { return lowest_; }
  [[nodiscard]] double highest() const noexcept { return highest_; }

  // At rest: references of the size given (1: lengths of about 1 m), no rates, typical parameters, states at their
  // start, inputs without a signal.
  [[nodiscard]] Point at_rest(double size = 1.0, Placed* placed = nullptr) const;
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
  void draw_geometry(Point& point);
  void set_states_at_start(Point& point) const;

  const LawCall& call_;
  std::vector<double> typical_;
  bool from_scene_, fixed_;
  std::mt19937_64 random_;
  double lowest_, highest_;
};

// The value of each parameter that a scene would likely give: the default, else the scale, within the bounds.
[[nodiscard]] std::vector<double> typical_parameters(const springnet_component& component);

}  // namespace springnet::check
