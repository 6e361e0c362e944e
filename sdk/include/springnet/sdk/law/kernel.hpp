// The loops of springnet_law::evaluate.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <springnet/sdk/law/batch.hpp>

namespace springnet::sdk {

template <class Law>
class LawKernel {
  using Traits = LawTraits<Law>;
  using Chunk = detail::LawChunk<Law>;
  using Varying = detail::Varying;
  template <Varying varying>
  using Kind = std::integral_constant<Varying, varying>;
  template <class Real>
  using Arguments = detail::LawArguments<Law, Real>;
  static constexpr std::size_t P = Traits::parameter_count;
  static constexpr std::size_t S = Traits::state_count;

 public:
  struct Call {
    const Law* law;
    const springnet_law_batch* batch;
    std::uint32_t instruction_set;
  };
  SPRINGNET_INLINE static void run(const Call& call) {
    const springnet_law_batch& b = *call.batch;
    detail::for_each_chunk(*call.law, b, [&](const Chunk& chunk, auto kind) { evaluate(b, chunk, kind); });
  }

 private:
  struct Force {
    template <class Real>
    SPRINGNET_INLINE static Real of(const Law& law, const Arguments<Real>& a) {
      return law.force(a.element, a.values());
    }
  };
  struct EnergyValue {
    template <class Real>
    SPRINGNET_INLINE static Real of(const Law& law, const Arguments<Real>& a) {
      return law.energy(a.element, a.values());
    }
  };
  struct MarginValue {
    template <class Real>
    SPRINGNET_INLINE static Real of(const Law& law, const Arguments<Real>& a) {
      return law.margin(a.element, a.values());
    }
  };

  template <class Quantity, Varying varying>
  SPRINGNET_INLINE static void values(const Chunk& c, Kind<varying> kind, double* array) {
    double* __restrict out = array + c.begin;
    const auto fixed = detail::constants_of<varying>(c);
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const Arguments<Dual<0>> a(c, fixed, i, kind);
      out[i] = Quantity::of(*c.law, a).value;
    }
  }
  // dQ/dq, and dQ/dq' for a law that reads it; either output may be null.
  template <Varying varying>
  SPRINGNET_INLINE static void derivatives(const Chunk& c, Kind<varying> kind, double* by_q, double* by_rate) {
    double unwanted[detail::chunk_size];
    double* __restrict out_q = by_q != nullptr ? by_q + c.begin : unwanted;
    const auto fixed = detail::constants_of<varying>(c);
    if constexpr (Traits::reads_rate) {
      double unwanted_too[detail::chunk_size];
      double* __restrict out_rate = by_rate != nullptr ? by_rate + c.begin : unwanted_too;
      for (std::uint32_t i = 0; i < c.count; ++i) {
        Arguments<Dual<2>> a(c, fixed, i, kind);
        a.element.q.derivatives[0] = 1.0;
        a.element.rate.derivatives[1] = 1.0;
        const Dual<2> force = c.law->force(a.element, a.values());
        out_q[i] = force.derivatives[0];
        out_rate[i] = force.derivatives[1];
      }
    } else {
      if (by_rate != nullptr) std::fill_n(by_rate + c.begin, c.count, 0.0);
      if (by_q == nullptr) return;
      for (std::uint32_t i = 0; i < c.count; ++i) {
        Arguments<Dual<1>> a(c, fixed, i, kind);
        a.element.q.derivatives[0] = 1.0;
        const Dual<1> force = c.law->force(a.element, a.values());
        out_q[i] = force.derivatives[0];
      }
    }
  }
  // Of force or energy by one argument, which `argument(arguments)` returns.
  template <class Quantity, Varying varying, class Argument>
  SPRINGNET_INLINE static void derivative_by(const Chunk& c, Kind<varying> kind, double* array,
                                             const Argument& argument) {
    double* __restrict out = array + c.begin;
    const auto fixed = detail::constants_of<varying>(c);
    for (std::uint32_t i = 0; i < c.count; ++i) {
      Arguments<Dual<1>> a(c, fixed, i, kind);
      argument(a).derivatives[0] = 1.0;
      out[i] = Quantity::of(*c.law, a).derivatives[0];
    }
  }
  template <class Quantity, Varying varying>
  SPRINGNET_INLINE static void by_states(const Chunk& c, Kind<varying> kind, double* const* arrays) {
    if constexpr (S > 0) {
      for (std::size_t j = 0; arrays != nullptr && j < S; ++j)
        if (arrays[j] != nullptr)
          derivative_by<Quantity>(
              c, kind, arrays[j], [j](auto& a) -> auto& { return a.states[j]; });
    }
  }

