// Integrators in C++. An integrator is a class
//
//   class Euler : public springnet::sdk::Integrator {
//    public:
//     static constexpr const char* id = "euler";
//     static constexpr const char* summary = "explicit Euler steps";
//     static constexpr Parameter parameters[] = {integer("substeps", "steps within a step").preset(1).at_least(1)};
//     Euler(Host host, Options options);
//     springnet_status advance(double until, springnet_step_report& report);
//   };
//   SPRINGNET_PLUGIN("org.example.euler", "1.0.0", "author", "MIT", Euler);
//
// advance() takes the network from the committed state to a committed state at `until` (s) and returns SPRINGNET_OK, or
// SPRINGNET_UNSETTLED with a report and nothing committed. Constructor and advance() may throw: Failure keeps its
// status, any other exception becomes SPRINGNET_FAILED; what() becomes the host's message. The destructor must not.
//
// A class that has
//
//     void limits(const springnet::sdk::LimitSink& sink);
//
// reports the largest time steps at the committed state, for `springnet inspect` (limits.hpp). Like advance(), it may
// throw. One that integrates the internal state of laws (springnet_internal) declares
//
//     static constexpr bool integrates_states = true;
//
// and is refused where there is any if it does not.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include <springnet/sdk/component.hpp>
#include <springnet/sdk/host.hpp>
#include <springnet/sdk/limits.hpp>
#include <springnet/sdk/message.hpp>

namespace springnet::sdk {

// Values of an integrator's parameters, by name: options["max_step"].
class Options {
 public:
  Options(std::span<const Parameter> parameters, const double* values) noexcept
      : parameters_(parameters), values_(values) {}

  // Throws std::logic_error for a name that the class did not declare.
  [[nodiscard]] double operator[](std::string_view name) const {
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
      if (name == parameters_[i].name) return values_[i];
    }
    throw std::logic_error("the integrator reads an option that it does not declare: " + std::string(name));
  }
  [[nodiscard]] bool boolean(std::string_view name) const { return (*this)[name] != 0.0; }
  // For SPRINGNET_INTEGER; the host has checked that the value is whole and in its bounds.
  template <class Integer = std::int64_t>
  [[nodiscard]] Integer integer(std::string_view name) const {
    return static_cast<Integer>((*this)[name]);
  }
  // For SPRINGNET_CHOICE: an enumeration whose values 0, 1, … are in the order of the declared names.
  template <class Enumeration>
  [[nodiscard]] Enumeration choice(std::string_view name) const {
    return static_cast<Enumeration>(integer<int>(name));
  }

 private:
  std::span<const Parameter> parameters_;
  const double* values_;
};

template <class Component>
struct IntegratorGlue {
  static constexpr bool integrates_states = [] {
    if constexpr (requires { Component::integrates_states; }) return Component::integrates_states;
    return false;
  }();
  static constexpr std::uint64_t capabilities = integrates_states ? SPRINGNET_INTEGRATES_STATES : UINT64_C(0);
  static constexpr std::uint64_t needs = 0;
  // It may call all that this SDK declares.
  static constexpr std::uint32_t needs_minor = SPRINGNET_ABI_MINOR;

  static springnet_status create(void*, springnet_integrator_creation* creation) noexcept {
    creation->integrator = nullptr;
    const springnet_host* const host = creation->host;
    return guarded(host, [&] {
      if (host->struct_size < SPRINGNET_SIZE_TO(springnet_host, deadline))
        throw Failure("the host's table of functions is smaller than that of ABI 2.0; update the host");
      if (creation->option_count != parameters_of<Component>().size())
        throw Failure("the host gave another number of options than the integrator declares");
      auto made = std::make_unique<Instance>(host, creation->options);
      creation->integrator = made.release();
      return springnet_status{SPRINGNET_OK};
    });
  }
  static springnet_status destroy(void* integrator) noexcept {
    delete static_cast<Instance*>(integrator);
    return SPRINGNET_OK;
  }
  static springnet_status advance(void* integrator, const springnet_advance* advance) noexcept {
    auto& instance = *static_cast<Instance*>(integrator);
    springnet_step_report* const report = advance->report;
    // The host's report may be smaller or larger than this one: exchange only the common part.
    auto full = sized<springnet_step_report>();
    const std::size_t shared = std::min<std::size_t>(report->struct_size, sizeof full);
    const std::uint32_t size_of_host = report->struct_size;
    std::memcpy(&full, report, shared);
    full.struct_size = sizeof full;
    const springnet_status status =
        guarded(instance.host, [&]() -> springnet_status { return instance.component.advance(advance->until, full); });
    std::memcpy(report, &full, shared);
    report->struct_size = size_of_host;
    return status;
  }
  static springnet_status limits(void* integrator, const springnet_limits* limits) noexcept {
    auto& instance = *static_cast<Instance*>(integrator);
    return guarded(instance.host, [&]() -> springnet_status {
      if constexpr (has_limits) instance.component.limits(LimitSink(*limits));
      return SPRINGNET_OK;
    });
  }
  static constexpr bool has_limits = requires(Component & component, const LimitSink& sink) { component.limits(sink); };
  static springnet_status forget(void* integrator) noexcept {
    auto& instance = *static_cast<Instance*>(integrator);
    return guarded(instance.host, [&]() -> springnet_status {
      if constexpr (has_forget) instance.component.forget();
      return SPRINGNET_OK;
    });
  }
  static constexpr bool has_forget = requires(Component & component) { component.forget(); };
  static constexpr springnet_integrator implementation{
      sizeof(springnet_integrator),  0, nullptr, &create, &destroy, &advance, has_limits ? &limits : nullptr,
      has_forget ? &forget : nullptr};

 private:
  struct Instance {
    Instance(const springnet_host* table, const double* options)
        : host(table), component(Host(*table), Options(parameters_of<Component>(), options)) {}
    const springnet_host* host;
    Component component;
  };

  static springnet_status fail(const springnet_host* host, const char* why, springnet_status status) noexcept {
    detail::write_message(SPRINGNET_HAS_FIELD(springnet_host, host, message) ? host->message : nullptr, why);
    return status;
  }
  template <class Body>
  static springnet_status guarded(const springnet_host* host, const Body& body) noexcept {
    try {
      return body();
    } catch (const Failure& error) {
      return fail(host, error.what(), error.status());
    } catch (const std::exception& error) {
      return fail(host, error.what(), SPRINGNET_FAILED);
    } catch (...) {
      return fail(host, "the integrator threw something that is not a std::exception", SPRINGNET_FAILED);
    }
  }
};

// Base of integrators; see the top of this file.
struct Integrator {
  static constexpr std::uint32_t kind = SPRINGNET_INTEGRATOR;
  template <class Component>
  using Glue = IntegratorGlue<Component>;
};

}  // namespace springnet::sdk
