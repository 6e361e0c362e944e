#include "check/points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace springnet::check {
namespace {

constexpr double smallest_checked = 1e-6, largest_checked = 2.0;  // stretches where the law declares no bound
constexpr double widest = 1e300;                                  // larger bounds are none

bool is_open(const springnet_parameter& p) { return (p.flags & SPRINGNET_EXCLUDES_SMALLEST) != 0; }
double step_of(const springnet_parameter& p) { return p.scale > 0.0 && p.scale < widest ? p.scale : 1.0; }

// Within the bounds, off them by a share of the scale or of the interval, whichever is smaller.
double inside(const springnet_parameter& p, double value, double share) {
  const double low = std::max(p.smallest, -widest), high = std::min(p.largest, widest);
  const double off = share * std::min(step_of(p), high - low);
  return high - low > 2.0 * off ? std::clamp(value, low + off, high - off) : 0.5 * (low + high);
}

constexpr std::array<double, 3> no_direction{}, some_direction{0.6, 0.64, 0.48};

double shortest_edge(const Corners& corners) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < corners.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      shortest = std::min(shortest, std::hypot(corners[a][0] - corners[b][0], corners[a][1] - corners[b][1],
                                               corners[a][2] - corners[b][2]));
  return shortest;
}

bool is_scaled(std::uint32_t invariant) {
  return invariant == SPRINGNET_LENGTH || invariant == SPRINGNET_AREA || invariant == SPRINGNET_VOLUME ||
         invariant == SPRINGNET_ENCLOSED_VOLUME;
}

}  // namespace

std::vector<double> typical_parameters(const springnet_component& component) {
  std::vector<double> values;
  for (std::uint32_t i = 0; i < component.parameter_count; ++i) {
    const springnet_parameter& p = *component.parameters[i];
    const bool required = (p.flags & SPRINGNET_REQUIRED) != 0;
    double value = required ? p.scale : p.default_value;
    if (required && p.type == SPRINGNET_NUMBER) value = inside(p, value, 0.2);
    if (required && p.type != SPRINGNET_NUMBER) value = std::clamp(std::round(value), p.smallest, p.largest);
    values.push_back(value);
  }
  return values;
}

Points::Points(const LawCall& call, std::vector<double> typical, const SceneLaw* scene, bool fixed, std::uint64_t seed)
    : call_(call),
      typical_(std::move(typical)),
      scene_(scene != nullptr && !scene->elements.empty() ? scene : nullptr),
      fixed_(fixed),
      random_(seed),
      lowest_(std::max(call.law().smallest_stretch, smallest_checked)),
      highest_(std::max(lowest_, std::min(call.law().largest_stretch, largest_checked))) {}

void Points::set_states_at_start(Point& point) const {
  const sdk::JacobianLayout& l = call_.layout();
  const std::vector<double> states = call_.start_states(point, Memory::Layout::roomy);
  std::copy(states.begin(), states.end(), point.begin() + static_cast<std::ptrdiff_t>(l.state(0)));
}

const UsedElement* Points::any_used() {
  if (scene_ == nullptr) return nullptr;
  return &scene_->elements[std::uniform_int_distribution<std::size_t>(0, scene_->elements.size() - 1)(random_)];
}

void Points::put_parameters(Point& point, const UsedElement* used) const {
  const std::vector<double>& values = used != nullptr ? scene_->parameters[used->parameters] : typical_;
  std::copy(values.begin(), values.end(), point.begin() + static_cast<std::ptrdiff_t>(call_.layout().parameter(0)));
}

