// Runs programs: each step is a loop over a tile, compiled for every instruction set with the mathematics of the SDK.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <springnet/sdk/kernel.hpp>
#include <springnet/sdk/math.hpp>

#include "formula/program.hpp"

namespace springnet::formula {
namespace {

struct Call {
  const Program& program;
  const Batch& batch;
  double* const* outputs;
  std::uint32_t instruction_set;
};

// Runs one step; arguments have stride 0 or 1.
struct Argument {
  const double* values;
  std::size_t stride;
};

template <class Formula>
SPRINGNET_INLINE void unary(const double* a, double* out, std::size_t count, const Formula& formula) {
  const double* __restrict x = a;
  double* __restrict y = out;
  SPRINGNET_INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < count; ++i) y[i] = formula(x[i]);
}
// One number for all, or one each: three loops, so that each has unit stride and vectorises.
template <class Formula>
SPRINGNET_INLINE void binary(const Argument& a, const Argument& b, double* out, std::size_t count,
                             const Formula& formula) {
  const double* __restrict x = a.values;
  const double* __restrict y = b.values;
  double* __restrict z = out;
  if (a.stride == 0) {
    const double own = *x;
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) z[i] = formula(own, y[i]);
  } else if (b.stride == 0) {
    const double own = *y;
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i], own);
  } else {
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i], y[i]);
  }
}

// formula(a b, c). Each operation is rounded: this is no fused multiplication.
template <class Formula>
SPRINGNET_INLINE void with_product(const Argument& a, const Argument& b, const Argument& c, double* out,
                                   std::size_t count, const Formula& formula) {
  const double* __restrict x = a.values;
  const double* __restrict y = b.values;
  const double* __restrict w = c.values;
  double* __restrict z = out;
  if (a.stride == 0 || count == 1) {  // what is the same for all, or comes in an unusual order
    const std::size_t dx = a.stride, dy = b.stride, dw = c.stride;
    for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i * dx] * y[i * dy], w[i * dw]);
  } else if (b.stride == 0) {
    const double factor = *y;
    if (c.stride == 0) {
      const double term = *w;
      SPRINGNET_INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i] * factor, term);
    } else {
      SPRINGNET_INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i] * factor, w[i]);
    }
  } else if (c.stride == 0) {
    const double term = *w;
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i] * y[i], term);
  } else {
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i] * y[i], w[i]);
  }
}

// formula(a b, c d).
template <class Formula>
SPRINGNET_INLINE void with_products(const Argument& a, const Argument& b, const Argument& c, const Argument& d,
                                    double* out, std::size_t count, const Formula& formula) {
  const double* __restrict x = a.values;
  const double* __restrict y = b.values;
  const double* __restrict v = c.values;
  const double* __restrict w = d.values;
  double* __restrict z = out;
  if (a.stride == 0 || c.stride == 0 || count == 1) {
    const std::size_t dx = a.stride, dy = b.stride, dv = c.stride, dw = d.stride;
    for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i * dx] * y[i * dy], v[i * dv] * w[i * dw]);
  } else if (b.stride == 0) {
    const double factor = *y;
    if (d.stride == 0) {
      const double other = *w;
      SPRINGNET_INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i] * factor, v[i] * other);
    } else {
      SPRINGNET_INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i] * factor, v[i] * w[i]);
    }
  } else if (d.stride == 0) {
    const double other = *w;
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i] * y[i], v[i] * other);
  } else {
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) z[i] = formula(x[i] * y[i], v[i] * w[i]);
  }
}

SPRINGNET_INLINE void expm1_and_slope(const double* a, double* out, double* also, std::size_t count) {
  const double* __restrict x = a;
  double* __restrict y = out;
  double* __restrict z = also;
  SPRINGNET_INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < count; ++i) {
    const sdk::detail::ExponentialPair both = sdk::detail::expm1_and_exp(x[i]);
    y[i] = both.less_1;
    z[i] = both.value;
  }
}

