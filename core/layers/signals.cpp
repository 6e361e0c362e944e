#include "layers/signals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace springnet::layers {

Signals::Signals(const std::vector<Input>& inputs) {
  for (const Input& input : inputs) {
    courses_.emplace_back(input.signal);
    if (!courses_.back().is_constant()) varying_.push_back(static_cast<std::uint32_t>(courses_.size() - 1));
    sampled_.push_back(courses_.back().at(0.0));
  }
  at_start_ = at_end_ = sampled_;
}

std::uint32_t Signals::add_constant(double value) {
  Signal constant;
  constant.mean = value;
  courses_.emplace_back(constant);
  sampled_.push_back(value);
  at_start_.push_back(value);
  at_end_.push_back(value);
  return static_cast<std::uint32_t>(courses_.size() - 1);
}

void Signals::set_constant(std::uint32_t signal, double value) {
  Signal constant;
  constant.mean = value;
  courses_[signal] = SignalCourse(constant);
  sampled_[signal] = at_start_[signal] = at_end_[signal] = value;
}

void Signals::drop_constants_from(std::size_t count) {
  courses_.erase(courses_.begin() + static_cast<std::ptrdiff_t>(count), courses_.end());
  for (std::vector<double>* const values : {&sampled_, &at_start_, &at_end_}) values->resize(count);
}

void Signals::sample_all(double time, std::vector<double>& values) const {
  for (const std::uint32_t each : varying_) values[each] = value(each, time);
}

bool Signals::set_interval(double from, double until, double time_step) {
  if (varying_.empty()) return false;
  const bool step = std::isfinite(until) && until > from;
  from_ = from;
  until_ = step ? until : std::numeric_limits<double>::infinity();
  const double latest = step ? std::max(std::abs(from), std::abs(until)) : std::abs(from);
  slack_ = std::max(4.0 * std::numeric_limits<double>::epsilon() * latest,
                    step ? 1e-9 * std::min(until - from, time_step) : 0.0);
  sample_all(from, at_start_);
  bool jumps = false;
  for (const std::uint32_t each : varying_) {
    if (!courses_[each].jumps()) continue;
    jumps = jumps || at_start_[each] != at_end_[each];
    at_end_[each] = step ? value(each, until) : at_start_[each];
  }
  sampled_time_ = from;
  sampled_ = at_start_;
  return jumps;
}

double Signals::value(std::uint32_t signal, double time) const {
  return courses_[signal].at(courses_[signal].jumps() ? one_sided(time) : time);
}

double Signals::one_sided(double time) const noexcept {
  if (std::abs(time - from_) <= slack_) return from_ + slack_;
  return std::abs(time - until_) <= slack_ ? until_ - slack_ : time;
}

void Signals::sample(double time) {
  if (varying_.empty() || time == sampled_time_) return;
  sample_all(time, sampled_);
  sampled_time_ = time;
}

void Signals::hold(std::uint32_t signal, double value) {
  Signal constant;
  constant.mean = value;
  replaced_.try_emplace(signal, courses_[signal]);
  courses_[signal] = SignalCourse(constant);
  varying_.erase(std::remove(varying_.begin(), varying_.end(), signal), varying_.end());
  sampled_[signal] = at_start_[signal] = at_end_[signal] = value;
}

void Signals::take_over(const Signals& before, std::size_t inputs, double time) {
  from_ = before.from_;
  until_ = before.until_;
  slack_ = before.slack_;
  for (const std::uint32_t each : varying_) sampled_[each] = at_start_[each] = at_end_[each] = value(each, time);
  for (std::uint32_t k = 0; k < inputs; ++k) {
    if (before.replaced_.contains(k)) hold(k, before.at_start_[k]);
    sampled_[k] = before.sampled_[k];
    at_start_[k] = before.at_start_[k];
    at_end_[k] = before.at_end_[k];
  }
  sampled_time_ = std::numeric_limits<double>::quiet_NaN();  // of the new ones another
}

void Signals::archive(Archive& archive) {
  for (std::uint32_t k = 0; k < courses_.size(); ++k) {
    const auto original = replaced_.find(k);
    bool is_held = original != replaced_.end();
    archive.flag(is_held);
    double value = at_start_[k];
    if (is_held) archive.number(value);
    if (!archive.reads()) continue;
    if (is_held && !std::isfinite(value)) Archive::refuse("the value of an input signal is not finite");
    if (is_held) {
      hold(k, value);
    } else if (original != replaced_.end()) {
      courses_[k] = original->second;
      replaced_.erase(original);
      if (!courses_[k].is_constant()) varying_.insert(std::lower_bound(varying_.begin(), varying_.end(), k), k);
    }
  }
  for (double* each : {&from_, &until_, &slack_, &sampled_time_}) archive.number(*each);
  for (std::vector<double>* each : {&sampled_, &at_start_, &at_end_}) archive.numbers(*each, "input signals");
}

double Signals::at_start(std::uint32_t signal, double time, double time_step) const {
  const double start = time - time_step;
  // The difference of two times is not exactly the third.
  if (std::abs(start - from_) <= 1e-9 * time_step) return at_start_[signal];
  return value(signal, start);
}

double Signals::next_kink(double time) const {
  double next = std::numeric_limits<double>::infinity();
  for (const std::uint32_t each : varying_) next = std::min(next, courses_[each].next_kink(time));
  return next;
}

}  // namespace springnet::layers
