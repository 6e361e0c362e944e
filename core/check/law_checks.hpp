// The checks of a law. Each runs in a child process of its own, and returns what it found.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "check/law_call.hpp"
#include "check/points.hpp"
#include "check/report.hpp"

namespace springnet::check {

// A law, and what its checks need.
struct LawSubject {
  std::shared_ptr<const Component> component;
  std::shared_ptr<const PluginHost> host;  // of integrators, and of the law `linear`
  const SceneLaw* scene = nullptr;         // as it is used in a scene; null: none
  std::uint64_t seed = 1;
};

[[nodiscard]] Outcome check_call(const LawSubject& subject);
[[nodiscard]] Outcome check_arrays(const LawSubject& subject);
[[nodiscard]] Outcome check_finite(const LawSubject& subject);
[[nodiscard]] Outcome check_rest(const LawSubject& subject);
[[nodiscard]] Outcome check_energy(const LawSubject& subject);
[[nodiscard]] Outcome check_derivatives(const LawSubject& subject);
[[nodiscard]] Outcome check_dissipation(const LawSubject& subject);
[[nodiscard]] Outcome check_batches(const LawSubject& subject);
[[nodiscard]] Outcome check_states(const LawSubject& subject);
[[nodiscard]] Outcome check_promises(const LawSubject& subject);
[[nodiscard]] Outcome check_order(const LawSubject& subject);
[[nodiscard]] Outcome check_leaks(const LawSubject& subject);
[[nodiscard]] Outcome check_speed(const LawSubject& subject);

// A law ready to be called: tables prepared, typical parameters known. Throws std::runtime_error if the law needs
// tables that cannot be guessed.
class ReadyLaw {
 public:
  explicit ReadyLaw(const LawSubject& subject);
  [[nodiscard]] const LawCall& call() const noexcept { return *call_; }
  [[nodiscard]] Points& points() noexcept { return *points_; }
  [[nodiscard]] const std::vector<double>& parameters() const noexcept { return parameters_; }
  [[nodiscard]] const TableValues& tables() const noexcept { return tables_; }

 private:
  std::vector<double> parameters_;
  TableValues tables_;
  std::unique_ptr<PreparedTable> prepared_;
  std::unique_ptr<LawCall> call_;
  std::unique_ptr<Points> points_;
};

// Whether the law is a formula, whose author writes into a scene or a LawFormula what others declare in C++ or C.
[[nodiscard]] bool is_formula(const Component& component);
// "declare SPRINGNET_ADDS_POWER"; of a formula: "write declares = ["adds power"]".
[[nodiscard]] std::string declaring(const Component& component, const char* constant, const char* word);

// "at q 1.2, reference 1, parameters 3; 0.5": an element in a report.
[[nodiscard]] std::string place(const LawCall& call, const Point& point);

}  // namespace springnet::check
