// The loops of springnet_law::update: a step of the internal state, and force, energy and margin at its end with total
// derivatives.
//
// Without an update() of the law's own, of order 1: backward Euler, Z = z + h r(q, Z). Of order 2: from a step and two
// half steps of backward Euler, in which the invariant, its rate and the inputs go in a straight line from those of the
// start, so that q1 is half of the way,
//   W = z + h r(q, W),   Z1 = z + h/2 r(q1, Z1),   Z2 = Z1 + h/2 r(q, Z2),   Z = 2 Z2 - W,
// which is L-stable (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.9: T22 of the
// extrapolated implicit Euler method). Where a rate ends at a kink, as that of damage or of flow does, W and Z2 are
// both there if the relaxation is fast, and so is Z; Z goes at most 3.6 % of the way too far (at h = 12 relaxation
// times).
//
// For rates without kinks (smooth_rates) of order 2: the two stages of Alexander's stiffly accurate diagonally implicit
// Runge-Kutta method with g = 1 - 1/sqrt(2), and q1 at the share g of the way,
//   Z1 = z + g h r(q1, Z1),   Z = z + (1 - g) h r(q1, Z1) + g h r(q, Z).
// It takes two thirds of the time, with a quarter of the error, and is L-stable, too. But the sum before the last term
// goes up to 2.4 times as far as z should, and only r(q, Z) can bring it back, which a kink hinders: damage, which does
// not heal, would stay there. (R. Alexander, Diagonally implicit Runge-Kutta methods for stiff O.D.E.'s, SIAM J. Numer.
// Anal. 14 (1977) 1006-1021.)
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <springnet/sdk/law/implicit.hpp>
#include <springnet/sdk/law/kernel.hpp>

namespace springnet::sdk {

template <class Law>
class UpdateKernel {
  using Traits = LawTraits<Law>;
  using Chunk = detail::LawChunk<Law>;
  using Varying = detail::Varying;
  template <Varying varying>
  using Kind = std::integral_constant<Varying, varying>;
  template <class Real>
  using Arguments = detail::LawArguments<Law, Real>;
  static constexpr std::size_t P = Traits::parameter_count;
  static constexpr std::size_t S = Traits::state_count;
  static constexpr std::size_t I = Traits::input_count;
  static constexpr std::size_t V = Traits::invariant_count;
  static constexpr std::size_t along = Traits::reads_rate ? 2 : 1;  // derivatives by q, and by its rate
  static constexpr JacobianLayout layout = Traits::jacobian;
  static constexpr bool smooth = Law::smooth_rates;
  static constexpr double g = 0.29289321881345248;  // 1 - 1/sqrt(2)
  static constexpr double carried = (1.0 - g) / g;
  static constexpr double half_way = smooth ? g : 0.5;  // where the first of two stages is

 public:
  struct Call {
    const Law* law;
    const springnet_law_update* update;
    std::uint32_t instruction_set;
    bool* found;  // false: the state of an element was not
  };
  SPRINGNET_INLINE static void run(const Call& call) {
    const springnet_law_update& u = *call.update;
    bool found = true;
    detail::for_each_chunk(*call.law, *u.batch,
                           [&](const Chunk& chunk, auto kind) { found = update<false>(u, chunk, kind) && found; });
    *call.found = found;
  }
  // springnet_law_batch::derivatives: compiled once, for one instruction set and one kind of chunks, since a step with
  // its derivatives is long.
  static bool run_matrix(const Law& law, const springnet_law_update& u) {
    bool found = true;
    detail::for_each_chunk<detail::Kinds::all>(
        law, *u.batch, [&](const Chunk& chunk, auto kind) { found = update<true>(u, chunk, kind) && found; });
    return found;
  }

 private:
  using Array = double[S][detail::chunk_size];

  // What the stages of a step found. Of order 1: next alone.
  struct Found {
    Array whole, first, second;  // W, Z1 and Z2 above; Z1 alone if rates are smooth
    Array next;                  // Z
  };

  // What a chunk is at the first of two stages.
  struct Between {
    double q[V][detail::chunk_size], rate[V][detail::chunk_size];
    double inputs[I == 0 ? 1 : I][detail::chunk_size];
  };

  // What the stages of a chunk were, for their derivatives. Chunks have the states at the start.
  template <Varying varying>
  struct Stages {
    const Chunk &end, &middle;
    const Found& found;
    double time_step;
    std::array<double, Chunk::N> fixed = detail::constants_of<varying>(end);
    std::array<double, Chunk::N> fixed_middle = detail::constants_of<varying>(middle);
  };

