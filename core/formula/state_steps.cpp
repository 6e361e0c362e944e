// Steps of internal states of formulas: by the SDK's loops for laws (sdk/law/update.hpp), with a law whose formulas are
// read from the programs. Its numbers of parameters and inputs are fixed; a batch is passed on with those that are not
// there as zeros.
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <springnet/sdk/law.hpp>

#include "formula/element.hpp"
#include "formula/law.hpp"

namespace springnet {
namespace formula {
namespace {

constexpr std::size_t P = max_parameters_beside_states, I = max_inputs_beside_states;

// Bounds and scales of the states of the law whose step the thread makes.
thread_local std::span<const sdk::Parameter> states_of_step;

template <std::size_t count>
constexpr std::array<sdk::Parameter, count> numbers() {
  std::array<sdk::Parameter, count> result{};
  for (sdk::Parameter& each : result) each = sdk::number("x", "1", "").preset(0);
  return result;
}

// smooth: the law declares smooth_rates.
template <std::size_t S, bool smooth>
struct Stepped : sdk::SpringFunction {
  using has = sdk::Has<sdk::Energy, sdk::Margin>;
  static constexpr const char *id = "formula", *summary = "";
  static constexpr bool reads_rate = true, reads_time = true, smooth_rates = smooth;
  static constexpr std::array<sdk::Parameter, P> parameters = numbers<P>();
  static constexpr std::array<sdk::Parameter, I> inputs = numbers<I>();
  static constexpr std::array<sdk::Parameter, S> states = numbers<S>();
  static constexpr sdk::JacobianLayout layout{1, P, S, I};

  const Law* law = nullptr;

  // What a program answers for an element; its inputs are columns of the law's own layout.
  template <std::size_t count, std::size_t N>
  std::array<sdk::Dual<N>, count> of(const Program& program, const sdk::Element<sdk::Dual<N>>& e,
                                     const sdk::Parameters<sdk::Dual<N>>& p) const {
    using Number = sdk::Dual<N>;
    const sdk::JacobianLayout& own = law->layout();
    std::array<Number, layout.columns(false)> columns;
    for (const std::uint32_t column : program.inputs) {
      Number& to = columns[column];
      if (column == own.value())
        to = e.q;
      else if (column == own.rate())
        to = e.rate;
      else if (column == own.reference())
        to = e.reference;
      else if (column < own.state(0))
        to = p[column - own.parameter(0)];
      else if (column < own.input(0))
        to = e.state(column - own.state(0));
      else if (column < own.time())
        to = e.input(column - own.input(0));
      else
        to = e.time;
    }
    std::array<Number, count> results;
    evaluate_element(program, law->curves(), columns.data(), results.data());
    return results;
  }
  template <std::size_t N>
  sdk::Dual<N> force(const sdk::Element<sdk::Dual<N>>& e, const sdk::Parameters<sdk::Dual<N>>& p) const {
    return of<1>(law->force(), e, p)[0];
  }
  template <std::size_t N>
  sdk::Dual<N> energy(const sdk::Element<sdk::Dual<N>>& e, const sdk::Parameters<sdk::Dual<N>>& p) const {
    return of<1>(law->energy(), e, p)[0];
  }
  template <std::size_t N>
  sdk::Dual<N> margin(const sdk::Element<sdk::Dual<N>>& e, const sdk::Parameters<sdk::Dual<N>>& p) const {
    return of<1>(law->margin(), e, p)[0];
  }
  template <std::size_t N>
  std::array<sdk::Dual<N>, S> state_rates(const sdk::Element<sdk::Dual<N>>& e,
                                          const sdk::Parameters<sdk::Dual<N>>& p) const {
    return of<S>(law->rates(), e, p);
  }
};

// The traits of a law whose states are as its class declares them.
template <std::size_t S, bool smooth>
struct AsDeclared : Stepped<S, smooth> {};

}  // namespace
}  // namespace formula

// Those of a formula, whose states have bounds of their own.
template <std::size_t S, bool smooth>
struct sdk::LawTraits<formula::Stepped<S, smooth>> : sdk::LawTraits<formula::AsDeclared<S, smooth>> {
  struct StateList {
    static std::span<const Parameter> get() { return formula::states_of_step; }
  };
};

namespace formula {
namespace {

// The same update with fixed numbers of parameters and inputs.
template <std::size_t S>
class Widened {
 public:
  Widened(const springnet_law_update& given, const sdk::JacobianLayout& own) : batch_(*given.batch), update_(given) {
    static constexpr double zero = 0.0;
    const springnet_law_batch& from = *given.batch;
    parameters_.fill(&zero);
    inputs_.fill(&zero);
    start_inputs_.fill(&zero);
    std::copy_n(from.parameters, own.parameters, parameters_.begin());
    std::copy_n(from.parameter_strides, own.parameters, parameter_strides_.begin());
    if (own.inputs > 0) {
      std::copy_n(from.inputs, own.inputs, inputs_.begin());
      std::copy_n(from.input_strides, own.inputs, input_strides_.begin());
      if (given.start_inputs != nullptr) std::copy_n(given.start_inputs, own.inputs, start_inputs_.begin());
    }
    batch_.parameters = parameters_.data();
    batch_.parameter_strides = parameter_strides_.data();
    batch_.inputs = inputs_.data();
    batch_.input_strides = input_strides_.data();
    if (from.rate == nullptr) {
      rates_.assign(from.count, 0.0);
      batch_.rate = rates_.data();
    }
    if (from.force_by_parameters != nullptr) {
      std::copy_n(from.force_by_parameters, own.parameters, by_parameters_.begin());
      batch_.force_by_parameters = by_parameters_.data();
    }
    constexpr sdk::JacobianLayout wide = Stepped<S, false>::layout;
    if (from.derivatives != nullptr) {
      matrix_.assign(wide.rows() * wide.columns(true), nullptr);
      for (std::size_t row = 0; row < own.rows(); ++row)
        for (std::size_t column = 0; column < own.columns(true); ++column)
          matrix_[row * wide.columns(true) + widened(column, own)] = from.derivatives[row * own.columns(true) + column];
      batch_.derivatives = matrix_.data();
    }
    update_.batch = &batch_;
    update_.start_inputs = start_inputs_.data();
    if (given.start_rate == nullptr && given.start_q != nullptr) {
      start_rates_.assign(from.count, 0.0);
      update_.start_rate = start_rates_.data();
    }
    if (given.next_by_parameters != nullptr) {
      for (std::size_t j = 0; j < S; ++j)
        std::copy_n(given.next_by_parameters + j * own.parameters, own.parameters, next_by_parameters_.data() + j * P);
      update_.next_by_parameters = next_by_parameters_.data();
    }
  }
  Widened(const Widened&) = delete;
  Widened& operator=(const Widened&) = delete;
  [[nodiscard]] const springnet_law_update& update() const { return update_; }