class Machine {
 public:
  SPRINGNET_INLINE static void run(const Call& call) {
    const Program& program = call.program;
    const std::size_t first_slot = program.first_slot(), places = program.places();
    constexpr std::size_t own_places = 192, own_slots = 32;
    std::array<const double*, own_places> few_places;
    std::array<std::uint8_t, own_places> few_varies;
    alignas(64) double few_slots[own_slots * tile_size];
    std::vector<const double*> many_places;
    std::vector<std::uint8_t> many_varies;
    std::unique_ptr<double[]> many_slots;
    const double** at = few_places.data();
    std::uint8_t* varies = few_varies.data();
    double* slots = few_slots;
    if (places > own_places) {
      many_places.resize(places);
      many_varies.resize(places);
      at = many_places.data();
      varies = many_varies.data();
    }
    if (program.slots > own_slots) {
      many_slots = std::make_unique_for_overwrite<double[]>(program.slots * tile_size);
      slots = many_slots.get();
    }
    for (std::size_t k = 0; k < program.inputs.size(); ++k) {
      at[k] = call.batch.inputs[program.inputs[k]];
      varies[k] = call.batch.strides[program.inputs[k]] != 0;
    }
    for (std::size_t k = 0; k < program.constants.size(); ++k) {
      at[program.first_constant() + k] = &program.constants[k];
      varies[program.first_constant() + k] = 0;
    }
    for (std::size_t k = 0; k < program.slots; ++k) at[first_slot + k] = slots + k * tile_size;

    // What is one number for all is computed once: such steps keep their slots, see schedule().
    std::size_t varying = 0;
    for (const ProgramStep& step : program.steps) {
      const unsigned count = arguments_of(step.code);
      varies[step.also] = varies[step.to] = varies[step.a] != 0 || (count > 1 && varies[step.b] != 0) ||
                                            (count > 2 && varies[step.c] != 0) || (count > 3 && varies[step.d] != 0);
      const auto slot = [&](Place place) { return slots + (place - first_slot) * tile_size; };
      if (varies[step.to] == 0)
        run_step(step, {{{at[step.a], 0}, {at[step.b], 0}, {at[step.c], 0}, {at[step.d], 0}}}, slot(step.to),
                 slot(step.also), 1, call.batch.curves);
      else
        ++varying;
    }
    // Where an output is computed tile by tile, it is written to its array at once.
    std::array<std::uint32_t, max_outputs> direct;
    std::size_t direct_count = 0;
    for (std::uint32_t k = 0; k < program.outputs.size(); ++k) {
      const Place place = program.outputs[k];
      const auto has_place = [&](std::uint32_t other) { return program.outputs[other] == place; };
      if (call.outputs[k] != nullptr && place >= first_slot && varies[place] != 0 &&
          std::none_of(direct.data(), direct.data() + direct_count, has_place))
        direct[direct_count++] = k;
    }
    for (std::size_t begin = 0; begin < call.batch.count; begin += tile_size) {
      for (std::size_t k = 0; k < direct_count; ++k) at[program.outputs[direct[k]]] = call.outputs[direct[k]] + begin;
      const std::size_t count = std::min(tile_size, call.batch.count - begin);
      const auto argument = [&](Place place) -> Argument {
        const std::size_t stride = varies[place] != 0 ? 1 : 0;
        return {at[place] + (place < program.inputs.size() ? stride * begin : 0), stride};
      };
      if (varying > 0) {
        for (const ProgramStep& step : program.steps) {
          if (varies[step.to] == 0) continue;
          run_step(step, {{argument(step.a), argument(step.b), argument(step.c), argument(step.d)}},
                   const_cast<double*>(at[step.to]), const_cast<double*>(at[step.also]), count, call.batch.curves);
        }
      }
      for (std::size_t k = 0; k < program.outputs.size(); ++k) {
        if (call.outputs[k] == nullptr) continue;
        const Argument from = argument(program.outputs[k]);
        double* const out = call.outputs[k] + begin;
        if (from.values == out) continue;
        if (from.stride == 0)
          std::fill_n(out, count, *from.values);
        else
          std::copy_n(from.values, count, out);
      }
    }
  }

 private:
  SPRINGNET_INLINE static unsigned arguments_of(Code code) {
    switch (code) {
      case Code::sum_of_products:
      case Code::products_difference:
        return 4;
      case Code::choose:
      case Code::product_sum:
      case Code::product_difference:
      case Code::difference_product:
      case Code::product_product:
        return 3;
      case Code::sum:
      case Code::difference:
      case Code::product:
      case Code::quotient:
      case Code::less:
      case Code::less_or_equal:
      case Code::equal:
      case Code::both:
      case Code::either:
      case Code::power:
      case Code::hypot:
      case Code::atan2:
        return 2;
      default:
        return 1;
    }
  }