  template <Varying varying>
  SPRINGNET_INLINE static Chunk between(const springnet_law_update& u, const Chunk& c, Between& memory) {
    Chunk stage = c;
    const auto mix = [&c](const double* start, const double* end, double* out) {
      for (std::uint32_t i = 0; i < c.count; ++i) out[i] = start[i] + half_way * (end[i] - start[i]);
    };
    for (std::size_t j = 0; j < V; ++j) {
      if (!Traits::reads_value(j)) continue;
      mix((Traits::several ? u.start_values[j] : u.start_q) + c.begin, c.q[j], memory.q[j]);
      stage.q[j] = memory.q[j];
      if constexpr (Traits::reads_rate) {
        mix((Traits::several ? u.start_rates[j] : u.start_rate) + c.begin, c.rate[j], memory.rate[j]);
        stage.rate[j] = memory.rate[j];
      }
    }
    for (std::size_t j = 0; j < I; ++j) {
      const bool apart = u.batch->input_strides[j] != 0;
      const double* const start = u.start_inputs[j] + (apart ? c.begin : 0);
      const double* const end = c.streams[1 + P + j];
      double* const out = memory.inputs[j];
      if (varying != Varying::all)
        out[0] = *start + half_way * (*end - *start);
      else
        for (std::uint32_t i = 0; i < c.count; ++i) {
          const double from = start[apart ? i : 0];
          out[i] = from + half_way * (end[i] - from);
        }
      stage.streams[1 + P + j] = out;
    }
    stage.time = c.time - (1.0 - half_way) * u.time_step;
    return stage;
  }

  // Z by the stages. False: one of them has no solution.
  template <Varying varying>
  SPRINGNET_INLINE static bool solve(const springnet_law_update& u, const Chunk& c, const Chunk& stage, Found& found) {
    Array base;
    for (std::size_t j = 0; j < S; ++j) std::copy_n(c.states[j], c.count, base[j]);
    const double h = u.time_step;
    if (u.order < 2) return detail::ImplicitStage<Law, varying>(c, h).solve(base, found.next);
    const double weight = half_way * h;
    if (!detail::ImplicitStage<Law, varying>(stage, weight).solve(base, found.first)) return false;
    Chunk second = c;  // whose search begins at the first stage's solution
    for (std::size_t j = 0; j < S; ++j) second.states[j] = found.first[j];
    if constexpr (smooth) {
      for (std::size_t j = 0; j < S; ++j)
        for (std::uint32_t i = 0; i < c.count; ++i) base[j][i] += carried * (found.first[j][i] - base[j][i]);
      return detail::ImplicitStage<Law, varying>(second, weight).solve(base, found.next);
    } else {
      if (!detail::ImplicitStage<Law, varying>(second, weight).solve(found.first, found.second)) return false;
      for (std::size_t j = 0; j < S; ++j) second.states[j] = found.second[j];
      if (!detail::ImplicitStage<Law, varying>(second, h).solve(base, found.whole)) return false;
      for (std::size_t j = 0; j < S; ++j)
        for (std::uint32_t i = 0; i < c.count; ++i)
          found.next[j][i] = confined<double>(j, 2.0 * found.second[j][i] - found.whole[j][i]);
      return true;
    }
  }

  // Both steps of which Z is made end within the bounds of the state; Z may be beyond.
  template <class Number>
  SPRINGNET_INLINE static Number confined(std::size_t j, const Number& state) {
    const Parameter& declared = Traits::StateList::get()[j];
    return min(max(state, declared.smallest), declared.largest);
  }

