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
// and is refused where there is any if it does not. In the same way one that keeps bodies apart from each other
// declares keeps_bodies_apart, and keeps_rigid_bodies_apart if their nodes may have rigid connections;
// springnet_host::constrain does the work in a step of velocity Verlet. More that it may declare, for
// `plugin show`: locates_events, chooses_steps; without_contact and without_rigid, where the host then refuses such
// networks. And more members, each optional:
//
//     void forget();                                       // drops what it keeps from one advance() to the next
//     void save(const ByteSink& sink) const;               // writes it
//     void restore(std::span<const std::byte> bytes);      // takes it up again
//     void interpolate(double time, const springnet_vectors& position, const springnet_vectors& velocity);
//
// The last one writes the state at a time within the last committed step, and throws Failure where it cannot. One that
// differentiates the motion while it goes on (springnet_sensitivities) has both of
//
//     void begin_sensitivities(std::span<const springnet_sensitivity* const> columns);
//     void sensitivity(std::uint32_t column, double* position, double* velocity) const;
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
#include <type_traits>

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

// Where save() writes: numbers and arrays of them, as they are in memory.
class ByteSink {
 public:
  explicit ByteSink(const springnet_byte_sink& sink) noexcept : sink_(&sink) {}
  void write(const void* bytes, std::size_t count) const {
    if (sink_->write(sink_->context, bytes, count) != SPRINGNET_OK)
      throw Failure("the host could not take the integrator's memory");
  }
  template <class Number>
  void put(const Number& number) const {
    static_assert(std::is_trivially_copyable_v<Number>);
    write(&number, sizeof number);
  }
  template <class Number>
  void put_all(std::span<const Number> numbers) const {
    write(numbers.data(), numbers.size_bytes());
  }

 private:
  const springnet_byte_sink* sink_;
};

// Reads what a ByteSink wrote, in the same order. Throws Failure at the end of the bytes.
class ByteSource {
 public:
  explicit ByteSource(std::span<const std::byte> bytes) noexcept : left_(bytes) {}
  void read(void* to, std::size_t count) {
    if (count > left_.size()) throw Failure("the integrator's memory is too short");
    if (count > 0) std::memcpy(to, left_.data(), count);
    left_ = left_.subspan(count);
  }
  template <class Number>
  void get(Number& number) {
    static_assert(std::is_trivially_copyable_v<Number>);
    read(&number, sizeof number);
  }
  template <class Number>
  void get_all(std::span<Number> numbers) {
    read(numbers.data(), numbers.size_bytes());
  }
  [[nodiscard]] bool is_empty() const noexcept { return left_.empty(); }

 private:
  std::span<const std::byte> left_;
};

template <class Component>
struct IntegratorGlue {
  static constexpr bool integrates_states = [] {
    if constexpr (requires { Component::integrates_states; }) return Component::integrates_states;
    return false;
  }();
  static constexpr bool has_interpolate = requires(Component & component, const springnet_vectors& vectors) {
    component.interpolate(0.0, vectors, vectors);
  };
  static constexpr std::uint64_t capabilities = [] {
    std::uint64_t bits = integrates_states ? SPRINGNET_INTEGRATES_STATES : UINT64_C(0);
    if constexpr (requires { Component::locates_events; })
      if (Component::locates_events) bits |= SPRINGNET_LOCATES_EVENTS;
    if constexpr (requires { Component::chooses_steps; })
      if (Component::chooses_steps) bits |= SPRINGNET_CHOOSES_STEPS;
    if constexpr (requires { Component::keeps_bodies_apart; })
      if (Component::keeps_bodies_apart) bits |= SPRINGNET_KEEPS_BODIES_APART;
    if constexpr (requires { Component::keeps_rigid_bodies_apart; })
      if (Component::keeps_rigid_bodies_apart) bits |= SPRINGNET_KEEPS_RIGID_BODIES_APART;
    if constexpr (requires { Component::without_contact; })
      if (Component::without_contact) bits |= SPRINGNET_WITHOUT_CONTACT;
    if constexpr (requires { Component::without_rigid; })
      if (Component::without_rigid) bits |= SPRINGNET_WITHOUT_RIGID;
    return has_interpolate ? bits | SPRINGNET_HAS_DENSE_OUTPUT : bits;
  }();
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
  static springnet_status save(void* integrator, const springnet_byte_sink* sink) noexcept {
    auto& instance = *static_cast<Instance*>(integrator);
    return guarded(instance.host, [&]() -> springnet_status {
      if constexpr (has_save) instance.component.save(ByteSink(*sink));
      return SPRINGNET_OK;
    });
  }
  static constexpr bool has_save = requires(const Component& component, const ByteSink& sink) { component.save(sink); };
  static springnet_status restore(void* integrator, const springnet_bytes* bytes) noexcept {
    auto& instance = *static_cast<Instance*>(integrator);
    return guarded(instance.host, [&]() -> springnet_status {
      if constexpr (has_restore) {
        instance.component.restore(std::span(static_cast<const std::byte*>(bytes->bytes), bytes->count));
      }
      return SPRINGNET_OK;
    });
  }
  static constexpr bool has_restore = requires(Component & component, std::span<const std::byte> bytes) {
    component.restore(bytes);
  };
  static_assert(has_save == has_restore, "an integrator has both save and restore, or neither");
  static springnet_status interpolate(void* integrator, const springnet_dense_output* output) noexcept {
    auto& instance = *static_cast<Instance*>(integrator);
    return guarded(instance.host, [&]() -> springnet_status {
      if constexpr (has_interpolate) instance.component.interpolate(output->time, output->position, output->velocity);
      return SPRINGNET_OK;
    });
  }
  static springnet_status begin_sensitivities(void* integrator, const springnet_sensitivities* sensitivities) noexcept {
    auto& instance = *static_cast<Instance*>(integrator);
    return guarded(instance.host, [&]() -> springnet_status {
      if constexpr (has_sensitivities)
        instance.component.begin_sensitivities(std::span(sensitivities->columns, sensitivities->count));
      return SPRINGNET_OK;
    });
  }
  static springnet_status sensitivity(void* integrator, const springnet_sensitivity_values* values) noexcept {
    auto& instance = *static_cast<Instance*>(integrator);
    return guarded(instance.host, [&]() -> springnet_status {
      if constexpr (has_sensitivities)
        instance.component.sensitivity(values->column, values->position, values->velocity);
      return SPRINGNET_OK;
    });
  }
  static constexpr bool has_sensitivities =
      requires(Component & component, std::span<const springnet_sensitivity* const> columns, double* out) {
    component.begin_sensitivities(columns);
    component.sensitivity(std::uint32_t{0}, out, out);
  };
  static constexpr springnet_integrator implementation{sizeof(springnet_integrator),
                                                       0,
                                                       nullptr,
                                                       &create,
                                                       &destroy,
                                                       &advance,
                                                       has_limits ? &limits : nullptr,
                                                       has_forget ? &forget : nullptr,
                                                       has_save ? &save : nullptr,
                                                       has_restore ? &restore : nullptr,
                                                       has_interpolate ? &interpolate : nullptr,
                                                       has_sensitivities ? &begin_sensitivities : nullptr,
                                                       has_sensitivities ? &sensitivity : nullptr};

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
