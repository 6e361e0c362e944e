// The elements of a batch, chunk by chunk, and the arguments of a law's formulas for one of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <springnet/sdk/law/traits.hpp>

namespace springnet::sdk::detail {

// What differs between the elements of a batch: springs of one material in a mesh have rest lengths of their own.
enum class Varying { nothing, reference, all };

// Some elements of a batch; arrays begin with the first of them.
template <class Law>
struct LawChunk {
  using Traits = LawTraits<Law>;
  static constexpr std::size_t P = Traits::parameter_count;
  static constexpr std::size_t S = Traits::state_count;
  static constexpr std::size_t I = Traits::input_count;
  static constexpr std::size_t N = 1 + P + I;  // streams
  static constexpr std::size_t V = Traits::invariant_count;
  // Of a law over several invariants; one over one has its reference among the streams.
  static constexpr std::size_t references_count = Traits::several ? V : 0;
  static constexpr std::size_t direction_count = Law::reads_direction ? 3 : 0;

  const Law* law;
  std::uint32_t begin, count;
  std::array<const double*, V> q, rate;
  std::array<const double*, references_count> references;
  std::array<const double*, direction_count> direction;
  double time;
  const typename Traits::Table* table;
  std::array<const double*, S> states;
  std::array<const double*, N> streams;  // reference value, parameters, inputs
};

// The arguments of a formula for one element.
template <class Law, class Real>
struct LawArguments {
  using Traits = LawTraits<Law>;
  using Chunk = LawChunk<Law>;
  std::array<Real, Chunk::P> parameters;
  std::array<Real, Chunk::S> states;
  std::array<Real, Chunk::I> inputs;
  typename Traits::template ElementOf<Real> element;

  template <Varying varying>
  SPRINGNET_INLINE LawArguments(const Chunk& c, const std::array<double, Chunk::N>& constants, std::uint32_t i,
                                std::integral_constant<Varying, varying>)
      : element(unset(*c.table, c.time)) {
    if constexpr (Traits::several) {
      unrolled<Chunk::V>([&](auto j) { element.reference[j] = c.references[j][i]; });
      unrolled<Chunk::direction_count>([&](auto j) { element.direction[j] = c.direction[j][i]; });
    } else {
      element.reference = varying == Varying::nothing ? constants[0] : c.streams[0][i];
    }
    unrolled<Chunk::V>([&](auto j) {
      if constexpr (Traits::reads_value(j)) {
        q(j) = c.q[j][i];
        if constexpr (Traits::reads_rate) rate(j) = c.rate[j][i];
      }
    });
    unrolled<Chunk::P>(
        [&](auto j) { parameters[j] = varying != Varying::all ? constants[1 + j] : c.streams[1 + j][i]; });
    unrolled<Chunk::I>([&](auto j) {
      inputs[j] = varying != Varying::all ? constants[1 + Chunk::P + j] : c.streams[1 + Chunk::P + j][i];
    });
    unrolled<Chunk::S>([&](auto j) { states[j] = c.states[j][i]; });
  }
  // The same arguments, with derivatives by other variables as well.
  template <class Other>
  SPRINGNET_INLINE explicit LawArguments(const LawArguments<Law, Other>& other)
      : element(unset(other.element.table, other.element.time)) {
    unrolled<Chunk::P>([&](auto j) { parameters[j] = other.parameters[j]; });
    unrolled<Chunk::S>([&](auto j) { states[j] = other.states[j]; });
    unrolled<Chunk::I>([&](auto j) { inputs[j] = other.inputs[j]; });
    unrolled<Chunk::V>([&](auto j) {
      q(j) = other.q(j);
      reference(j) = other.reference(j);
      if constexpr (Traits::reads_rate) rate(j) = other.rate(j);
    });
    if constexpr (Law::reads_direction) unrolled<3>([&](auto j) { element.direction[j] = other.element.direction[j]; });
  }
  LawArguments(const LawArguments&) = delete;  // element points into it
  LawArguments& operator=(const LawArguments&) = delete;
  [[nodiscard]] SPRINGNET_INLINE Parameters<Real> values() const { return Parameters<Real>(parameters.data()); }

