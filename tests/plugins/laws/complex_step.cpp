// Every first derivative of every shipped law by the complex step of its formulas, compiled once more for this: to
// rounding, where differences leave a millionth of that. Forces against energies likewise.
#include <cstdint>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "complex.hpp"

#include <springnet/sdk/law.hpp>
#include <springnet/sdk/law/simplex.hpp>
#include <springnet/sdk/table.hpp>

// What plugins include, before that is within a namespace.
#include "../../../plugins/springs/solid/neo_hookean.hpp"

#include "points.hpp"
#include "shipped.hpp"

// The formulas of a plugin without its kernels and its entry.
#undef SPRINGNET_PLUGIN
#define SPRINGNET_PLUGIN(id, version, author, licence, ...) using Laws = std::tuple<__VA_ARGS__>

namespace spring_linear {
#include "../../../plugins/springs/linear/linear.cpp"
}
namespace spring_nonlinear {
#include "../../../plugins/springs/nonlinear/nonlinear.cpp"
}
namespace spring_exponential {
#include "../../../plugins/springs/exponential/exponential.cpp"
}
namespace spring_rupturing {
#include "../../../plugins/springs/rupturing/rupturing.cpp"
}
namespace spring_muscle {
#include "../../../plugins/springs/muscle/muscle.cpp"
}
namespace spring_maxwell {
#include "../../../plugins/springs/maxwell/maxwell.cpp"
}
namespace spring_standard_linear_solid {
#include "../../../plugins/springs/standard_linear_solid/standard_linear_solid.cpp"
}
namespace spring_plastic {
#include "../../../plugins/springs/plastic/plastic.cpp"
}
namespace spring_damaging {
#include "../../../plugins/springs/damaging/damaging.cpp"
}
namespace spring_membrane {
#include "../../../plugins/springs/membrane/membrane.cpp"
}
namespace spring_solid {
#include "../../../plugins/springs/solid/solid.cpp"
}
namespace spring_fibre_solid {
#include "../../../plugins/springs/fibre_solid/fibre_solid.cpp"
}
namespace spring_shell {
#include "../../../plugins/springs/shell/shell.cpp"
}
namespace viscosity_linear {
#include "../../../plugins/viscosities/linear/linear.cpp"
}
namespace viscosity_relative {
#include "../../../plugins/viscosities/relative/relative.cpp"
}
namespace viscosity_power {
#include "../../../plugins/viscosities/power/power.cpp"
}
namespace viscosity_viscous_membrane {
#include "../../../plugins/viscosities/viscous_membrane/viscous_membrane.cpp"
}
namespace viscosity_viscous_solid {
#include "../../../plugins/viscosities/viscous_solid/viscous_solid.cpp"
}

using namespace springnet::test;