  // Rates of the states, and their derivatives by q, its rate, states and parameters.
  template <Varying varying>
  SPRINGNET_INLINE static void rates(const springnet_law_batch& b, const Chunk& c, Kind<varying> kind) {
    const auto fixed = detail::constants_of<varying>(c);
    if (detail::any(b.state_rates, S)) {
      for (std::uint32_t i = 0; i < c.count; ++i) {
        const Arguments<Dual<0>> a(c, fixed, i, kind);
        const std::array<Dual<0>, S> rates = c.law->state_rates(a.element, a.values());
        for (std::size_t j = 0; j < S; ++j)
          if (b.state_rates[j] != nullptr) b.state_rates[j][c.begin + i] = rates[j].value;
      }
    }
    const auto by = [&](double* const* lists, std::size_t row, std::size_t column, const auto& argument) {
      bool wanted = false;
      for (std::size_t s = 0; lists != nullptr && s < S; ++s) wanted = wanted || lists[s * row + column] != nullptr;
      if (!wanted) return;
      for (std::uint32_t i = 0; i < c.count; ++i) {
        Arguments<Dual<1>> a(c, fixed, i, kind);
        argument(a).derivatives[0] = 1.0;
        const std::array<Dual<1>, S> rates = c.law->state_rates(a.element, a.values());
        for (std::size_t s = 0; s < S; ++s)
          if (double* out = detail::from(lists, s * row + column, c.begin)) out[i] = rates[s].derivatives[0];
      }
    };
    by(
        b.rates_by_q, 1, 0, [](auto& a) -> auto& { return a.element.q; });
    if constexpr (Traits::reads_rate) {
      by(
          b.rates_by_rate, 1, 0, [](auto& a) -> auto& { return a.element.rate; });
    } else {
      for (std::size_t s = 0; s < S; ++s)
        if (double* out = detail::from(b.rates_by_rate, s, c.begin)) std::fill_n(out, c.count, 0.0);
    }
    for (std::size_t j = 0; j < S; ++j)
      by(
          b.rates_by_states, S, j, [j](auto& a) -> auto& { return a.states[j]; });
    if constexpr (P > 0) {
      for (std::size_t j = 0; j < P; ++j)
        by(
            b.rates_by_parameters, P, j, [j](auto& a) -> auto& { return a.parameters[j]; });
    }
  }

  template <Varying varying>
  SPRINGNET_INLINE static void evaluate(const springnet_law_batch& b, const Chunk& c, Kind<varying> kind) {
    if (b.force != nullptr) values<Force>(c, kind, b.force);
    if constexpr (Traits::has_energy) {
      if (b.energy != nullptr) values<EnergyValue>(c, kind, b.energy);
      if (b.energy_by_q != nullptr)
        derivative_by<EnergyValue>(
            c, kind, b.energy_by_q, [](auto& a) -> auto& { return a.element.q; });
      by_states<EnergyValue>(c, kind, b.energy_by_states);
    }
    if constexpr (Traits::has_margin) {
      if (b.margin != nullptr) values<MarginValue>(c, kind, b.margin);
    }
    if (b.force_by_q != nullptr || b.force_by_rate != nullptr) derivatives(c, kind, b.force_by_q, b.force_by_rate);
    if constexpr (P > 0) {
      for (std::size_t j = 0; b.force_by_parameters != nullptr && j < P; ++j)
        if (b.force_by_parameters[j] != nullptr)
          derivative_by<Force>(
              c, kind, b.force_by_parameters[j], [j](auto& a) -> auto& { return a.parameters[j]; });
    }
    if constexpr (S > 0) {
      by_states<Force>(c, kind, b.force_by_states);
      rates(b, c, kind);
    }
  }
};

}  // namespace springnet::sdk
