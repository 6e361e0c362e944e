// The loops of springnet_law::evaluate: forces; forces and their tangent; any other derivatives, some at a time. Each
// loop evaluates a formula once for an element, whatever it writes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <springnet/sdk/law/batch.hpp>

namespace springnet::sdk {

// Derivatives that one evaluation carries, of those beyond the tangent.
inline constexpr std::size_t derivatives_at_a_time = 4;

namespace detail {

// The argument of a law's formulas with the number `column` of its Jacobian, or null if it does not read it.
template <class Law, std::size_t column, class Arguments>
SPRINGNET_INLINE auto* argument_of(Arguments& a) {
  using Traits = LawTraits<Law>;
  constexpr JacobianLayout layout = Traits::jacobian;
  constexpr std::size_t V = Traits::invariant_count;
  if constexpr (column < layout.rate()) {
    if constexpr (Traits::reads_value(column))
      return &a.q(column);
    else
      return static_cast<decltype(&a.reference(0))>(nullptr);
  } else if constexpr (column < layout.reference()) {
    if constexpr (Traits::reads_rate && Traits::reads_value(column - V))
      return &a.rate(column - V);
    else
      return static_cast<decltype(&a.reference(0))>(nullptr);
  } else if constexpr (column < layout.parameter(0)) {
    return &a.reference(column - layout.reference());
  } else if constexpr (column < layout.state(0)) {
    return &a.parameters[column - layout.parameter(0)];
  } else if constexpr (column < layout.input(0)) {
    return &a.states[column - layout.state(0)];
  } else if constexpr (column < layout.time()) {
    return &a.inputs[column - layout.input(0)];
  } else if constexpr (column == layout.time()) {
    if constexpr (Law::reads_time)
      return &a.element.time;
    else
      return static_cast<decltype(&a.reference(0))>(nullptr);
  } else {
    if constexpr (Law::reads_direction)
      return &a.element.direction[column - layout.direction(0)];
    else
      return static_cast<decltype(&a.reference(0))>(nullptr);
  }
}

}  // namespace detail

template <class Law>
class LawKernel {
  using Traits = LawTraits<Law>;
  using Chunk = detail::LawChunk<Law>;
  using Varying = detail::Varying;
  template <Varying varying>
  using Kind = std::integral_constant<Varying, varying>;
  template <class Real>
  using Arguments = detail::LawArguments<Law, Real>;
  static constexpr std::size_t V = Traits::invariant_count;
  static constexpr std::size_t P = Traits::parameter_count;
  static constexpr std::size_t S = Traits::state_count;
  static constexpr JacobianLayout layout = Traits::jacobian;
  static constexpr std::size_t columns = layout.columns(false);

 public:
  struct Call {
    const Law* law;
    const springnet_law_batch* batch;
    std::uint32_t instruction_set;
  };
  SPRINGNET_INLINE static void run(const Call& call) {
    const springnet_law_batch& b = *call.batch;
    const Wanted wanted(b);
    // Formulas over several invariants are long: compiled for one kind of chunks alone.
    using detail::Kinds;
    if (wanted.plain)
      detail::for_each_chunk<Traits::several ? Kinds::all : Kinds::each>(
          *call.law, b, [&](const Chunk& chunk, auto kind) { evaluate(b, wanted, chunk, kind); });
    if (wanted.rest)
      detail::for_each_chunk<Traits::several ? Kinds::all : Kinds::reference_and_all>(
          *call.law, b, [&](const Chunk& chunk, auto kind) { rest(b, chunk, kind); });
  }

 private:
  struct Force {
    template <class Real>
    SPRINGNET_INLINE static std::array<Real, V> of(const Law& law, const Arguments<Real>& a) {
      return detail::forces_of<Law>(law, a);
    }
  };
  struct EnergyValue {
    template <class Real>
    SPRINGNET_INLINE static std::array<Real, 1> of(const Law& law, const Arguments<Real>& a) {
      return {law.energy(a.element, a.values())};
    }
  };
  struct MarginValue {
    template <class Real>
    SPRINGNET_INLINE static std::array<Real, 1> of(const Law& law, const Arguments<Real>& a) {
      return {law.margin(a.element, a.values())};
    }
  };
  struct Rates {
    template <class Real>
    SPRINGNET_INLINE static std::array<Real, S> of(const Law& law, const Arguments<Real>& a) {
      return law.state_rates(a.element, a.values());
    }
  };

