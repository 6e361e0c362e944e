// What a law's curves are drawn over: the length of a spring, an angle, the stretch of a regular element along an edge.
#pragma once

#include <string>
#include <vector>

#include "law_caller.hpp"

namespace springnet::tool {

class LawCourse {
 public:
  // reference: of laws over one invariant, in its unit.
  LawCourse(const springnet_law& law, double reference);

  [[nodiscard]] std::vector<Numbers> references() const;
  // [invariant] at these places of the course, in the unit of x.
  [[nodiscard]] std::vector<Numbers> values(const Numbers& x) const;
  // [invariant] at x_at_rest() while x grows at these speeds.
  [[nodiscard]] std::vector<Numbers> rates(const Numbers& speeds) const;

  [[nodiscard]] const std::string& name() const { return name_; }  // "length", "stretch along edge 01"
  [[nodiscard]] const std::string& unit() const { return unit_; }  // of x; "1": none
  [[nodiscard]] double x_at_rest() const { return x_at_rest_; }
  // One of it is the reference value: declared ranges are in these.
  [[nodiscard]] double x_of_stretch() const { return x_of_stretch_; }
  // Whether declared ranges, which are stretches, are places of this course.
  [[nodiscard]] bool is_stretch() const { return x_of_stretch_ > 0.0; }
  // Drawn unless the user says otherwise.
  [[nodiscard]] double default_from() const { return from_; }
  [[nodiscard]] double default_to() const { return to_; }
  // What the element is, for a note; empty for a single invariant.
  [[nodiscard]] const std::string& element() const { return element_; }

  // Of invariant i: its name, and the units of its generalised force, of dQ/dq and of dQ/dq'.
  struct Units {
    std::string name, unit, force, by_value, by_rate;
  };
  [[nodiscard]] Units units(std::size_t invariant) const;

 private:
  struct One {
    springnet_invariant invariant;  // its kind alone, of laws over one
    double reference;
  };
  // Of several invariants: that of an element stretched along its first edge, or with its angles bent by `bend`.
  [[nodiscard]] double value(const One& one, double stretch, double bend) const;

  std::vector<One> all_;
  std::string name_, unit_, element_;
  std::uint32_t shape_ = 0;
  bool bends_ = false;
  double x_at_rest_ = 1.0, x_of_stretch_ = 1.0, from_ = 0.5, to_ = 1.5;
};

}  // namespace springnet::tool
