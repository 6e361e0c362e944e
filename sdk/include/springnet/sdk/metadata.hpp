// Metadata of a component, as constants of its class: its parameters (this file), and
//   static constexpr const char* id, summary;          // the name in a scene; one line
//   static constexpr const char* reference;            // literature, optional
//   static constexpr Parameter parameters[] = {…};     // optional; the order is that of p[0], p[1], …
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <span>

#include <springnet/sdk/plugin.h>

namespace springnet::sdk {

// A parameter, built with one of the functions below and refined by its members:
//   number("stiffness", "N/m", "tension per elongation").above(0).learnable(100)
// Without preset() a scene must give it.
struct Parameter {
  static constexpr std::size_t max_choices = 8;

  const char* name = "";
  const char* unit = "1";
  const char* summary = "";
  std::uint32_t type = SPRINGNET_NUMBER;
  std::uint32_t flags = SPRINGNET_REQUIRED;
  double default_value = 0.0;
  double smallest = -std::numeric_limits<double>::infinity();
  double largest = std::numeric_limits<double>::infinity();
  double scale = 1.0;
  std::uint32_t choice_count = 0;
  std::array<const char*, max_choices> choices{};

  // The value if a scene gives none.
  [[nodiscard]] constexpr Parameter preset(double value) const {
    Parameter p = *this;
    p.default_value = value;
    p.flags &= ~std::uint32_t{SPRINGNET_REQUIRED};
    return p;
  }
  [[nodiscard]] constexpr Parameter at_least(double value) const {
    Parameter p = *this;
    p.smallest = value;
    return p;
  }
  [[nodiscard]] constexpr Parameter above(double value) const {
    Parameter p = at_least(value);
    p.flags |= SPRINGNET_EXCLUDES_SMALLEST;
    return p;
  }
  [[nodiscard]] constexpr Parameter at_most(double value) const {
    Parameter p = *this;
    p.largest = value;
    return p;
  }
  // At most the largest number below `value`, which is above 0.
  [[nodiscard]] constexpr Parameter below(double value) const {
    return at_most(std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) - 1));
  }
  // Identification may change it; `typical` is its usual magnitude, above 0.
  [[nodiscard]] constexpr Parameter learnable(double typical = 1.0) const {
    Parameter p = *this;
    p.flags |= SPRINGNET_LEARNABLE;
    p.scale = typical;
    return p;
  }
};

// A number in the SI unit `unit` ("1": dimensionless).
[[nodiscard]] constexpr Parameter number(const char* name, const char* unit, const char* summary) {
  Parameter p;
  p.name = name;
  p.unit = unit;
  p.summary = summary;
  return p;
}

[[nodiscard]] constexpr Parameter integer(const char* name, const char* summary) {
  Parameter p = number(name, "1", summary);
  p.type = SPRINGNET_INTEGER;
  return p;
}

// false unless preset(1).
[[nodiscard]] constexpr Parameter boolean(const char* name, const char* summary) {
  Parameter p = number(name, "1", summary).preset(0).at_least(0).at_most(1);
  p.type = SPRINGNET_BOOLEAN;
  return p;
}

// One of up to eight names; the value is the index of the name. The first one unless preset(index).
[[nodiscard]] constexpr Parameter choice(const char* name, std::initializer_list<const char*> names,
                                         const char* summary) {
  Parameter p = number(name, "1", summary).preset(0).at_least(0).at_most(static_cast<double>(names.size()) - 1);
  p.type = SPRINGNET_CHOICE;
  for (const char* each : names) p.choices.at(p.choice_count++) = each;
  return p;
}

// Parameters of a component class; none if it declares none.
template <class Component>
[[nodiscard]] constexpr std::span<const Parameter> parameters_of() {
  if constexpr (requires { Component::parameters; }) return Component::parameters;
  return {};
}

// The C struct of a parameter; it refers to the texts and choices of `p`.
[[nodiscard]] constexpr springnet_parameter to_abi(const Parameter& p) {
  return {sizeof(springnet_parameter),
          p.type,
          p.name,
          p.unit,
          p.summary,
          p.default_value,
          p.smallest,
          p.largest,
          p.scale,
          p.flags,
          p.choice_count,
          p.choice_count == 0 ? nullptr : p.choices.data()};
}

// The C structs of an array of parameters, in constant memory. `List::get()` returns a std::span<const Parameter> of
// static storage.
template <class List>
struct ParameterTable {
  static constexpr std::size_t count = List::get().size();

  static constexpr auto entries = [] {
    std::array<springnet_parameter, count> result{};
    for (std::size_t i = 0; i < count; ++i) result[i] = to_abi(List::get()[i]);
    return result;
  }();
  static constexpr auto addresses = [] {
    std::array<const springnet_parameter*, count> result{};
    for (std::size_t i = 0; i < count; ++i) result[i] = &entries[i];
    return result;
  }();
  static constexpr const springnet_parameter* const* pointer = count == 0 ? nullptr : addresses.data();
};

// An array of numbers that a law asks of a scene: table("force", "N", "tension at each length").increasing()
struct Table {
  const char* name = "";
  const char* unit = "1";
  const char* summary = "";
  std::uint32_t flags = 0;
  std::uint32_t least = 1;
  std::int32_t other = -1;  // as long as which; -1: none
  double smallest = -std::numeric_limits<double>::infinity();
  double largest = std::numeric_limits<double>::infinity();

  // Each value is greater than the one before.
  [[nodiscard]] constexpr Table increasing() const {
    Table t = *this;
    t.flags |= SPRINGNET_INCREASING;
    return t;
  }
  // A scene need not give it.
  [[nodiscard]] constexpr Table optional() const {
    Table t = *this;
    t.flags |= SPRINGNET_OPTIONAL;
    return t;
  }
  // It has this many values or more.
  [[nodiscard]] constexpr Table at_least_values(std::uint32_t count) const {
    Table t = *this;
    t.least = count;
    return t;
  }
  // It has as many values as table number `index`.
  [[nodiscard]] constexpr Table as_long_as(std::int32_t index) const {
    Table t = *this;
    t.other = index;
    return t;
  }
  [[nodiscard]] constexpr Table within(double low, double high) const {
    Table t = *this;
    t.smallest = low;
    t.largest = high;
    return t;
  }
};

[[nodiscard]] constexpr Table table(const char* name, const char* unit, const char* summary) {
  Table t;
  t.name = name;
  t.unit = unit;
  t.summary = summary;
  return t;
}

// As ParameterTable.
template <class List>
struct TableTable {
  static constexpr std::size_t count = List::get().size();
  static constexpr auto entries = [] {
    std::array<springnet_table, count> result{};
    for (std::size_t i = 0; i < count; ++i) {
      const Table& t = List::get()[i];
      result[i] = {sizeof(springnet_table),
                   t.flags,
                   t.name,
                   t.unit,
                   t.summary,
                   t.least,
                   t.other < 0 ? static_cast<std::uint32_t>(i) : static_cast<std::uint32_t>(t.other),
                   t.smallest,
                   t.largest};
    }
    return result;
  }();
  static constexpr auto addresses = [] {
    std::array<const springnet_table*, count> result{};
    for (std::size_t i = 0; i < count; ++i) result[i] = &entries[i];
    return result;
  }();
  static constexpr const springnet_table* const* pointer = count == 0 ? nullptr : addresses.data();
};

}  // namespace springnet::sdk