  // What is asked for, beside single outputs.
  struct Wanted {
    bool tangent, plain, rest;
    explicit Wanted(const springnet_law_batch& b) {
      const bool forces = Traits::several ? detail::any(b.forces, V) : b.force != nullptr;
      // Of a law over several invariants its columns are those of the values, and of their rates if it reads these.
      tangent = Traits::several ? detail::any_column(b.derivatives, V, columns, 0, tangent_columns)
                                : b.force_by_q != nullptr || b.force_by_rate != nullptr;
      plain = forces || tangent || b.energy != nullptr || b.margin != nullptr;
      constexpr std::size_t first = Traits::several ? tangent_columns : 0;
      rest = detail::any_column(b.derivatives, layout.rows(), columns, first, columns - first);
      if (Traits::several && b.derivatives != nullptr)
        rest = rest || detail::any_column(b.derivatives + V * columns, layout.rows() - V, columns, 0, first);
      if constexpr (!Traits::several) rest = rest || detail::any(b.force_by_parameters, P) || b.energy_by_q != nullptr;
      if constexpr (S > 0)
        rest = rest || detail::any(b.state_rates, S) || detail::any(b.rates_by_q, S) ||
               detail::any(b.rates_by_rate, S) || detail::any(b.rates_by_states, S * S) ||
               detail::any(b.rates_by_parameters, S * P) || detail::any(b.force_by_states, S) ||
               detail::any(b.energy_by_states, S);
    }
  };
  static constexpr std::size_t tangent_columns = Traits::reads_rate ? 2 * V : V;