  // A stage's solution `value` as a function of N seeds, by the implicit function theorem:
  // (I - weight dr/dz) dZ = d(base) + weight dr. The rates are evaluated once, with derivatives by seeds and by states.
  template <std::size_t N, Varying varying, class Seed>
  SPRINGNET_INLINE static std::array<Dual<N>, S> implicit(const Chunk& c, const std::array<double, Chunk::N>& fixed,
                                                          std::uint32_t i, Kind<varying> kind, double weight,
                                                          double share, const std::array<Dual<N>, S>& base,
                                                          const std::array<double, S>& value, const Seed& seed) {
    Arguments<Dual<N + S>> a(c, fixed, i, kind);
    seed(a, share);
    for (std::size_t j = 0; j < S; ++j) a.states[j] = Dual<N + S>::variable(value[j], N + j);
    const std::array<Dual<N + S>, S> rates = c.law->state_rates(a.element, a.values());
    std::array<std::array<double, S>, S> matrix;
    std::array<Dual<N>, S> right;
    for (std::size_t j = 0; j < S; ++j) {
      for (std::size_t k = 0; k < S; ++k) matrix[j][k] = (j == k ? 1.0 : 0.0) - weight * rates[j].derivatives[N + k];
      for (std::size_t k = 0; k < N; ++k)
        right[j].derivatives[k] = base[j].derivatives[k] + weight * rates[j].derivatives[k];
    }
    std::array<Dual<N>, S> result = detail::solve_small<S>(matrix, right);
    for (std::size_t j = 0; j < S; ++j) result[j].value = value[j];
    return result;
  }

  // seed(arguments, share): sets derivatives of arguments that are at the share of the way to the end; 1: at the end.
  // of_start: derivatives of the states at the start.
  template <std::size_t N, int order, Varying varying, class Seed, class OfStart>
  SPRINGNET_INLINE static std::array<Dual<N>, S> next_of(const Stages<varying>& stages, std::uint32_t i,
                                                         Kind<varying> kind, const Seed& seed,
                                                         const OfStart& of_start) {
    std::array<Dual<N>, S> start;
    for (std::size_t j = 0; j < S; ++j) {
      start[j] = stages.end.states[j][i];
      of_start(start[j], j);
    }
    const auto values = [i](const Array& solution) {
      std::array<double, S> value;
      for (std::size_t j = 0; j < S; ++j) value[j] = solution[j][i];
      return value;
    };
    const Found& found = stages.found;
    const double h = stages.time_step;
    const auto at_end = [&](double weight, const std::array<Dual<N>, S>& base, const Array& solution) {
      return implicit<N>(stages.end, stages.fixed, i, kind, weight, 1.0, base, values(solution), seed);
    };
    if constexpr (order == 1) {
      return at_end(h, start, found.next);
    } else {
      const std::array<Dual<N>, S> first = implicit<N>(stages.middle, stages.fixed_middle, i, kind, half_way * h,
                                                       half_way, start, values(found.first), seed);
      if constexpr (smooth) {
        for (std::size_t j = 0; j < S; ++j) start[j] = start[j] + carried * (first[j] - start[j]);
        return at_end(half_way * h, start, found.next);
      } else {
        std::array<Dual<N>, S> next = at_end(half_way * h, first, found.second);
        const std::array<Dual<N>, S> whole = at_end(h, start, found.whole);
        for (std::size_t j = 0; j < S; ++j) next[j] = confined(j, 2.0 * next[j] - whole[j]);
        return next;
      }
    }
  }

  // By the law's own update().
  template <std::size_t N, Varying varying, class Seed, class OfStart>
  SPRINGNET_INLINE static std::array<Dual<N>, S> own(const springnet_law_update& u, const Chunk& c,
                                                     const std::array<double, Chunk::N>& fixed, std::uint32_t i,
                                                     Kind<varying> kind, const Seed& seed, const OfStart& of_start) {
    using Real = Dual<N>;
    Arguments<Real> a(c, fixed, i, kind);
    seed(a, 1.0);
    for (std::size_t j = 0; j < S; ++j) of_start(a.states[j], j);
    std::array<Real, I> inputs;
    for (std::size_t j = 0; j < I; ++j) inputs[j] = u.start_inputs[j][u.batch->input_strides[j] != 0 ? c.begin + i : 0];
    Step<Real> step{u.start_q[c.begin + i], 0.0, inputs.data(), u.time_step, static_cast<int>(u.order)};
    if constexpr (Traits::reads_rate) step.start_rate = u.start_rate[c.begin + i];
    if constexpr (requires { seed.at_start(step, inputs); }) seed.at_start(step, inputs);
    return c.law->update(a.element, a.values(), step);
  }

