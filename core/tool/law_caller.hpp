// Calls of a law by its plugin ABI, for curves: at many values at once, or along a course of its internal states.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>

namespace springnet::tool {

using Numbers = std::vector<double>;

// What a law is called with. Values by index, as the law declares them.
struct LawSetting {
  const Component* component = nullptr;
  Numbers parameters, inputs;
  std::vector<Numbers> tables;
  std::vector<Numbers> references;  // [invariant] of one number: the reference value
};

// Answers to `count` members; empty where the law does not give them, nan where it fails.
struct LawCurves {
  std::vector<Numbers> forces;  // [invariant]
  Numbers by_value, by_rate;    // of one invariant
  Numbers energy, margin;
};

class LawCaller {
 public:
  // Prepares the tables. Throws Error(input) if the law refuses them.
  explicit LawCaller(LawSetting setting);
  ~LawCaller();
  LawCaller(const LawCaller&) = delete;
  LawCaller& operator=(const LawCaller&) = delete;

  [[nodiscard]] const springnet_law& law() const { return component().law(); }
  [[nodiscard]] const Component& component() const { return *setting_.component; }
  [[nodiscard]] const LawSetting& setting() const { return setting_; }
  [[nodiscard]] bool can(std::uint64_t capability) const {
    return (component().description->capabilities & capability) != 0;
  }
  [[nodiscard]] std::size_t invariant_count() const;
  [[nodiscard]] double reference(std::size_t invariant = 0) const { return setting_.references[invariant][0]; }

  // [invariant][member]. Internal states are those with which the law starts at the reference values.
  [[nodiscard]] LawCurves evaluate(const std::vector<Numbers>& values, const std::vector<Numbers>& rates);

  // Why the law failed, the last time it did; else empty.
  [[nodiscard]] const std::string& failure() const { return failure_; }

  // Of a law over one invariant: the states with which it starts there.
  [[nodiscard]] Numbers start(double value, double rate);
  // A step of its states, and the force and the margin at its end (1 of laws without). False if the law fails.
  struct End {
    double value, rate;
  };
  [[nodiscard]] bool step(double time, double time_step, const End& from, const End& to, Numbers& states, double& force,
                          double& margin);

 private:
  template <class Function>
  bool call(const Function& function);

  LawSetting setting_;
  void* prepared_ = nullptr;
  std::string failure_;
};

}  // namespace springnet::tool