namespace {

using springnet::sdk::Complex;

// The rows of a law's Jacobian at a point of all columns.
template <class Law>
std::vector<Complex> rows_at(const std::vector<Complex>& at) {
  using Traits = springnet::sdk::LawTraits<Law>;
  constexpr springnet::sdk::JacobianLayout layout = Traits::jacobian;
  const Law law{};
  const typename Traits::Table table{};
  const springnet::sdk::Parameters<Complex> p(&at[layout.parameter(0)]);
  const Complex *const states = &at[layout.state(0)], *const inputs = &at[layout.input(0)];
  std::vector<Complex> rows(layout.rows());
  const auto fill = [&](const auto& e) {
    const auto forces = law.force(e, p);
    if constexpr (Traits::several)
      std::copy(forces.begin(), forces.end(), rows.begin());
    else
      rows[layout.force()] = forces;
    if constexpr (Traits::has_energy) rows[layout.energy()] = law.energy(e, p);
    if constexpr (Traits::has_margin) rows[layout.margin()] = law.margin(e, p);
    if constexpr (Traits::state_count > 0) {
      const auto rates = law.state_rates(e, p);
      std::copy(rates.begin(), rates.end(), rows.begin() + static_cast<std::ptrdiff_t>(layout.state_row(0)));
    }
  };
  const auto list = [&]<std::size_t... i>(std::size_t first, std::index_sequence<i...>) {
    return std::array<Complex, sizeof...(i)>{at[first + i]...};
  };
  if constexpr (Traits::several) {
    constexpr std::make_index_sequence<Traits::invariant_count> all{};
    fill(springnet::sdk::SeveralOf<Complex, Traits::invariant_count, typename Traits::Table>{
        list(layout.value(), all), list(layout.rate(), all), list(layout.reference(), all),
        list(layout.direction(0), std::make_index_sequence<3>{}), at[layout.time()], table, states, inputs});
  } else {
    fill(springnet::sdk::Element<Complex, typename Traits::Table>{
        at[layout.value()], at[layout.rate()], at[layout.reference()], at[layout.time()], table, states, inputs});
  }
  return rows;
}

template <class Law>
void check(const springnet_component& component, std::uint64_t seed) {
  using Traits = springnet::sdk::LawTraits<Law>;
  constexpr springnet::sdk::JacobianLayout layout = Traits::jacobian;
  constexpr double step = 1e-60;
  CAPTURE(std::string(component.id));
  REQUIRE(std::string(component.id) == Law::id);
  const JacobianCall call(component);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int sample = 0; sample < 20; ++sample) {
    std::vector<double> at = random_point(call, random);
    if (sample % 4 == 1)  // shortened, and the other way
      for (std::size_t i = 0; i < layout.invariants; ++i) {
        at[layout.value(i)] = (0.8 + 0.1 * unit(random)) * at[layout.reference(i)];
        at[layout.rate(i)] = -at[layout.rate(i)];
      }
    std::vector<double> matrix;
    const std::vector<double> values = call(at, &matrix);
    double largest = 1.0;
    for (const double value : values) largest = std::max(largest, std::abs(value));
    // Sums of some ten terms, which partly cancel, and of functions that are exact to two roundings.
    const double rounding = 2e-13 * largest;
    const auto rows_with = [&](std::size_t column) {
      std::vector<Complex> moved(at.begin(), at.end());
      if (column < moved.size()) moved[column] = Complex(std::complex<double>(at[column], step));
      return rows_at<Law>(moved);
    };
    const std::vector<Complex> rows = rows_with(at.size());
    for (std::size_t row = 0; row < values.size(); ++row)
      if (call.has_row(row)) CHECK(std::abs(rows[row].z.real() - values[row]) <= rounding);
    for (std::size_t column = 0; column < call.columns(); ++column) {
      const bool is_parameter = column >= layout.parameter(0) && column < layout.state(0);
      if (is_parameter && component.parameters[column - layout.parameter(0)]->type != SPRINGNET_NUMBER) continue;
      const std::vector<Complex> moved = rows_with(column);
      CAPTURE(column);
      CAPTURE(at);
      for (std::size_t row = 0; row < values.size(); ++row) {
        if (!call.has_row(row)) continue;
        CAPTURE(row);
        const double exact = moved[row].z.imag() / step;
        CHECK(std::abs(matrix[row * call.columns() + column] - exact) <= rounding * (1.0 + std::abs(exact)));
      }
      // The force of a scalar is the derivative of the energy, except for what is viscous.
      if (Traits::has_energy && column < layout.rate() && call.reads_value(column - layout.value())) {
        double force = values[layout.force(column)];
        if (Traits::reads_rate) {
          std::vector<Complex> still(at.begin(), at.end());
          for (std::size_t i = 0; i < layout.invariants; ++i) still[layout.rate(i)] = 0.0;
          force = rows_at<Law>(still)[layout.force(column)].z.real();
        }
        const double slope = moved[layout.energy()].z.imag() / step;
        const bool is_active = Law::adds_power;  // muscles pull where they store nothing
        if (!is_active) CHECK(std::abs(force - slope) <= rounding * (1.0 + std::abs(slope)));
      }
    }
  }
}

template <class Laws>
void check_plugin(std::uint32_t kind, std::uint64_t seed) {
  using Law = std::tuple_element_t<0, Laws>;
  static_assert(std::tuple_size_v<Laws> == 1);
  check<Law>(shipped(kind, Law::id), seed);
}

}  // namespace

TEST_CASE("all first derivatives of all shipped laws, by the complex step") {
  constexpr std::uint32_t spring = SPRINGNET_SPRING_FUNCTION, viscosity = SPRINGNET_VISCOSITY_FUNCTION;
  check_plugin<spring_linear::Laws>(spring, 1);
  check_plugin<spring_nonlinear::Laws>(spring, 2);
  check_plugin<spring_exponential::Laws>(spring, 3);
  check_plugin<spring_rupturing::Laws>(spring, 4);
  check_plugin<spring_muscle::Laws>(spring, 5);
  check_plugin<spring_maxwell::Laws>(spring, 6);
  check_plugin<spring_standard_linear_solid::Laws>(spring, 7);
  check_plugin<spring_plastic::Laws>(spring, 8);
  check_plugin<spring_damaging::Laws>(spring, 9);
  check_plugin<spring_membrane::Laws>(spring, 10);
  check_plugin<spring_solid::Laws>(spring, 11);
  check_plugin<spring_fibre_solid::Laws>(spring, 12);
  check_plugin<spring_shell::Laws>(spring, 13);
  check_plugin<viscosity_linear::Laws>(viscosity, 14);
  check_plugin<viscosity_relative::Laws>(viscosity, 15);
  check_plugin<viscosity_power::Laws>(viscosity, 16);
  check_plugin<viscosity_viscous_membrane::Laws>(viscosity, 17);
  check_plugin<viscosity_viscous_solid::Laws>(viscosity, 18);
  // Plugins that are added later belong here: neurons and `table`, which needs a table, are the others.
  std::size_t laws = 0;
  for (const springnet_plugin* plugin : shipped_plugins())
    if (plugin->components[0]->kind != SPRINGNET_NEURON) ++laws;
  CHECK(laws == 18);
}