  template <bool matrix_alone, Varying varying>
  SPRINGNET_INLINE static bool update(const springnet_law_update& u, const Chunk& c, Kind<varying> kind) {
    const springnet_law_batch& b = *u.batch;
    Found found;
    Array& next = found.next;
    Between memory;
    Chunk stage = c;
    const auto nothing = [](auto&, std::size_t) {};
    if constexpr (Traits::has_update) {
      const auto fixed = detail::constants_of<varying>(c);
      std::uint64_t not_finite = 0;
      for (std::uint32_t i = 0; i < c.count; ++i) {
        const auto states = own<0>(
            u, c, fixed, i, kind, [](auto&, double) {}, nothing);
        for (std::size_t j = 0; j < S; ++j) {
          next[j][i] = states[j].value;
          not_finite += states[j].value - states[j].value == 0.0 ? 0u : 1u;
        }
      }
      if (not_finite > 0) return false;
    } else {
      if (u.order >= 2) stage = between<varying>(u, c, memory);
      if (!solve<varying>(u, c, stage, found)) return false;
    }
    for (std::size_t j = 0; !matrix_alone && j < S; ++j)
      if (double* out = detail::from(u.next, j, c.begin)) std::copy_n(next[j], c.count, out);
    Chunk end = c;  // with the states there
    for (std::size_t j = 0; j < S; ++j) end.states[j] = next[j];
    if constexpr (!matrix_alone) at_end(b, end, kind);
    // next_with(i, derivatives, seed, of_start): the states at the end with that many derivatives.
    if constexpr (Traits::has_update) {
      const auto fixed = detail::constants_of<varying>(c);
      derivatives_of<matrix_alone>(u, end, kind,
                                   [&](std::uint32_t i, auto count, const auto& seed, const auto& of_start) {
                                     return own<decltype(count)::value>(u, c, fixed, i, kind, seed, of_start);
                                   });
    } else {
      const Stages<varying> stages{c, stage, found, u.time_step};
      if (u.order < 2)
        derivatives_of<matrix_alone>(u, end, kind,
                                     [&](std::uint32_t i, auto count, const auto& seed, const auto& of_start) {
                                       return next_of<decltype(count)::value, 1>(stages, i, kind, seed, of_start);
                                     });
      else
        derivatives_of<matrix_alone>(u, end, kind,
                                     [&](std::uint32_t i, auto count, const auto& seed, const auto& of_start) {
                                       return next_of<decltype(count)::value, 2>(stages, i, kind, seed, of_start);
                                     });
    }
    return true;
  }

  template <Varying varying>
  SPRINGNET_INLINE static void at_end(const springnet_law_batch& b, const Chunk& end, Kind<varying> kind) {
    const auto fixed = detail::constants_of<varying>(end);
    const auto values = [&](double* array, const auto& quantity) {
      double* __restrict out = array + end.begin;
      for (std::uint32_t i = 0; i < end.count; ++i) {
        const Arguments<Dual<0>> a(end, fixed, i, kind);
        out[i] = quantity(a).value;
      }
    };
    if constexpr (Traits::several) {
      for (std::uint32_t i = 0; detail::any(b.forces, V) && i < end.count; ++i) {
        const Arguments<Dual<0>> a(end, fixed, i, kind);
        const std::array<Dual<0>, V> forces = detail::forces_of<Law>(*end.law, a);
        for (std::size_t j = 0; j < V; ++j)
          if (double* out = detail::from(b.forces, j, end.begin)) out[i] = forces[j].value;
      }
    } else if (b.force != nullptr) {
      values(b.force, [&](const auto& a) { return detail::forces_of<Law>(*end.law, a)[0]; });
    }
    if constexpr (Traits::has_energy) {
      if (b.energy != nullptr) values(b.energy, [&](const auto& a) { return end.law->energy(a.element, a.values()); });
    }
    if constexpr (Traits::has_margin) {
      if (b.margin != nullptr) values(b.margin, [&](const auto& a) { return end.law->margin(a.element, a.values()); });
    }
  }

  template <bool matrix_alone, Varying varying, class NextWith>
  SPRINGNET_INLINE static void derivatives_of(const springnet_law_update& u, const Chunk& end, Kind<varying> kind,
                                              const NextWith& next_with) {
    const springnet_law_batch& b = *u.batch;
    if constexpr (matrix_alone) {
      matrix(u, end, kind, next_with);
    } else if constexpr (!Traits::several) {
      // By states only where somebody asks: Newton's method for the nodes does not.
      if (detail::any(b.force_by_states, S) || detail::any(u.next_by_states, S * S))
        derivatives<along + S>(u, end, kind, next_with);
      else if (b.force_by_q != nullptr || b.force_by_rate != nullptr || detail::any(u.next_by_q, S) ||
               detail::any(u.next_by_rate, S))
        derivatives<along>(u, end, kind, next_with);
      if constexpr (P > 0) parameter_derivatives(u, end, kind, next_with);
    }
  }