 private:
  static std::size_t widened(std::size_t column, const sdk::JacobianLayout& own) {
    constexpr sdk::JacobianLayout wide = Stepped<S, false>::layout;
    if (column < own.state(0)) return column;  // the value, its rate and reference, parameters
    if (column < own.input(0)) return wide.state(column - own.state(0));
    if (column < own.time()) return wide.input(column - own.input(0));
    return wide.time() + (column - own.time());  // the time, the direction, and what is at the start, inputs last
  }

  springnet_law_batch batch_;
  springnet_law_update update_;
  std::array<const double*, P> parameters_;
  std::array<std::uint32_t, P> parameter_strides_{};
  std::array<const double*, I> inputs_, start_inputs_;
  std::array<std::uint32_t, I> input_strides_{};
  std::array<double*, P> by_parameters_{};
  std::array<double*, S * P> next_by_parameters_{};
  std::vector<double> rates_, start_rates_;
  std::vector<double*> matrix_;
};

template <std::size_t S, bool smooth>
bool step(const Law& law, const springnet_law_update& given) {
  const Widened<S> widened(given, law.layout());
  Stepped<S, smooth> stepped;
  stepped.law = &law;
  states_of_step = law.states();
  using Kernel = sdk::UpdateKernel<Stepped<S, smooth>>;
  bool found = true;
  Kernel::run(typename Kernel::Call{&stepped, &widened.update(), SPRINGNET_GENERIC, &found});
  if (found && given.batch->derivatives != nullptr) found = Kernel::run_matrix(stepped, widened.update());
  return found;
}

}  // namespace

bool Law::update(const springnet_law_update& given) const {
  if (layout_.states == 1) return smooth_rates_ ? step<1, true>(*this, given) : step<1, false>(*this, given);
  return smooth_rates_ ? step<2, true>(*this, given) : step<2, false>(*this, given);
}

}  // namespace formula
}  // namespace springnet