Point Points::at_rest(std::size_t size, Placed* placed) const {
  constexpr std::array<double, sizes> lengths{1.0, 0.37, 1e-6};  // m; the last: elements of cells
  const UsedElement* const used = scene_ == nullptr ? nullptr : &scene_->elements.at(size);
  const sdk::JacobianLayout& l = call_.layout();
  Point point(l.columns(true), 0.0);
  put_parameters(point, used);
  for (std::size_t i = 0; i < l.inputs; ++i)
    point[l.input(i)] = point[l.start_input(i)] = call_.law().inputs[i]->default_value;
  if (call_.several()) {
    Corners corners = used != nullptr ? used->rest : corners_of(call_.law().shape);
    for (auto& corner : corners)
      for (double& x : corner) x *= used != nullptr ? 1.0 : lengths.at(size);
    const std::vector<double> scalars = scalars_of(call_.law(), corners);
    for (std::size_t i = 0; i < l.invariants; ++i)
      point[l.reference(i)] = point[l.value(i)] = point[l.start_value(i)] = scalars[i];
    const std::array<double, 3> direction =
        direction_of(corners, used != nullptr && used->direction != no_direction ? used->direction : some_direction);
    std::copy(direction.begin(), direction.end(), point.begin() + static_cast<std::ptrdiff_t>(l.direction(0)));
    if (placed != nullptr) *placed = {corners, corners};
  } else {
    const double unused = is_scaled(call_.law().invariant) ? lengths.at(size) : 1.0;
    point[l.reference()] = used != nullptr ? used->reference : unused;
    stretch(point, std::clamp(1.0, lowest_, highest_));
    if (call_.law().invariant == SPRINGNET_RELATIVE_SPEED) point[l.value()] = 0.0;
  }
  set_states_at_start(point);
  return point;
}

void Points::stretch(Point& point, double stretch) const {
  const sdk::JacobianLayout& l = call_.layout();
  point[l.value()] = stretch * point[l.reference()];
  // Angles between edges go up to pi.
  if (call_.law().invariant == SPRINGNET_ANGLE) point[l.value()] = std::min(point[l.value()], std::numbers::pi);
  point[l.start_value()] = point[l.value()];
}

double Points::draw(const springnet_parameter& p, double typical, double factor) {
  switch (p.type) {
    case SPRINGNET_BOOLEAN:
      return uniform(0.0, 1.0) < 0.5 ? 0.0 : 1.0;
    case SPRINGNET_CHOICE:
      return std::floor(uniform(0.0, static_cast<double>(p.choice_count)));
    case SPRINGNET_INTEGER:
      return std::clamp(typical + std::floor(uniform(0.0, 3.0)), p.smallest, p.largest);
    default:
      break;
  }
  const double value =
      typical == 0.0 ? step_of(p) * uniform(-1.0, 1.0) : typical * std::pow(factor, uniform(-1.0, 1.0));
  return inside(p, value, 0.05);
}

// Corners moved by up to a fifth, with velocities of up to that a second.
void Points::draw_geometry(Point& point, const UsedElement* used) {
  const sdk::JacobianLayout& l = call_.layout();
  const springnet_law& law = call_.law();
  const auto moved = [&](Corners corners, double by) {
    for (auto& corner : corners)
      for (double& x : corner) x += by * uniform(-1.0, 1.0);
    return corners;
  };
  double size = std::pow(3.0, uniform(-1.0, 1.0));
  Corners rest = used != nullptr ? used->rest : moved(corners_of(law.shape), 0.1);
  if (used != nullptr) size = shortest_edge(rest);
  for (auto& corner : rest)
    for (double& x : corner) x *= used != nullptr ? 1.0 : size;
  const Corners now = moved(rest, 0.2 * size);
  const std::vector<double> at_rest = scalars_of(law, rest), at_present = scalars_of(law, now);
  const std::vector<std::vector<double>> gradients = gradients_of(law, now);
  std::vector<double> velocities;
  for (std::size_t k = 0; k < 3 * now.size(); ++k) velocities.push_back(size * uniform(-1.0, 1.0));
  for (std::size_t i = 0; i < l.invariants; ++i) {
    point[l.reference(i)] = at_rest[i];
    point[l.value(i)] = at_present[i];
    double rate = 0.0;
    for (std::size_t k = 0; k < velocities.size(); ++k) rate += gradients[i][k] * velocities[k];
    point[l.rate(i)] = rate;
  }
  const std::array<double, 3> direction =
      used != nullptr && used->direction != no_direction
          ? direction_of(rest, used->direction)
          : direction_of(rest, {uniform(0.2, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0)});
  std::copy(direction.begin(), direction.end(), point.begin() + static_cast<std::ptrdiff_t>(l.direction(0)));
}