  template <class Quantity, Varying varying>
  SPRINGNET_INLINE static void value(const Chunk& c, Kind<varying> kind, double* array) {
    double* __restrict out = array + c.begin;
    const auto fixed = detail::constants_of<varying>(c);
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const Arguments<Dual<0>> a(c, fixed, i, kind);
      out[i] = Quantity::of(*c.law, a)[0].value;
    }
  }
  // Of a law over one invariant: its force, dQ/dq, and dQ/dq' if it reads that; each may be null.
  template <Varying varying>
  SPRINGNET_INLINE static void force_and_tangent(const Chunk& c, Kind<varying> kind, double* force, double* by_q,
                                                 double* by_rate) {
    double unwanted[3][detail::chunk_size];
    const auto to = [&](double* array, std::size_t sink) {
      return array != nullptr ? array + c.begin : unwanted[sink];
    };
    double* __restrict out = to(force, 0);
    double* __restrict out_q = to(by_q, 1);
    constexpr std::size_t N = Traits::reads_rate ? 2 : 1;
    [[maybe_unused]] double* __restrict out_rate = to(by_rate, 2);
    const auto fixed = detail::constants_of<varying>(c);
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::uint32_t i = 0; i < c.count; ++i) {
      Arguments<Dual<N>> a(c, fixed, i, kind);
      a.q(0).derivatives[0] = 1.0;
      if constexpr (Traits::reads_rate) a.rate(0).derivatives[1] = 1.0;
      const Dual<N> result = detail::forces_of<Law>(*c.law, a)[0];
      out[i] = result.value;
      out_q[i] = result.derivatives[0];
      if constexpr (Traits::reads_rate) out_rate[i] = result.derivatives[1];
    }
    if (!Traits::reads_rate && by_rate != nullptr) std::fill_n(by_rate + c.begin, c.count, 0.0);
  }

  // Derivatives of a quantity by `width` columns from `first` on, and its values if asked for, in one loop:
  // to_value(row), to(row, column) are where they go, or null.
  template <class Quantity, std::size_t rows, std::size_t first, std::size_t width, bool with_values, Varying varying,
            class ToValue, class To>
  SPRINGNET_INLINE static void derivatives(const Chunk& c, Kind<varying> kind, const ToValue& to_value, const To& to) {
    using Real = Dual<width>;
    double unwanted[detail::chunk_size];
    std::array<double*, rows> values;
    std::array<std::array<double*, width>, rows> out;
    const auto or_unwanted = [&](double* array) { return array != nullptr ? array : unwanted; };
    for (std::size_t row = 0; row < rows; ++row) {
      values[row] = with_values ? or_unwanted(to_value(row)) : nullptr;
      for (std::size_t k = 0; k < width; ++k) out[row][k] = or_unwanted(to(row, first + k));
    }
    const auto fixed = detail::constants_of<varying>(c);
    const std::uint32_t count = c.count;
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::uint32_t i = 0; i < count; ++i) {
      Arguments<Real> a(c, fixed, i, kind);
      detail::unrolled<width>([&](auto k) {
        if (auto* argument = detail::argument_of<Law, first + k.value>(a)) argument->derivatives[k.value] = 1.0;
      });
      const std::array<Real, rows> result = Quantity::of(*c.law, a);
      detail::unrolled<rows>([&](auto row) {
        if constexpr (with_values) values[row][i] = result[row].value;
        detail::unrolled<width>([&](auto k) { out[row][k][i] = result[row].derivatives[k]; });
      });
    }
  }
  // Columns that one evaluation carries: some at a time, of one kind. What depends on other kinds alone is a constant
  // then, which costs nothing; and gradients ask for parameters alone.
  struct Groups {
    std::array<std::size_t, columns + 1> begin;
    std::size_t count;
  };
  static constexpr Groups groups_of(std::size_t first, std::size_t last) {
    Groups groups{};
    for (std::size_t column = first; column < last;) {
      groups.begin[groups.count++] = column;
      std::size_t end = std::min(last, column + derivatives_at_a_time);
      for (const std::size_t border : {layout.parameter(0), layout.state(0), layout.time(), layout.direction(0)})
        if (column < border) end = std::min(end, border);
      for (const std::size_t border : {layout.rate(), layout.reference()})
        if (Traits::several && column < border) end = std::min(end, border);
      column = end;
    }
    groups.begin[groups.count] = last;
    return groups;
  }
  // Whether a formula can depend on one of the columns, all of one kind, from `column` on.
  static constexpr bool reads(std::size_t column) {
    if (column >= layout.direction(0)) return Law::reads_direction;
    if (column >= layout.time()) return Law::reads_time;
    return !Traits::several || Traits::reads_rate || column < layout.rate() || column >= layout.reference();
  }
  // All columns from `first` to before `last` of a quantity, some at a time, as far as `to` asks for them, and with the
  // first of them its values.
  template <class Quantity, std::size_t rows, std::size_t first, std::size_t last, bool with_values, Varying varying,
            class ToValue, class To>
  SPRINGNET_INLINE static void columns_of(const Chunk& c, Kind<varying> kind, const ToValue& to_value, const To& to) {
    constexpr Groups groups = groups_of(first, last);
    bool values_wanted = false;
    for (std::size_t row = 0; with_values && row < rows; ++row)
      values_wanted = values_wanted || to_value(row) != nullptr;
    detail::unrolled<groups.count>([&](auto group) {
      constexpr std::size_t begin = groups.begin[group.value];
      constexpr std::size_t width = groups.begin[group.value + 1] - begin;
      bool wanted = false;
      for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t k = 0; k < width; ++k) wanted = wanted || to(row, begin + k) != nullptr;
      if (!wanted) return;
      if constexpr (reads(begin)) {
        derivatives<Quantity, rows, begin, width, with_values && group.value == 0>(c, kind, to_value, to);
        if (group.value == 0) values_wanted = false;
      } else {
        for (std::size_t row = 0; row < rows; ++row)
          for (std::size_t k = 0; k < width; ++k)
            if (double* const zeros = to(row, begin + k)) std::fill_n(zeros, c.count, 0.0);
      }
    });
    if constexpr (with_values)
      if (values_wanted) derivatives<Quantity, rows, first, 0, true>(c, kind, to_value, to);
  }

  // Forces, the tangent, energy and margin.
  template <Varying varying>
  SPRINGNET_INLINE static void evaluate(const springnet_law_batch& b, const Wanted& wanted, const Chunk& c,
                                        Kind<varying> kind) {
    if constexpr (Traits::several) {
      const auto to_value = [&](std::size_t row) { return detail::from(b.forces, row, c.begin); };
      if (wanted.tangent) {
        columns_of<Force, V, 0, tangent_columns, true>(c, kind, to_value, [&](std::size_t row, std::size_t column) {
          return detail::from(b.derivatives, row * columns + column, c.begin);
        });
      } else if (detail::any(b.forces, V)) {
        derivatives<Force, V, 0, 0, true>(c, kind, to_value,
                                          [](std::size_t, std::size_t) -> double* { return nullptr; });
      }
    } else if (wanted.tangent) {
      force_and_tangent(c, kind, b.force, b.force_by_q, b.force_by_rate);
    } else if (b.force != nullptr) {
      value<Force>(c, kind, b.force);
    }
    if constexpr (Traits::has_energy) {
      if (b.energy != nullptr) value<EnergyValue>(c, kind, b.energy);
    }
    if constexpr (Traits::has_margin) {
      if (b.margin != nullptr) value<MarginValue>(c, kind, b.margin);
    }
  }

  struct NoValue {
    constexpr double* operator()(std::size_t) const { return nullptr; }
  };
  // Whether a column is one of `count` from `first` on.
  SPRINGNET_INLINE static bool is_among(std::size_t column, std::size_t first, std::size_t count) {
    return column - first < count;
  }
  // All other derivatives, from the matrix of a batch and from the arrays that laws over one invariant have for some.
  template <Varying varying>
  SPRINGNET_INLINE static void rest(const springnet_law_batch& b, const Chunk& c, Kind<varying> kind) {
    const auto at = [&](std::size_t row, std::size_t column) {
      return detail::from(b.derivatives, row * columns + column, c.begin);
    };
    constexpr NoValue no_value;
    quantity<Force, V, 0>(c, kind, no_value, at, [&](std::size_t, std::size_t column) -> double* {
      if (Traits::several) return nullptr;
      if (is_among(column, layout.parameter(0), P))
        return detail::from(b.force_by_parameters, column - layout.parameter(0), c.begin);
      if (is_among(column, layout.state(0), S))
        return detail::from(b.force_by_states, column - layout.state(0), c.begin);
      return nullptr;
    });
    if constexpr (Traits::has_energy)
      quantity<EnergyValue, 1, layout.energy()>(c, kind, no_value, at, [&](std::size_t, std::size_t column) -> double* {
        if (Traits::several) return nullptr;
        if (column == layout.value()) return b.energy_by_q == nullptr ? nullptr : b.energy_by_q + c.begin;
        if (is_among(column, layout.state(0), S))
          return detail::from(b.energy_by_states, column - layout.state(0), c.begin);
        return nullptr;
      });
    if constexpr (Traits::has_margin)
      quantity<MarginValue, 1, layout.margin()>(c, kind, no_value, at,
                                                [](std::size_t, std::size_t) -> double* { return nullptr; });
    if constexpr (S > 0)
      quantity<Rates, S, layout.state_row(0)>(
          c, kind, [&](std::size_t row) { return detail::from(b.state_rates, row, c.begin); }, at,
          [&](std::size_t row, std::size_t column) -> double* {
            if (!Traits::several && column == layout.value()) return detail::from(b.rates_by_q, row, c.begin);
            if (!Traits::several && column == layout.rate()) return detail::from(b.rates_by_rate, row, c.begin);
            if (is_among(column, layout.parameter(0), P))
              return detail::from(b.rates_by_parameters, row * P + column - layout.parameter(0), c.begin);
            if (is_among(column, layout.state(0), S))
              return detail::from(b.rates_by_states, row * S + column - layout.state(0), c.begin);
            return nullptr;
          });
  }
  // The rows of a quantity, which begin with row `row_0` of the matrix. Where `also` names an array of its own for a
  // derivative, that one gets it; if both do, the matrix's array gets a copy.
  template <class Quantity, std::size_t rows, std::size_t row_0, Varying varying, class ToValue, class At, class Also>
  SPRINGNET_INLINE static void quantity(const Chunk& c, Kind<varying> kind, const ToValue& to_value, const At& at,
                                        const Also& also) {
    constexpr bool is_several_forces = Traits::several && row_0 == 0;
    constexpr std::size_t first = is_several_forces ? tangent_columns : 0;  // the tangent's have been done
    constexpr bool with_values = !std::is_same_v<ToValue, NoValue>;
    columns_of<Quantity, rows, first, columns, with_values>(c, kind, to_value,
                                                            [&](std::size_t row, std::size_t column) {
                                                              double* const own = also(row, column);
                                                              return own != nullptr ? own : at(row_0 + row, column);
                                                            });
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t column = first; column < columns; ++column) {
        const double* const own = also(row, column);
        double* const copy = at(row_0 + row, column);
        if (own != nullptr && copy != nullptr && own != copy) std::copy_n(own, c.count, copy);
      }
    }
  }
};

}  // namespace springnet::sdk