  // Invariant j, its rate and its reference; a law that names one has j = 0 alone.
  [[nodiscard]] SPRINGNET_INLINE auto& q(std::size_t j) { return entry(element.q, j); }
  [[nodiscard]] SPRINGNET_INLINE const auto& q(std::size_t j) const { return entry(element.q, j); }
  [[nodiscard]] SPRINGNET_INLINE auto& rate(std::size_t j) { return entry(element.rate, j); }
  [[nodiscard]] SPRINGNET_INLINE const auto& rate(std::size_t j) const { return entry(element.rate, j); }
  [[nodiscard]] SPRINGNET_INLINE auto& reference(std::size_t j) { return entry(element.reference, j); }
  [[nodiscard]] SPRINGNET_INLINE const auto& reference(std::size_t j) const { return entry(element.reference, j); }

 private:
  template <class Member>
  SPRINGNET_INLINE static auto& entry(Member& member, [[maybe_unused]] std::size_t j) {
    if constexpr (Traits::several)
      return member[j];
    else
      return member;
  }
  template <class Table, class Time>
  SPRINGNET_INLINE auto unset(const Table& table, const Time& time) {
    using E = typename Traits::template ElementOf<Real>;
    if constexpr (Traits::several)
      return E{
          {}, {}, {}, {}, time, table, Chunk::S > 0 ? states.data() : nullptr, Chunk::I > 0 ? inputs.data() : nullptr};
    else
      return E{
          0.0, 0.0, 0.0, time, table, Chunk::S > 0 ? states.data() : nullptr, Chunk::I > 0 ? inputs.data() : nullptr};
  }
};

// The generalised forces of a law, or the derivatives of its energy if it gives that alone.
template <class Law, class Real>
SPRINGNET_INLINE std::array<Real, LawTraits<Law>::invariant_count> forces_of(const Law& law,
                                                                             const LawArguments<Law, Real>& a) {
  using Traits = LawTraits<Law>;
  constexpr std::size_t V = Traits::invariant_count;
  if constexpr (!Traits::has_force) {
    using Lifted = Dual<V, Real>;
    LawArguments<Law, Lifted> lifted(a);
    unrolled<V>([&](auto j) {
      if constexpr (Traits::reads_value(j)) lifted.q(j).derivatives[j] = Real(1.0);
    });
    return law.energy(lifted.element, lifted.values()).derivatives;
  } else if constexpr (Traits::several) {
    return law.force(a.element, a.values());
  } else {
    return {law.force(a.element, a.values())};
  }
}

// Streams with the same value for all elements of the batch.
template <Varying varying, class Law>
SPRINGNET_INLINE std::array<double, LawChunk<Law>::N> constants_of(const LawChunk<Law>& c) {
  std::array<double, LawChunk<Law>::N> result{};
  if constexpr (varying != Varying::all) {
    for (std::size_t j = 0; j < result.size(); ++j) result[j] = *c.streams[j];
  }
  return result;
}

// The kinds of chunks that a loop is compiled for; others are expanded to the next one.
enum class Kinds { each, reference_and_all, all };

// Calls what(chunk, std::integral_constant<Varying, …>) for all chunks of a batch.
template <Kinds kinds = Kinds::each, class Law, class What>
SPRINGNET_INLINE void for_each_chunk(const Law& law, const springnet_law_batch& b, const What& what) {
  using Chunk = LawChunk<Law>;
  using Table = typename LawTraits<Law>::Table;
  constexpr std::size_t P = Chunk::P, S = Chunk::S, I = Chunk::I, N = Chunk::N;
  // Reference values, parameters and inputs in one list; a host without a reference value gives null.
  static constexpr double no_reference = 0.0;
  static constexpr NoTable no_table{};
  std::array<const double*, N> arrays{};
  std::array<std::uint32_t, N> strides{};
  arrays[0] = b.reference == nullptr ? &no_reference : b.reference;
  strides[0] = b.reference == nullptr ? 0u : b.reference_stride;
  for (std::size_t j = 0; j < P; ++j) {
    arrays[1 + j] = b.parameters[j];
    strides[1 + j] = b.parameter_strides[j];
  }
  for (std::size_t j = 0; j < I; ++j) {
    arrays[1 + P + j] = b.inputs[j];
    strides[1 + P + j] = b.input_strides[j];
  }
  constexpr bool expands_reference = kinds == Kinds::reference_and_all;
  [[maybe_unused]] double references[expands_reference ? chunk_size : 1];
  if (expands_reference && strides[0] == 0) {
    std::fill_n(references, std::min(b.count, chunk_size), *arrays[0]);
    arrays[0] = references;
  }
  const Streams<N, true> streams(arrays.data(), strides.data(), b.count, kinds == Kinds::all);

  for (std::uint32_t begin = 0; begin < b.count; begin += chunk_size) {
    Chunk chunk{};
    chunk.law = &law;
    chunk.begin = begin;
    chunk.count = std::min(chunk_size, b.count - begin);
    if constexpr (LawTraits<Law>::several) {
      for (std::size_t j = 0; j < Chunk::V; ++j) {
        chunk.references[j] = b.references[j] + begin;
        if (!LawTraits<Law>::reads_value(j)) continue;
        chunk.q[j] = b.values[j] + begin;
        chunk.rate[j] = LawTraits<Law>::reads_rate ? b.rates[j] + begin : nullptr;
      }
      for (std::size_t j = 0; j < Chunk::direction_count; ++j) chunk.direction[j] = b.direction[j] + begin;
    } else {
      chunk.q[0] = b.q + begin;
      chunk.rate[0] = LawTraits<Law>::reads_rate ? b.rate + begin : nullptr;
    }
    chunk.time = b.time;
    if constexpr (std::is_same_v<Table, NoTable>)
      chunk.table = &no_table;
    else
      chunk.table = static_cast<const Table*>(b.table);
    for (std::size_t j = 0; j < S; ++j) chunk.states[j] = b.states[j] + begin;
    for (std::size_t j = 0; j < N; ++j) chunk.streams[j] = streams.at(j, begin);
    if constexpr (kinds == Kinds::each) {
      if (streams.uniform()) {
        what(chunk, std::integral_constant<Varying, Varying::nothing>{});
        continue;
      }
    }
    if constexpr (kinds != Kinds::all && !LawTraits<Law>::several) {
      if (streams.rest_is_uniform()) {
        what(chunk, std::integral_constant<Varying, Varying::reference>{});
        continue;
      }
    }
    what(chunk, std::integral_constant<Varying, Varying::all>{});
  }
}

// An array of a list that may be null, from `begin` on.
SPRINGNET_INLINE double* from(double* const* list, std::size_t index, std::uint32_t begin) {
  return list == nullptr || list[index] == nullptr ? nullptr : list[index] + begin;
}
SPRINGNET_INLINE bool any(double* const* list, std::size_t size) {
  for (std::size_t j = 0; list != nullptr && j < size; ++j)
    if (list[j] != nullptr) return true;
  return false;
}
// Whether one of `width` columns from `column` on is wanted, of a matrix of arrays.
SPRINGNET_INLINE bool any_column(double* const* list, std::size_t rows, std::size_t columns, std::size_t column,
                                 std::size_t width) {
  for (std::size_t row = 0; list != nullptr && row < rows; ++row)
    if (any(list + row * columns + column, width)) return true;
  return false;
}

}  // namespace springnet::sdk::detail
