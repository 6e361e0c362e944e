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

  const Law* law;
  std::uint32_t begin, count;
  const double* q;
  const double* rate;
  double time;
  const typename Traits::Table* table;
  std::array<const double*, S> states;
  std::array<const double*, N> streams;  // reference value, parameters, inputs
};

// The arguments of a formula for one element.
template <class Law, class Real>
struct LawArguments {
  using Chunk = LawChunk<Law>;
  std::array<Real, Chunk::P> parameters;
  std::array<Real, Chunk::S> states;
  std::array<Real, Chunk::I> inputs;
  Element<Real, typename LawTraits<Law>::Table> element;

  template <Varying varying>
  SPRINGNET_INLINE LawArguments(const Chunk& c, const std::array<double, Chunk::N>& constants, std::uint32_t i,
                                std::integral_constant<Varying, varying>)
      : element{c.q[i],       0.0,      varying == Varying::nothing ? constants[0] : c.streams[0][i],
                c.time,       *c.table, states.data(),
                inputs.data()} {
    if constexpr (LawTraits<Law>::reads_rate) element.rate = c.rate[i];
    for (std::size_t j = 0; j < Chunk::P; ++j)
      parameters[j] = varying != Varying::all ? constants[1 + j] : c.streams[1 + j][i];
    for (std::size_t j = 0; j < Chunk::I; ++j)
      inputs[j] = varying != Varying::all ? constants[1 + Chunk::P + j] : c.streams[1 + Chunk::P + j][i];
    for (std::size_t j = 0; j < Chunk::S; ++j) states[j] = c.states[j][i];
  }
  LawArguments(const LawArguments&) = delete;  // element points into it
  LawArguments& operator=(const LawArguments&) = delete;
  [[nodiscard]] SPRINGNET_INLINE Parameters<Real> values() const { return Parameters<Real>(parameters.data()); }
};

// Streams with the same value for all elements of the batch.
template <Varying varying, class Law>
SPRINGNET_INLINE std::array<double, LawChunk<Law>::N> constants_of(const LawChunk<Law>& c) {
  std::array<double, LawChunk<Law>::N> result{};
  if constexpr (varying != Varying::all) {
    for (std::size_t j = 0; j < result.size(); ++j) result[j] = *c.streams[j];
  }
  return result;
}

// Calls what(chunk, std::integral_constant<Varying, …>) for all chunks of a batch.
template <class Law, class What>
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
  const Streams<N, true> streams(arrays.data(), strides.data(), b.count);

  for (std::uint32_t begin = 0; begin < b.count; begin += chunk_size) {
    Chunk chunk{};
    chunk.law = &law;
    chunk.begin = begin;
    chunk.count = std::min(chunk_size, b.count - begin);
    chunk.q = b.q + begin;
    chunk.rate = LawTraits<Law>::reads_rate ? b.rate + begin : nullptr;
    chunk.time = b.time;
    if constexpr (std::is_same_v<Table, NoTable>)
      chunk.table = &no_table;
    else
      chunk.table = static_cast<const Table*>(b.table);
    for (std::size_t j = 0; j < S; ++j) chunk.states[j] = b.states[j] + begin;
    for (std::size_t j = 0; j < N; ++j) chunk.streams[j] = streams.at(j, begin);
    if (streams.uniform())
      what(chunk, std::integral_constant<Varying, Varying::nothing>{});
    else if (streams.rest_is_uniform())
      what(chunk, std::integral_constant<Varying, Varying::reference>{});
    else
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

}  // namespace springnet::sdk::detail
