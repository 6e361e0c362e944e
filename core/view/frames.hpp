// The records of a run, thinned if there are more than fit.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "text/archive.hpp"

namespace springnet::view {

// Rows of equal width, one per frame.
template <class Number>
class Rows {
 public:
  Rows(std::size_t width, std::size_t expected) : width_(width) { numbers_.reserve(width * expected); }

  void append() { numbers_.resize(numbers_.size() + width_); }
  [[nodiscard]] std::span<Number> last() { return std::span(numbers_).last(width_); }
  [[nodiscard]] std::span<Number> row(std::size_t frame) { return std::span(numbers_).subspan(frame * width_, width_); }
  void pop() { numbers_.resize(numbers_.size() - width_); }
  void copy(std::size_t from, std::size_t to) {
    if (from != to) std::copy_n(numbers_.begin() + at(from), width_, numbers_.begin() + at(to));
  }
  void shrink(std::size_t frames) { numbers_.resize(frames * width_); }
  void archive(Archive& archive, std::size_t frames) {
    if (archive.reads() && frames * width_ > archive.left() / sizeof(Number)) Archive::refuse("frames end too early");
    shrink(frames);
    archive.numbers(numbers_.data(), numbers_.size());
  }
  [[nodiscard]] const std::vector<Number>& numbers() const noexcept { return numbers_; }

 private:
  [[nodiscard]] std::ptrdiff_t at(std::size_t frame) const { return static_cast<std::ptrdiff_t>(frame * width_); }
  std::size_t width_;
  std::vector<Number> numbers_;
};

constexpr std::size_t surface_numbers = 7;  // per surface and frame
constexpr std::size_t touch_numbers = 7;    // per touch of bodies and frame, see take_touches()

struct FrameWidths {
  std::size_t scalars, nodes, springs, surfaces;
  std::size_t loads = 0, arrows = 0, states = 0;
  std::size_t start_nodes = 0;
  std::size_t touches = 0;
};

// Records 0, stride, 2 stride, … and the last one; at most `capacity` frames (2 or more), then the stride doubles.
class Frames {
 public:
  Frames(const FrameWidths& widths, std::size_t capacity, std::size_t expected);

  void archive(Archive& archive);

  // Makes room for the next record: the last row of each of the members below.
  void begin();

  Rows<double> scalars;
  Rows<float> positions;        // x, y, z of each node, m
  Rows<float> start_positions;  // of the motion before learning, m; empty without one
  Rows<float> speeds;           // of each node, m/s
  Rows<float> tensions;         // of each spring, N
  Rows<float> surfaces;        // of each surface: x, y, z, m; the quaternion x, y, z, w of its rotation since the start
  Rows<float> resultants;      // x, y, z of each load, N
  Rows<float> forces;          // x, y, z of each arrow at a node, N
  Rows<float> touches;         // touch_numbers of each touch of bodies
  Rows<float> states;          // internal states, spring by spring (States)
  Rows<std::uint8_t> contact;  // a bit per node

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] std::uint64_t stride() const noexcept { return stride_; }
  [[nodiscard]] std::uint64_t recorded() const noexcept { return recorded_; }

 private:
  template <class Work>
  void each(const Work& work) {
    work(scalars);
    work(positions);
    work(start_positions);
    work(speeds);
    work(tensions);
    work(surfaces);
    work(resultants);
    work(forces);
    work(touches);
    work(states);
    work(contact);
  }
  void halve();

  std::size_t capacity_;
  std::size_t count_ = 0;
  std::uint64_t stride_ = 1;
  std::uint64_t recorded_ = 0;  // dropped records included
};

}  // namespace springnet::view