Point Points::any() {
  const sdk::JacobianLayout& l = call_.layout();
  const springnet_law& law = call_.law();
  Point point(l.columns(true), 0.0);
  const UsedElement* const used = any_used();
  if (call_.several()) {
    draw_geometry(point, used);
  } else {
    const double spread = 0.1 * (highest_ - lowest_);
    const double drawn = is_scaled(law.invariant) ? std::pow(3.0, uniform(-1.0, 1.0)) : uniform(0.7, 1.3);
    point[l.reference()] = used != nullptr ? used->reference : drawn;
    stretch(point, std::clamp(uniform(0.4, 1.8), lowest_ + spread, highest_ - spread));
    if (law.invariant == SPRINGNET_RELATIVE_SPEED) point[l.value()] = uniform(0.1, 2.0);
    point[l.rate()] = point[l.reference()] * uniform(-1.0, 1.0);
  }
  put_parameters(point, used);
  for (std::size_t i = 0; i < l.parameters && used == nullptr && !fixed_; ++i)
    point[l.parameter(i)] = draw(*call_.component().description->parameters[i], typical_[i], 3.0);
  set_states_at_start(point);
  for (std::size_t i = 0; i < l.states; ++i) {
    const springnet_parameter& p = *law.states[i];
    double& state = point[l.state(i)];
    state = inside(p, state + 2.0 * step_of(p) * uniform(-1.0, 1.0), 0.05);
  }
  for (std::size_t i = 0; i < l.inputs; ++i) {
    const springnet_parameter& p = *law.inputs[i];
    point[l.input(i)] = inside(p, p.default_value + 2.0 * step_of(p) * uniform(-1.0, 1.0), 0.05);
  }
  point[l.time()] = uniform(0.0, 2.0);
  draw_start(point);
  return point;
}

std::vector<Point> Points::several(std::size_t count) {
  std::vector<Point> points;
  for (std::size_t k = 0; k < count; ++k) points.push_back(any());
  return points;
}

void Points::draw_start(Point& point) {
  const sdk::JacobianLayout& l = call_.layout();
  for (std::size_t i = 0; i < l.invariants; ++i) {
    point[l.start_value(i)] = point[l.value(i)] * uniform(0.97, 1.03);
    point[l.start_rate(i)] = point[l.rate(i)] * uniform(0.9, 1.1);
  }
  for (std::size_t i = 0; i < l.inputs; ++i)
    point[l.start_input(i)] = inside(*call_.law().inputs[i], point[l.input(i)] * uniform(0.9, 1.1), 0.05);
}

std::vector<Point> Points::edges(const Point& point) const {
  const sdk::JacobianLayout& l = call_.layout();
  std::vector<Point> result;
  const auto add = [&](const springnet_parameter& p, std::size_t column) {
    const auto put = [&](double value) {
      result.push_back(point);
      result.back()[column] = value;
    };
    if (p.smallest > -widest) put(is_open(p) ? std::min(p.smallest + 0.05 * step_of(p), p.largest) : p.smallest);
    if (p.largest < widest) put(p.largest);
  };
  for (std::size_t i = 0; i < l.parameters && !fixed_; ++i)
    add(*call_.component().description->parameters[i], l.parameter(i));
  for (std::size_t i = 0; i < l.states; ++i) add(*call_.law().states[i], l.state(i));
  for (std::size_t i = 0; i < l.inputs; ++i) add(*call_.law().inputs[i], l.input(i));
  return result;
}

double Points::magnitude(std::size_t column, const Point& point) const {
  const sdk::JacobianLayout& l = call_.layout();
  const double own = std::abs(point[column]);
  if (own > 0.0) return own;
  if (column < l.parameter(0)) return std::max(std::abs(point[l.reference(column % l.invariants)]), 1e-3);
  if (column >= l.start_value() && column < l.start_input(0))
    return std::max(std::abs(point[l.reference((column - l.start_value()) % l.invariants)]), 1e-3);
  if (column >= l.state(0) && column < l.input(0)) return step_of(*call_.law().states[column - l.state(0)]);
  if (column < l.state(0)) return step_of(*call_.component().description->parameters[column - l.parameter(0)]);
  return 1.0;
}

}  // namespace springnet::check