  // Derivatives of the arguments by `width` columns of the matrix from `first` on, for arguments that are at the share
  // of the way to the end.
  template <std::size_t first, std::size_t width>
  struct ColumnSeed {
    SPRINGNET_INLINE void operator()(auto& a, double share) const {
      detail::unrolled<width>([&](auto k) {
        constexpr std::size_t column = first + k.value;
        constexpr bool moves = column < layout.reference() || column - layout.input(0) < I;
        if constexpr (column < layout.columns(false)) {
          if (auto* argument = detail::argument_of<Law, column>(a))
            argument->derivatives[k.value] = moves ? share : 1.0;
        } else if constexpr (column < layout.start_rate()) {
          constexpr std::size_t j = column - layout.start_value();
          if (Traits::reads_value(j)) a.q(j).derivatives[k.value] = 1.0 - share;
        } else if constexpr (column < layout.start_input(0)) {
          constexpr std::size_t j = column - layout.start_rate();
          if constexpr (Traits::reads_rate)
            if (Traits::reads_value(j)) a.rate(j).derivatives[k.value] = 1.0 - share;
        } else {
          a.inputs[column - layout.start_input(0)].derivatives[k.value] = 1.0 - share;
        }
      });
    }
    SPRINGNET_INLINE void at_start(auto& step, auto& inputs) const {
      detail::unrolled<width>([&](auto k) {
        constexpr std::size_t column = first + k.value;
        if constexpr (column == layout.start_value()) step.start_q.derivatives[k.value] = 1.0;
        if constexpr (column == layout.start_rate()) step.start_rate.derivatives[k.value] = 1.0;
        if constexpr (column >= layout.start_input(0))
          inputs[column - layout.start_input(0)].derivatives[k.value] = 1.0;
      });
    }
  };

  // springnet_law_batch::derivatives, some columns at a time.
  template <Varying varying, class NextWith>
  SPRINGNET_INLINE static void matrix(const springnet_law_update& u, const Chunk& end, Kind<varying> kind,
                                      const NextWith& next_with) {
    const springnet_law_batch& b = *u.batch;
    constexpr std::size_t columns = layout.columns(true), rows = layout.rows();
    constexpr std::size_t groups = (columns + derivatives_at_a_time - 1) / derivatives_at_a_time;
    const auto fixed = detail::constants_of<varying>(end);
    detail::unrolled<groups>([&](auto group) {
      constexpr std::size_t first = group.value * derivatives_at_a_time;
      constexpr std::size_t width = std::min(derivatives_at_a_time, columns - first);
      if (!detail::any_column(b.derivatives, rows, columns, first, width)) return;
      using Real = Dual<width>;
      double unwanted[detail::chunk_size];
      std::array<std::array<double*, width>, rows> out;
      for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t k = 0; k < width; ++k) {
          double* const to = detail::from(b.derivatives, row * columns + first + k, end.begin);
          out[row][k] = to != nullptr ? to : unwanted;
        }
      const ColumnSeed<first, width> seed;
      const auto of_start = [](auto& state, std::size_t j) {
        if (layout.state(j) - first < width) state.derivatives[layout.state(j) - first] = 1.0;
      };
      for (std::uint32_t i = 0; i < end.count; ++i) {
        const std::array<Real, S> next = next_with(i, std::integral_constant<std::size_t, width>{}, seed, of_start);
        Arguments<Real> a(end, fixed, i, kind);
        seed(a, 1.0);
        a.states = next;
        const auto write = [&](std::size_t row, const Real& result) {
          for (std::size_t k = 0; k < width; ++k) out[row][k][i] = result.derivatives[k];
        };
        const std::array<Real, V> forces = detail::forces_of<Law>(*end.law, a);
        for (std::size_t j = 0; j < V; ++j) write(layout.force(j), forces[j]);
        if constexpr (Traits::has_energy) write(layout.energy(), end.law->energy(a.element, a.values()));
        if constexpr (Traits::has_margin) write(layout.margin(), end.law->margin(a.element, a.values()));
        for (std::size_t j = 0; j < S; ++j) write(layout.state_row(j), next[j]);
      }
    });
  }

