// The glue of neuron.hpp over a neuron class.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <springnet/sdk/neuron.hpp>

#include "law_call.hpp"

namespace {
using namespace springnet::sdk;
using springnet::test::Array;
using springnet::test::instruction_sets;
using springnet::test::same_bits;

// Reads everything: a = (F - b |v|^2 v - c (p . F) p) / m + (t, 0, 0); throws for a mass above 100.
struct Odd : Neuron {
  static constexpr const char* id = "odd";
  static constexpr const char* summary = "reads everything";
  static constexpr Parameter parameters[] = {number("b", "kg s/m^2", ""), number("c", "1/m^2", "")};
  template <class Real>
  static Vector<Real> acceleration(const Node<Real>& n, const Parameters<Real>& p) {
    if (n.mass > 100.0) throw std::runtime_error("too heavy");
    const Vector<Real> push =
        n.force - p[0] * dot(n.velocity, n.velocity) * n.velocity - p[1] * dot(n.position, n.force) * n.position;
    return push / n.mass + Vector<Real>{n.time, 0.0, 0.0};
  }
};

constexpr const springnet_component& odd = ComponentEntry<Odd>::value;

struct Nodes {
  std::uint32_t count;
  std::array<Array, 9> in;  // F, p, v
  Array mass, b, c;
  std::array<Array, 3> a;
  Array by_force, by_position, by_velocity;
  Array by_mass, by_time, by_b, by_c;
  double time = 0.5;
  std::uint32_t struct_size = sizeof(springnet_neuron_batch);

  explicit Nodes(std::uint32_t n) : count(n), mass(n), b(n), c{0.02} {
    for (std::size_t j = 0; j < 9; ++j) {
      in[j].resize(n);
      for (std::uint32_t i = 0; i < n; ++i) in[j][i] = std::sin(1.0 + 3.7 * static_cast<double>(j) + 0.9 * i);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      mass[i] = 1.0 + 0.01 * i;
      b[i] = 0.3 + 0.001 * i;
    }
  }
  springnet_status evaluate(std::uint32_t set, std::uint32_t tile, springnet_message* message = nullptr) {
    for (Array& each : a) each.assign(count, 0.0);
    for (Array* each : {&by_force, &by_position, &by_velocity}) each->assign(9 * std::size_t{count}, 0.0);
    for (Array* each : {&by_mass, &by_time, &by_b, &by_c}) each->assign(3 * std::size_t{count}, 0.0);
    for (std::uint32_t first = 0; first < count; first += tile) {
      const auto at = [&](std::size_t j) { return in[j].data() + first; };
      const double* parameters[] = {b.data() + first, c.data()};
      const std::uint32_t strides[] = {1, 0};
      springnet_neuron_batch batch{};
      batch.struct_size = struct_size;
      batch.count = std::min(tile, count - first);
      batch.instruction_set = set;
      batch.time = time;
      batch.force = {at(0), at(1), at(2)};
      batch.position = {at(3), at(4), at(5)};
      batch.velocity = {at(6), at(7), at(8)};
      batch.mass = mass.data() + first;
      batch.parameters = parameters;
      batch.parameter_strides = strides;
      batch.acceleration = {a[0].data() + first, a[1].data() + first, a[2].data() + first};
      batch.acceleration_by_force = by_force.data() + 9 * std::size_t{first};
      batch.acceleration_by_position = by_position.data() + 9 * std::size_t{first};
      batch.acceleration_by_velocity = by_velocity.data() + 9 * std::size_t{first};
      double* const by_parameters[] = {by_b.data() + 3 * std::size_t{first}, by_c.data() + 3 * std::size_t{first}};
      batch.acceleration_by_mass = by_mass.data() + 3 * std::size_t{first};
      batch.acceleration_by_time = by_time.data() + 3 * std::size_t{first};
      batch.acceleration_by_parameters = by_parameters;
      batch.message = message;
      const auto& model = *static_cast<const springnet_neuron_model*>(odd.implementation);
      const springnet_status status = model.evaluate(model.context, &batch);
      if (status != SPRINGNET_OK) return status;
    }
    return SPRINGNET_OK;
  }
};

}  // namespace

TEST_CASE("metadata of a neuron come from its class") {
  CHECK(odd.kind == SPRINGNET_NEURON);
  CHECK(odd.parameter_count == 2);
  CHECK(odd.capabilities == (SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_PARAMETER_DERIVATIVES));
  CHECK(odd.needs == 0);
}

TEST_CASE("acceleration of a neuron against the formula in plain numbers") {
  Nodes nodes(300);
  REQUIRE(nodes.evaluate(SPRINGNET_GENERIC, 300) == SPRINGNET_OK);
  for (std::uint32_t i : {0u, 255u, 256u, 299u}) {
    const auto x = [&](std::size_t j) { return nodes.in[j][i]; };
    const double vv = x(6) * x(6) + x(7) * x(7) + x(8) * x(8);
    const double pf = x(3) * x(0) + x(4) * x(1) + x(5) * x(2);
    for (std::size_t j = 0; j < 3; ++j) {
      const double expected = (x(j) - nodes.b[i] * vv * x(6 + j) - nodes.c[0] * pf * x(3 + j)) / nodes.mass[i];
      // A few roundings of numbers of size one.
      CHECK(std::abs(nodes.a[j][i] - expected - (j == 0 ? 0.5 : 0.0)) < 1e-14);
    }
  }
}

