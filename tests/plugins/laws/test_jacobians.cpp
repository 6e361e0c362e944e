// Every first derivative of every shipped law, over one invariant and several, against differences of its own answers.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "jacobian_call.hpp"
#include "points.hpp"
#include "shipped.hpp"

using namespace springnet::test;

namespace {

// Sixth-order central differences of all rows by a column, and a bound of their error: what halving the step changes.
struct Difference {
  std::vector<double> value, error;
};
Difference difference(const JacobianCall& call, const std::vector<double>& at, std::size_t column) {
  const auto slope = [&](double h) {
    const auto value = [&](double x) {
      std::vector<double> moved = at;
      moved[column] += x;
      return call(moved);
    };
    const auto a1 = value(h), b1 = value(-h), a2 = value(2 * h), b2 = value(-2 * h), a3 = value(3 * h),
               b3 = value(-3 * h);
    std::vector<double> result;
    for (std::size_t r = 0; r < a1.size(); ++r)
      result.push_back((45 * (a1[r] - b1[r]) - 9 * (a2[r] - b2[r]) + (a3[r] - b3[r])) / (60 * h));
    return result;
  };
  Difference result{slope(5e-4), slope(1e-3)};
  for (std::size_t r = 0; r < result.value.size(); ++r) result.error[r] = std::abs(result.error[r] - result.value[r]);
  return result;
}

void check(JacobianCall call, std::uint64_t seed, bool derivatives_of_switches) {
  std::mt19937_64 random(seed);
  for (int sample = 0; sample < 12; ++sample) {
    const std::vector<double> at = random_point(call, random);
    std::vector<double> matrix;
    const std::vector<double> rows = call(at, &matrix);
    CHECK(rows == call(at));  // the same bits with derivatives as without
    for (const std::uint32_t set : instruction_sets()) {
      JacobianCall other = call;
      other.instruction_set = set;
      std::vector<double> same;
      static_cast<void>(other(at, &same));
      CHECK(std::memcmp(same.data(), matrix.data(), matrix.size() * sizeof(double)) == 0);
    }
    for (std::size_t column = 0; column < call.columns(); ++column) {
      const bool is_parameter = column >= call.layout.parameter(0) && column < call.layout.state(0);
      if (is_parameter && !derivatives_of_switches &&
          call.component->parameters[column - call.layout.parameter(0)]->type != SPRINGNET_NUMBER)
        continue;
      const Difference numeric = difference(call, at, column);
      for (std::size_t row = 0; row < rows.size(); ++row) {
        if (!call.has_row(row)) continue;
        CAPTURE(std::string(call.component->id));
        CAPTURE(call.time_step);
        CAPTURE(call.order);
        CAPTURE(row);
        CAPTURE(column);
        CAPTURE(at);
        const double exact = matrix[row * call.columns() + column];
        // Rounding of rows over the step, and what is left of the formula's seventh derivative; a kink within the step
        // shows in `error`.
        const double rounding = 1e-12 * (std::abs(rows[row]) + 1.0) / 5e-4;
        CHECK(std::abs(exact - numeric.value[row]) <= rounding + 3.0 * numeric.error[row]);
      }
    }
  }
}

}  // namespace

TEST_CASE("all first derivatives of all shipped laws, by differences") {
  std::uint64_t seed = 1;
  for (const springnet_plugin* plugin : shipped_plugins()) {
    for (std::uint32_t i = 0; i < plugin->component_count; ++i) {
      const springnet_component& component = *plugin->components[i];
      if (component.kind != SPRINGNET_SPRING_FUNCTION && component.kind != SPRINGNET_VISCOSITY_FUNCTION) continue;
      JacobianCall call(component);
      CHECK(call.can(SPRINGNET_HAS_ALL_DERIVATIVES));
      check(call, ++seed, false);
      if (call.layout.states == 0) continue;
      for (const std::uint32_t order : {1u, 2u}) {
        call.time_step = 0.05;
        call.order = order;
        check(call, ++seed, false);
      }
      call.time_step = 0.0;
    }
  }
}

TEST_CASE("laws over several invariants answer the same bits in batches as one by one, in every instruction set") {
  std::mt19937_64 random(3);
  for (const springnet_plugin* plugin : shipped_plugins()) {
    const springnet_component& component = *plugin->components[0];
    if (component.kind != SPRINGNET_SPRING_FUNCTION && component.kind != SPRINGNET_VISCOSITY_FUNCTION) continue;
    const JacobianCall call(component);
    if (!call.several) continue;
    CAPTURE(std::string(component.id));
    const springnet::sdk::JacobianLayout& layout = call.layout;
    constexpr std::uint32_t count = 300;  // more than the kernels take at a time
    std::vector<std::vector<double>> points, columns(layout.columns(false), std::vector<double>(count));
    for (std::uint32_t i = 0; i < count; ++i) {
      points.push_back(random_point(call, random));
      points.back()[layout.time()] = 0.0;  // one for all
      for (std::size_t c = 0; c < columns.size(); ++c) columns[c][i] = points.back()[c];
    }
    const auto list = [&](std::size_t first, std::size_t size) {
      std::vector<const double*> pointers;
      for (std::size_t k = 0; k < size; ++k) pointers.push_back(columns[first + k].data());
      return pointers;
    };
    const auto values = list(layout.value(), layout.invariants), rates = list(layout.rate(), layout.invariants),
               references = list(layout.reference(), layout.invariants),
               parameters = list(layout.parameter(0), layout.parameters), direction = list(layout.direction(0), 3);
    const std::vector<std::uint32_t> strides(layout.parameters, 1);
    for (const std::uint32_t set : instruction_sets()) {
      std::vector<std::vector<double>> forces(layout.invariants, std::vector<double>(count));
      std::vector<std::vector<double>> matrix(layout.rows() * columns.size(), std::vector<double>(count));
      std::vector<double*> to, derivatives;
      for (auto& each : forces) to.push_back(each.data());
      for (std::size_t k = 0; k < matrix.size(); ++k)
        derivatives.push_back(k / columns.size() < layout.invariants ? matrix[k].data() : nullptr);
      springnet_law_batch batch{};
      batch.struct_size = sizeof batch;
      batch.count = count;
      batch.instruction_set = set;
      batch.parameters = parameters.data();
      batch.parameter_strides = strides.data();
      batch.values = values.data();
      batch.rates = rates.data();
      batch.references = references.data();
      batch.direction = direction.data();
      batch.forces = to.data();
      batch.derivatives = derivatives.data();
      REQUIRE(call.law->evaluate(call.law->context, &batch) == SPRINGNET_OK);
      for (std::uint32_t i = 0; i < count; ++i) {
        std::vector<double> own;
        const std::vector<double> rows = call(points[i], &own);
        bool same = true;
        for (std::size_t r = 0; r < layout.invariants; ++r) {
          same = same && rows[r] == forces[r][i];
          for (std::size_t c = 0; c < columns.size(); ++c)
            same = same && own[r * columns.size() + c] == matrix[r * columns.size() + c][i];
        }
        CHECK(same);
      }
    }
  }
}