  // also: where the second result goes, of a step that has two.
  SPRINGNET_INLINE static void run_step(const ProgramStep& step, const std::array<Argument, 4>& arguments, double* out,
                                        double* also, std::size_t count, const Curves* curves) {
    const auto& [a, b, c, d] = arguments;
    const double* const x = a.values;
    const auto two = [&](const auto& formula) { binary(a, b, out, count, formula); };
    const auto one = [&](const auto& formula) { unary(x, out, count, formula); };
    switch (step.code) {
      case Code::constant:
      case Code::input:
        return;
      case Code::negative:
        return one([](double v) { return -v; });
      case Code::sum:
        return two([](double v, double w) { return v + w; });
      case Code::difference:
        return two([](double v, double w) { return v - w; });
      case Code::product:
        return two([](double v, double w) { return v * w; });
      case Code::quotient:
        return two([](double v, double w) { return v / w; });
      case Code::less:
        return two([](double v, double w) { return v < w ? 1.0 : 0.0; });
      case Code::less_or_equal:
        return two([](double v, double w) { return v <= w ? 1.0 : 0.0; });
      case Code::equal:
        return two([](double v, double w) { return v == w ? 1.0 : 0.0; });
      case Code::both:
        return two([](double v, double w) { return v * w; });
      case Code::either:
        return two([](double v, double w) { return v + w != 0.0 ? 1.0 : 0.0; });
      case Code::negation:
        return one([](double v) { return 1.0 - v; });
      case Code::choose:
        return choose(a, b, c, out, count);
      case Code::product_product:
        return with_product(a, b, c, out, count, [](double product, double w) { return product * w; });
      case Code::sum_of_products:
        return with_products(a, b, c, d, out, count, [](double v, double w) { return v + w; });
      case Code::products_difference:
        return with_products(a, b, c, d, out, count, [](double v, double w) { return v - w; });
      case Code::product_sum:
        return with_product(a, b, c, out, count, [](double product, double w) { return product + w; });
      case Code::product_difference:
        return with_product(a, b, c, out, count, [](double product, double w) { return product - w; });
      case Code::difference_product:
        return with_product(a, b, c, out, count, [](double product, double w) { return w - product; });
      case Code::absolute:
        return one([](double v) { return std::abs(v); });
      case Code::floor:
        return one([](double v) { return std::floor(v); });
      case Code::ceil:
        return one([](double v) { return std::ceil(v); });
      case Code::sqrt:
        return one([](double v) { return sdk::sqrt(v); });
      case Code::cbrt:
        return one([](double v) { return sdk::cbrt(v); });
      case Code::exp:
        return one([](double v) { return sdk::exp(v); });
      case Code::expm1:
        return one([](double v) { return sdk::expm1(v); });
      case Code::expm1_slope:
        return one([](double v) { return sdk::detail::expm1_and_exp(v).value; });
      case Code::expm1_and_slope:
        return expm1_and_slope(x, out, also, count);
      case Code::log:
        return one([](double v) { return sdk::log(v); });
      case Code::log1p:
        return one([](double v) { return sdk::log1p(v); });
      case Code::log10:
        return one([](double v) { return sdk::log10(v); });
      case Code::sin:
        return one([](double v) { return sdk::sin(v); });
      case Code::cos:
        return one([](double v) { return sdk::cos(v); });
      case Code::tan:
        return one([](double v) { return sdk::tan(v); });
      case Code::asin:
        return one([](double v) { return sdk::asin(v); });
      case Code::acos:
        return one([](double v) { return sdk::acos(v); });
      case Code::atan:
        return one([](double v) { return sdk::atan(v); });
      case Code::sinh:
        return one([](double v) { return sdk::sinh(v); });
      case Code::cosh:
        return one([](double v) { return sdk::cosh(v); });
      case Code::tanh:
        return one([](double v) { return sdk::tanh(v); });
      case Code::erf:
        return one([](double v) { return sdk::erf(v); });
      case Code::power:
        return two([](double v, double w) { return sdk::pow(v, w); });
      case Code::hypot:
        return two([](double v, double w) { return sdk::hypot(v, w); });
      case Code::atan2:
        return two([](double v, double w) { return sdk::atan2(v, w); });
      case Code::curve:
      case Code::curve_slope:
      case Code::curve_bend:
        return curves->evaluate(step.index, static_cast<unsigned>(step.code) - static_cast<unsigned>(Code::curve), x,
                                out, count);
    }
  }

  SPRINGNET_INLINE static void choose(const Argument& condition, const Argument& b, const Argument& c, double* out,
                                      std::size_t count) {
    const auto pick = [&](const Argument& from) {
      if (from.stride == 0)
        std::fill_n(out, count, *from.values);
      else
        std::copy_n(from.values, count, out);
    };
    if (condition.stride == 0) return pick(*condition.values != 0.0 ? b : c);
    const double* __restrict is = condition.values;
    const double* __restrict x = b.values;
    const double* __restrict y = c.values;
    double* __restrict z = out;
    const std::size_t dx = b.stride, dy = c.stride;
    if (dx == 1 && dy == 1) {
      SPRINGNET_INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < count; ++i) z[i] = is[i] != 0.0 ? x[i] : y[i];
    } else if (dx == 1) {
      const double other = *y;
      SPRINGNET_INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < count; ++i) z[i] = is[i] != 0.0 ? x[i] : other;
    } else if (dy == 1) {
      const double own = *x;
      SPRINGNET_INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < count; ++i) z[i] = is[i] != 0.0 ? own : y[i];
    } else {
      const double own = *x, other = *y;
      SPRINGNET_INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < count; ++i) z[i] = is[i] != 0.0 ? own : other;
    }
  }
};

}  // namespace

void run(const Program& program, const Batch& batch, double* const* outputs) {
  sdk::detail::run<Machine>(Call{program, batch, outputs, batch.instruction_set});
}

}  // namespace springnet::formula