TEST_CASE("derivative blocks of a neuron against differences") {
  Nodes nodes(3);
  REQUIRE(nodes.evaluate(SPRINGNET_GENERIC, 3) == SPRINGNET_OK);
  const Nodes at = nodes;
  const Array* blocks[] = {&at.by_force, &at.by_position, &at.by_velocity};
  for (std::size_t input = 0; input < 9; ++input) {
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::uint32_t i = 0; i < 3; ++i) {
        const auto f = [&](double value) {
          Nodes moved = at;
          moved.in[input][i] = value;
          REQUIRE(moved.evaluate(SPRINGNET_GENERIC, 3) == SPRINGNET_OK);
          return moved.a[row][i];
        };
        // A polynomial of third degree: the difference is exact but for rounding, 2e-16 / 1e-2.
        const double expected = springnet::test::derivative(f, at.in[input][i], 1e-2);
        CHECK(std::abs((*blocks[input / 3])[9 * i + 3 * row + input % 3] - expected) < 1e-12);
      }
    }
  }
}

TEST_CASE("derivatives of a neuron by mass, time and parameters against differences") {
  Nodes nodes(3);
  REQUIRE(nodes.evaluate(SPRINGNET_GENERIC, 3) == SPRINGNET_OK);
  const Nodes at = nodes;
  const auto check = [&](const Array& derivatives, std::size_t i, double value, const auto& set) {
    for (std::size_t row = 0; row < 3; ++row) {
      const auto f = [&](double x) {
        Nodes moved = at;
        set(moved, x);
        REQUIRE(moved.evaluate(SPRINGNET_GENERIC, 3) == SPRINGNET_OK);
        return moved.a[row][i];
      };
      // Powers of the mass: truncation (h / m)^8; rounding, 2e-16 / 1e-2.
      const double expected = springnet::test::derivative(f, value, 1e-2);
      CHECK(std::abs(derivatives[3 * i + row] - expected) < 1e-12);
    }
  };
  for (std::size_t i = 0; i < 3; ++i) {
    check(at.by_mass, i, at.mass[i], [i](Nodes& n, double x) { n.mass[i] = x; });
    check(at.by_time, i, at.time, [](Nodes& n, double x) { n.time = x; });
    check(at.by_b, i, at.b[i], [i](Nodes& n, double x) { n.b[i] = x; });
    check(at.by_c, i, at.c[0], [](Nodes& n, double x) { n.c[0] = x; });
  }
}

TEST_CASE("a host of ABI 2.0 is not asked for derivatives by mass, time and parameters") {
  Nodes nodes(2);
  nodes.struct_size = SPRINGNET_SIZE_TO(springnet_neuron_batch, message);
  REQUIRE(nodes.evaluate(SPRINGNET_GENERIC, 2) == SPRINGNET_OK);
  for (const Array* each : {&nodes.by_mass, &nodes.by_time, &nodes.by_b, &nodes.by_c}) CHECK(*each == Array(6, 0.0));
  CHECK(nodes.by_force[0] != 0.0);
}

TEST_CASE("a neuron gives the same bits for every instruction set and tile") {
  Nodes whole(600);
  REQUIRE(whole.evaluate(SPRINGNET_GENERIC, 600) == SPRINGNET_OK);
  for (const std::uint32_t set : instruction_sets()) {
    for (const std::uint32_t tile : {1u, 5u, 64u, 257u, 600u}) {
      Nodes nodes(600);
      REQUIRE(nodes.evaluate(set, tile) == SPRINGNET_OK);
      for (std::size_t j = 0; j < 3; ++j) CHECK(same_bits(nodes.a[j], whole.a[j]));
      CHECK(same_bits(nodes.by_force, whole.by_force));
      CHECK(same_bits(nodes.by_position, whole.by_position));
      CHECK(same_bits(nodes.by_velocity, whole.by_velocity));
      CHECK(same_bits(nodes.by_mass, whole.by_mass));
      CHECK(same_bits(nodes.by_time, whole.by_time));
      CHECK(same_bits(nodes.by_b, whole.by_b));
      CHECK(same_bits(nodes.by_c, whole.by_c));
    }
  }
}

TEST_CASE("no exception leaves a neuron") {
  Nodes nodes(2);
  nodes.mass[1] = 101.0;
  springnet_message message{};
  CHECK(nodes.evaluate(SPRINGNET_GENERIC, 2, &message) == SPRINGNET_FAILED);
  CHECK(std::string(message.text) == "too heavy");
}