  // By q and its rate, and with N greater than `along` by the states at the start.
  template <std::size_t N, Varying varying, class NextWith>
  SPRINGNET_INLINE static void derivatives(const springnet_law_update& u, const Chunk& end, Kind<varying> kind,
                                           const NextWith& next_with) {
    const springnet_law_batch& b = *u.batch;
    constexpr bool by_states = N > along;
    // Where each derivative goes: the force's, then those of each state. What nobody asks for goes nowhere.
    double unwanted[detail::chunk_size];
    std::array<std::array<double*, N>, S + 1> out;
    for (std::size_t row = 0; row <= S; ++row) {
      const auto to = [&](double* array) { return array == nullptr ? unwanted : array; };
      const std::size_t j = row - 1;  // state
      out[row][0] = to(row == 0 ? (b.force_by_q == nullptr ? nullptr : b.force_by_q + end.begin)
                                : detail::from(u.next_by_q, j, end.begin));
      if constexpr (Traits::reads_rate)
        out[row][1] = to(row == 0 ? (b.force_by_rate == nullptr ? nullptr : b.force_by_rate + end.begin)
                                  : detail::from(u.next_by_rate, j, end.begin));
      for (std::size_t k = 0; by_states && k < S; ++k)
        out[row][along + k] = to(row == 0 ? detail::from(b.force_by_states, k, end.begin)
                                          : detail::from(u.next_by_states, j * S + k, end.begin));
    }
    const auto seed = [](auto& a, double share) {
      a.q(0).derivatives[0] = share;
      if constexpr (Traits::reads_rate) a.rate(0).derivatives[1] = share;
    };
    const auto of_start = [](auto& state, std::size_t j) {
      if constexpr (by_states) state.derivatives[along + j] = 1.0;
    };
    const auto fixed = detail::constants_of<varying>(end);
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::uint32_t i = 0; i < end.count; ++i) {
      const std::array<Dual<N>, S> next = next_with(i, std::integral_constant<std::size_t, N>{}, seed, of_start);
      Arguments<Dual<N>> a(end, fixed, i, kind);
      seed(a, 1.0);
      a.states = next;
      const Dual<N> force = detail::forces_of<Law>(*end.law, a)[0];
      for (std::size_t k = 0; k < N; ++k) {
        out[0][k][i] = force.derivatives[k];
        for (std::size_t j = 0; j < S; ++j) out[1 + j][k][i] = next[j].derivatives[k];
      }
    }
    if constexpr (!Traits::reads_rate) {
      const auto zero = [&](double* array) {
        if (array != nullptr) std::fill_n(array, end.count, 0.0);
      };
      zero(b.force_by_rate == nullptr ? nullptr : b.force_by_rate + end.begin);
      for (std::size_t j = 0; j < S; ++j) zero(detail::from(u.next_by_rate, j, end.begin));
    }
  }

  template <Varying varying, class NextWith>
  SPRINGNET_INLINE static void parameter_derivatives(const springnet_law_update& u, const Chunk& end,
                                                     Kind<varying> kind, const NextWith& next_with) {
    const springnet_law_batch& b = *u.batch;
    using Real = Dual<1>;
    const auto fixed = detail::constants_of<varying>(end);
    for (std::size_t p = 0; p < P; ++p) {
      double* const by_parameter = detail::from(b.force_by_parameters, p, end.begin);
      bool wanted = by_parameter != nullptr;
      for (std::size_t j = 0; j < S; ++j)
        wanted = wanted || detail::from(u.next_by_parameters, j * P + p, 0) != nullptr;
      if (!wanted) continue;
      const auto seed = [p](auto& a, double) { a.parameters[p].derivatives[0] = 1.0; };
      for (std::uint32_t i = 0; i < end.count; ++i) {
        const std::array<Real, S> next =
            next_with(i, std::integral_constant<std::size_t, 1>{}, seed, [](auto&, std::size_t) {});
        Arguments<Real> a(end, fixed, i, kind);
        seed(a, 1.0);
        a.states = next;
        if (by_parameter != nullptr) by_parameter[i] = detail::forces_of<Law>(*end.law, a)[0].derivatives[0];
        for (std::size_t j = 0; j < S; ++j)
          if (double* out = detail::from(u.next_by_parameters, j * P + p, end.begin)) out[i] = next[j].derivatives[0];
      }
    }
  }
};

}  // namespace springnet::sdk
