#include "formula/element.hpp"

#include <memory>

namespace springnet::formula {
namespace {

// f(x) by a curve's value and slope.
template <std::size_t N>
sdk::Dual<N> curve_at(const Curves& curves, std::uint32_t table, unsigned order, const sdk::Dual<N>& x) {
  double value = 0.0, slope = 0.0;
  curves.evaluate(table, order, &x.value, &value, 1);
  if (order < 2) curves.evaluate(table, order + 1, &x.value, &slope, 1);
  return sdk::detail::chain(x, value, slope);
}

template <std::size_t N>
sdk::Dual<N> step_of(const ProgramStep& step, const sdk::Dual<N>* at, const Curves& curves) {
  using Number = sdk::Dual<N>;
  const Number &a = at[step.from[0]], &b = at[step.from[1]], &c = at[step.from[2]], &d = at[step.from[3]];
  const auto number = [](bool condition) { return Number(condition ? 1.0 : 0.0); };
  switch (step.code) {
    case Code::constant:
    case Code::input:
    case Code::expm1_and_slope:  // two results
      break;
    case Code::negative:
      return -a;
    case Code::sum:
      return a + b;
    case Code::difference:
      return a - b;
    case Code::product:
      return a * b;
    case Code::quotient:
      return a / b;
    case Code::less:
      return number(a < b);
    case Code::less_or_equal:
      return number(a <= b);
    case Code::equal:
      return number(a == b);
    case Code::both:
      return number(a.value != 0.0 && b.value != 0.0);
    case Code::either:
      return number(a.value != 0.0 || b.value != 0.0);
    case Code::negation:
      return number(a.value == 0.0);
    case Code::choose:
      return a.value != 0.0 ? b : c;
    case Code::absolute:
      return sdk::abs(a);
    case Code::floor:
      return sdk::floor(a);
    case Code::ceil:
      return sdk::ceil(a);
    case Code::sqrt:
      return sdk::sqrt(a);
    case Code::cbrt:
      return sdk::cbrt(a);
    case Code::exp:
      return sdk::exp(a);
    case Code::expm1:
      return sdk::expm1(a);
    case Code::expm1_slope:
      return sdk::detail::expm1_and_exp(a).value;
    case Code::log:
      return sdk::log(a);
    case Code::log1p:
      return sdk::log1p(a);
    case Code::log10:
      return sdk::log10(a);
    case Code::sin:
      return sdk::sin(a);
    case Code::cos:
      return sdk::cos(a);
    case Code::tan:
      return sdk::tan(a);
    case Code::asin:
      return sdk::asin(a);
    case Code::acos:
      return sdk::acos(a);
    case Code::atan:
      return sdk::atan(a);
    case Code::sinh:
      return sdk::sinh(a);
    case Code::cosh:
      return sdk::cosh(a);
    case Code::tanh:
      return sdk::tanh(a);
    case Code::erf:
      return sdk::erf(a);
    case Code::product_sum:
      return a * b + c;
    case Code::product_difference:
      return a * b - c;
    case Code::difference_product:
      return c - a * b;
    case Code::product_product:
      return a * b * c;
    case Code::product_product_sum:
      return a * b * c + d;
    case Code::product_sum_product:
      return (a * b + c) * d;
    case Code::sum_of_products:
      return a * b + c * d;
    case Code::sum_of_longer_products:
      return a * b * c + d * at[step.from[4]];
    case Code::products_difference:
      return a * b - c * d;
    case Code::power:
      return sdk::pow(a, b);
    case Code::hypot:
      return sdk::hypot(a, b);
    case Code::atan2:
      return sdk::atan2(a, b);
    case Code::curve:
    case Code::curve_slope:
    case Code::curve_bend:
      return curve_at(curves, step.index, static_cast<unsigned>(step.code) - static_cast<unsigned>(Code::curve), a);
  }
  return Number();
}

}  // namespace

template <std::size_t N>
void evaluate_element(const Program& program, const Curves& curves, const sdk::Dual<N>* columns,
                      sdk::Dual<N>* outputs) {
  using Number = sdk::Dual<N>;
  // Not initialised: each place is written before it is read.
  alignas(Number) std::byte memory[max_element_places * sizeof(Number)];
  auto* const at = reinterpret_cast<Number*>(memory);
  const auto put = [at](std::size_t place, const Number& number) { std::construct_at(at + place, number); };
  for (std::size_t k = 0; k < program.inputs.size(); ++k) put(k, columns[program.inputs[k]]);
  for (std::size_t k = 0; k < program.constants.size(); ++k)
    put(program.first_constant() + k, Number(program.constants[k]));
  for (const ProgramStep& step : program.steps) {
    if (step.code == Code::expm1_and_slope) {
      const auto both = sdk::detail::expm1_and_exp(at[step.from[0]]);
      put(step.to, both.less_1);
      put(step.also, both.value);
    } else {
      put(step.to, step_of(step, at, curves));
    }
  }
  for (std::size_t k = 0; k < program.outputs.size(); ++k) outputs[k] = at[program.outputs[k]];
}

template void evaluate_element(const Program&, const Curves&, const sdk::Dual<0>*, sdk::Dual<0>*);
template void evaluate_element(const Program&, const Curves&, const sdk::Dual<1>*, sdk::Dual<1>*);
template void evaluate_element(const Program&, const Curves&, const sdk::Dual<2>*, sdk::Dual<2>*);
template void evaluate_element(const Program&, const Curves&, const sdk::Dual<3>*, sdk::Dual<3>*);
template void evaluate_element(const Program&, const Curves&, const sdk::Dual<4>*, sdk::Dual<4>*);
template void evaluate_element(const Program&, const Curves&, const sdk::Dual<5>*, sdk::Dual<5>*);
template void evaluate_element(const Program&, const Curves&, const sdk::Dual<6>*, sdk::Dual<6>*);

}  // namespace springnet::formula
