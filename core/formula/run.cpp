// Runs programs: each step is a loop over a tile, compiled for every instruction set with the mathematics of the SDK.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <type_traits>
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

// One number for all, or one each: a loop for every combination, so that each has unit stride and vectorises.
struct Same {
  double value;
  SPRINGNET_INLINE double operator()(std::size_t) const { return value; }
};
struct Each {
  const double* values;
  SPRINGNET_INLINE double operator()(std::size_t i) const { return values[i]; }
};
template <class Formula, class... Read>
SPRINGNET_INLINE void loop(double* out, std::size_t count, const Formula& formula, const Read&... read) {
  double* __restrict result = out;
  SPRINGNET_INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < count; ++i) result[i] = formula(read(i)...);
}
// out[i] = formula(arguments[i]…). Each operation of a formula is rounded: there is no fused multiplication.
template <std::size_t arguments, class Formula, class... Read>
SPRINGNET_INLINE void apply(const Argument* argument, double* out, std::size_t count, const Formula& formula,
                            const Read&... read) {
  if constexpr (sizeof...(read) == arguments)
    loop(out, count, formula, read...);
  else if (argument->stride == 0)
    apply<arguments>(argument + 1, out, count, formula, read..., Same{*argument->values});
  else
    apply<arguments>(argument + 1, out, count, formula, read..., Each{argument->values});
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
      bool varied = false;
      for (unsigned i = 0; i < step.arguments; ++i) varied = varied || varies[step.from[i]] != 0;
      varies[step.also] = varies[step.to] = varied ? 1 : 0;
      if (varied)
        ++varying;
      else
        run_step(step, at, varies, 1, call.batch.curves);
    }
    // Where an output is computed tile by tile, it is written to its array at once.
    const std::size_t output_count = program.outputs.size(), input_count = program.inputs.size();
    const Place* const places_of_outputs = program.outputs.data();
    std::array<std::uint32_t, max_outputs> direct;
    std::size_t direct_count = 0;
    for (std::uint32_t k = 0; k < output_count; ++k) {
      const Place place = places_of_outputs[k];
      const auto has_place = [&](std::uint32_t other) { return places_of_outputs[other] == place; };
      if (call.outputs[k] != nullptr && place >= first_slot && varies[place] != 0 &&
          std::none_of(direct.data(), direct.data() + direct_count, has_place))
        direct[direct_count++] = k;
    }
    for (std::size_t begin = 0; begin < call.batch.count; begin += tile_size) {
      for (std::size_t k = 0; k < direct_count; ++k) at[places_of_outputs[direct[k]]] = call.outputs[direct[k]] + begin;
      const std::size_t count = std::min(tile_size, call.batch.count - begin);
      if (varying > 0)
        for (const ProgramStep& step : program.steps)
          if (varies[step.to] != 0) run_step(step, at, varies, count, call.batch.curves);
      for (std::size_t k = 0; k < output_count; ++k) {
        if (call.outputs[k] == nullptr) continue;
        const Place place = places_of_outputs[k];
        double* const out = call.outputs[k] + begin;
        if (at[place] == out) continue;
        if (varies[place] == 0)
          std::fill_n(out, count, *at[place]);
        else
          std::copy_n(at[place], count, out);
      }
      for (std::size_t k = 0; k < input_count; ++k)
        if (varies[k] != 0) at[k] += tile_size;
    }
  }

 private:
  // out[i] = formula(…) of the step's arguments.
  template <std::size_t arguments, class Formula>
  SPRINGNET_INLINE static void with(const ProgramStep& step, const double* const* at, const std::uint8_t* varies,
                                    std::size_t count, const Formula& formula) {
    std::array<Argument, arguments> argument;
    for (std::size_t i = 0; i < arguments; ++i) argument[i] = {at[step.from[i]], varies[step.from[i]]};
    apply<arguments>(argument.data(), const_cast<double*>(at[step.to]), count, formula);
  }
  // at: where each place is; its results go where the step's places say.
  SPRINGNET_INLINE static void run_step(const ProgramStep& step, const double* const* at, const std::uint8_t* varies,
                                        std::size_t count, const Curves* curves) {
    double* const out = const_cast<double*>(at[step.to]);
    switch (step.code) {
      case Code::constant:
      case Code::input:
        return;
      case Code::negative:
        return loop(
            out, count, [](double v) { return -v; }, Each{at[step.from[0]]});
      case Code::sum:
        return with<2>(step, at, varies, count, [](double v, double w) { return v + w; });
      case Code::difference:
        return with<2>(step, at, varies, count, [](double v, double w) { return v - w; });
      case Code::product:
        return with<2>(step, at, varies, count, [](double v, double w) { return v * w; });
      case Code::quotient:
        return with<2>(step, at, varies, count, [](double v, double w) { return v / w; });
      case Code::less:
        return with<2>(step, at, varies, count, [](double v, double w) { return v < w ? 1.0 : 0.0; });
      case Code::less_or_equal:
        return with<2>(step, at, varies, count, [](double v, double w) { return v <= w ? 1.0 : 0.0; });
      case Code::equal:
        return with<2>(step, at, varies, count, [](double v, double w) { return v == w ? 1.0 : 0.0; });
      case Code::both:
        return with<2>(step, at, varies, count, [](double v, double w) { return v * w; });
      case Code::either:
        return with<2>(step, at, varies, count, [](double v, double w) { return v + w != 0.0 ? 1.0 : 0.0; });
      case Code::negation:
        return loop(
            out, count, [](double v) { return 1.0 - v; }, Each{at[step.from[0]]});
      case Code::choose:
        return with<3>(step, at, varies, count,
                       [](double condition, double x, double y) { return condition != 0.0 ? x : y; });
      case Code::product_sum:
        return with<3>(step, at, varies, count, [](double x, double y, double z) { return x * y + z; });
      case Code::product_difference:
        return with<3>(step, at, varies, count, [](double x, double y, double z) { return x * y - z; });
      case Code::difference_product:
        return with<3>(step, at, varies, count, [](double x, double y, double z) { return z - x * y; });
      case Code::product_product:
        return with<3>(step, at, varies, count, [](double x, double y, double z) { return x * y * z; });
      case Code::product_product_sum:
        return with<4>(step, at, varies, count, [](double x, double y, double z, double w) { return x * y * z + w; });
      case Code::product_sum_product:
        return with<4>(step, at, varies, count, [](double x, double y, double z, double w) { return (x * y + z) * w; });
      case Code::sum_of_products:
        return with<4>(step, at, varies, count, [](double x, double y, double z, double w) { return x * y + z * w; });
      case Code::sum_of_longer_products:
        return with<5>(step, at, varies, count,
                       [](double x, double y, double z, double v, double w) { return x * y * z + v * w; });
      case Code::products_difference:
        return with<4>(step, at, varies, count, [](double x, double y, double z, double w) { return x * y - z * w; });
      case Code::absolute:
        return loop(
            out, count, [](double v) { return std::abs(v); }, Each{at[step.from[0]]});
      case Code::floor:
        return loop(
            out, count, [](double v) { return std::floor(v); }, Each{at[step.from[0]]});
      case Code::ceil:
        return loop(
            out, count, [](double v) { return std::ceil(v); }, Each{at[step.from[0]]});
      case Code::sqrt:
        return loop(
            out, count, [](double v) { return sdk::sqrt(v); }, Each{at[step.from[0]]});
      case Code::cbrt:
        return loop(
            out, count, [](double v) { return sdk::cbrt(v); }, Each{at[step.from[0]]});
      case Code::exp:
        return loop(
            out, count, [](double v) { return sdk::exp(v); }, Each{at[step.from[0]]});
      case Code::expm1:
        return loop(
            out, count, [](double v) { return sdk::expm1(v); }, Each{at[step.from[0]]});
      case Code::expm1_slope:
        return loop(
            out, count, [](double v) { return sdk::detail::expm1_and_exp(v).value; }, Each{at[step.from[0]]});
      case Code::expm1_and_slope:
        return expm1_and_slope(at[step.from[0]], out, const_cast<double*>(at[step.also]), count);
      case Code::log:
        return loop(
            out, count, [](double v) { return sdk::log(v); }, Each{at[step.from[0]]});
      case Code::log1p:
        return loop(
            out, count, [](double v) { return sdk::log1p(v); }, Each{at[step.from[0]]});
      case Code::log10:
        return loop(
            out, count, [](double v) { return sdk::log10(v); }, Each{at[step.from[0]]});
      case Code::sin:
        return loop(
            out, count, [](double v) { return sdk::sin(v); }, Each{at[step.from[0]]});
      case Code::cos:
        return loop(
            out, count, [](double v) { return sdk::cos(v); }, Each{at[step.from[0]]});
      case Code::tan:
        return loop(
            out, count, [](double v) { return sdk::tan(v); }, Each{at[step.from[0]]});
      case Code::asin:
        return loop(
            out, count, [](double v) { return sdk::asin(v); }, Each{at[step.from[0]]});
      case Code::acos:
        return loop(
            out, count, [](double v) { return sdk::acos(v); }, Each{at[step.from[0]]});
      case Code::atan:
        return loop(
            out, count, [](double v) { return sdk::atan(v); }, Each{at[step.from[0]]});
      case Code::sinh:
        return loop(
            out, count, [](double v) { return sdk::sinh(v); }, Each{at[step.from[0]]});
      case Code::cosh:
        return loop(
            out, count, [](double v) { return sdk::cosh(v); }, Each{at[step.from[0]]});
      case Code::tanh:
        return loop(
            out, count, [](double v) { return sdk::tanh(v); }, Each{at[step.from[0]]});
      case Code::erf:
        return loop(
            out, count, [](double v) { return sdk::erf(v); }, Each{at[step.from[0]]});
      case Code::power:
        return with<2>(step, at, varies, count, [](double v, double w) { return sdk::pow(v, w); });
      case Code::hypot:
        return with<2>(step, at, varies, count, [](double v, double w) { return sdk::hypot(v, w); });
      case Code::atan2:
        return with<2>(step, at, varies, count, [](double v, double w) { return sdk::atan2(v, w); });
      case Code::curve:
      case Code::curve_slope:
      case Code::curve_bend:
        return curves->evaluate(step.index, static_cast<unsigned>(step.code) - static_cast<unsigned>(Code::curve),
                                at[step.from[0]], out, count);
    }
  }
};

}  // namespace

void run(const Program& program, const Batch& batch, double* const* outputs) {
  // Sums and products of memory are as fast as that is: broader registers read and write it no faster, and their loops
  // take longer to begin and to end.
  const bool may_be_broad = program.has_functions || batch.instruction_set != SPRINGNET_AVX512;
  const std::uint32_t set = may_be_broad ? batch.instruction_set : std::uint32_t{SPRINGNET_AVX2};
  sdk::detail::run<Machine>(Call{program, batch, outputs, set});
}

}  // namespace springnet::formula
