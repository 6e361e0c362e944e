// The internal state of an element at the end of an implicit stage: Z with Z = base + weight r(Z), where r are the
// rates of its law at the stage's invariant, inputs and time. Newton's method with derivatives from dual numbers.
//
// All elements of a chunk take three iterations together, which solve laws that are linear in their state, and most
// others; the rest go on one by one, with damping and within the bounds that the law declares. What happens to an
// element depends on itself alone, so chunks of any size give the same bits.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <springnet/sdk/law/batch.hpp>

namespace springnet::sdk::detail {

// Solves A x = b by elimination with partial pivoting; a pivot of 0 gives infinities, which no caller takes.
template <std::size_t S, class Number>
SPRINGNET_INLINE std::array<Number, S> solve_small(std::array<std::array<double, S>, S> A, std::array<Number, S> b) {
  for (std::size_t k = 0; k < S; ++k) {
    if constexpr (S > 1) {
      std::size_t pivot = k;
      for (std::size_t i = k + 1; i < S; ++i)
        if (std::abs(A[i][k]) > std::abs(A[pivot][k])) pivot = i;
      std::swap(A[k], A[pivot]);
      std::swap(b[k], b[pivot]);
    }
    const double inverse = 1.0 / A[k][k];
    for (std::size_t i = k + 1; i < S; ++i) {
      const double factor = A[i][k] * inverse;
      for (std::size_t j = k + 1; j < S; ++j) A[i][j] -= factor * A[k][j];
      b[i] = b[i] - factor * b[k];
    }
  }
  for (std::size_t k = S; k-- > 0;) {
    for (std::size_t j = k + 1; j < S; ++j) b[k] = b[k] - A[k][j] * b[j];
    b[k] = b[k] * (1.0 / A[k][k]);
  }
  return b;
}

template <class Law, Varying varying>
class ImplicitStage {
  using Traits = LawTraits<Law>;
  using Chunk = LawChunk<Law>;
  using Kind = std::integral_constant<Varying, varying>;
  static constexpr std::size_t S = Traits::state_count;

 public:
  using Values = std::array<double, S>;
  using Matrix = std::array<std::array<double, S>, S>;
  using Base = double[S][chunk_size];

  // The chunk's invariant, rate, inputs and time are those of the stage; its states are where the search begins.
  SPRINGNET_INLINE ImplicitStage(const Chunk& chunk, double weight)
      : chunk_(chunk), constants_(constants_of<varying>(chunk)), weight_(weight) {}

  // False: the state of an element was not found.
  SPRINGNET_INLINE bool solve(const Base& base, Base& next) const {
    // Three iterations with the derivatives of the first, in a loop that vectorises.
    double off[chunk_size];  // 0: found
    const std::uint32_t count = chunk_.count;
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::uint32_t i = 0; i < count; ++i) {
      Values start, defect, second;
      for (std::size_t j = 0; j < S; ++j) start[j] = chunk_.states[j][i];
      const Matrix A = newton_matrix(i, start, base, defect);
      const Values change = solve_small<S>(A, defect);
      for (std::size_t j = 0; j < S; ++j) second[j] = start[j] + change[j];
      const Values before = solve_small<S>(A, defect_of(i, second, base));
      for (std::size_t j = 0; j < S; ++j) second[j] = second[j] + before[j];
      const Values rest = solve_small<S>(A, defect_of(i, second, base));
      for (std::size_t j = 0; j < S; ++j) next[j][i] = second[j] = second[j] + rest[j];
      off[i] = excess(second, before, rest) + outside(second);
    }
    std::uint64_t not_found = 0;
    for (std::uint32_t i = 0; i < count; ++i) not_found += off[i] == 0.0 ? 0u : 1u;
    if (not_found == 0) return true;
    for (std::uint32_t i = 0; i < count; ++i)
      if (!(off[i] == 0.0) && !search(i, base, next)) return false;
    return true;
  }

  // Rates at given states, with their derivatives by these.
  SPRINGNET_INLINE void rates(std::uint32_t i, const Values& states, Values& rate, Matrix& by_states) const {
    LawArguments<Law, Dual<S>> a(chunk_, constants_, i, Kind{});
    for (std::size_t j = 0; j < S; ++j) a.states[j] = Dual<S>::variable(states[j], j);
    const std::array<Dual<S>, S> r = chunk_.law->state_rates(a.element, a.values());
    for (std::size_t j = 0; j < S; ++j) {
      rate[j] = r[j].value;
      by_states[j] = r[j].derivatives;
    }
  }
  // I - weight dr/dz
  SPRINGNET_INLINE Matrix matrix(const Matrix& by_states) const {
    Matrix result;
    for (std::size_t i = 0; i < S; ++i)
      for (std::size_t j = 0; j < S; ++j) result[i][j] = (i == j ? 1.0 : 0.0) - weight_ * by_states[i][j];
    return result;
  }
  [[nodiscard]] SPRINGNET_INLINE double weight() const { return weight_; }

 private:
  // Newton's method: (I - weight dr/dz) correction = defect, base + weight r - z.
  SPRINGNET_INLINE Matrix newton_matrix(std::uint32_t i, const Values& states, const Base& base, Values& defect) const {
    Values rate;
    Matrix by_states;
    rates(i, states, rate, by_states);
    for (std::size_t j = 0; j < S; ++j) defect[j] = (base[j][i] - states[j]) + weight_ * rate[j];
    return matrix(by_states);
  }
  SPRINGNET_INLINE Values correction(std::uint32_t i, const Values& states, const Base& base) const {
    Values defect;
    const Matrix A = newton_matrix(i, states, base, defect);
    return solve_small<S>(A, defect);
  }
  SPRINGNET_INLINE Values defect_of(std::uint32_t i, const Values& states, const Base& base) const {
    LawArguments<Law, Dual<0>> a(chunk_, constants_, i, Kind{});
    for (std::size_t j = 0; j < S; ++j) a.states[j] = states[j];
    const std::array<Dual<0>, S> r = chunk_.law->state_rates(a.element, a.values());
    Values defect;
    for (std::size_t j = 0; j < S; ++j) defect[j] = (base[j][i] - states[j]) + weight_ * r[j].value;
    return defect;
  }
  // Of a state near 0, by its declared scale.
  SPRINGNET_INLINE static double rounding_of(std::size_t j) {
    return 4.0 * std::numeric_limits<double>::epsilon() * Traits::StateList::get()[j].scale;
  }
  // 0 if the last correction is rounding, or what would follow it is, by the one before: about rest^2 / before. (Not by
  // the first one: a kink between would hide.) nan if it is nan.
  SPRINGNET_INLINE static double excess(const Values& states, const Values& before, const Values& rest) {
    constexpr double rounding = 16.0 * std::numeric_limits<double>::epsilon();
    double result = 0.0;
    for (std::size_t j = 0; j < S; ++j) {
      const double size = std::abs(states[j]);
      const double least = rounding * size + rounding_of(j);
      const double last = std::abs(rest[j]) - least;
      const double following = rest[j] * rest[j] - 0.25 * least * std::abs(before[j]);
      result += last <= 0.0 || following <= 0.0 ? 0.0 : std::abs(last);
    }
    return result;
  }
  SPRINGNET_INLINE static double outside(const Values& states) {
    double result = 0.0;
    for (std::size_t j = 0; j < S; ++j) {
      const Parameter& declared = Traits::StateList::get()[j];
      result += states[j] < declared.smallest || states[j] > declared.largest ? 1.0 : 0.0;
    }
    return result;
  }
  static void confine(Values& states) {
    for (std::size_t j = 0; j < S; ++j) {
      const Parameter& declared = Traits::StateList::get()[j];
      states[j] = states[j] < declared.smallest  ? declared.smallest
                  : states[j] > declared.largest ? declared.largest
                                                 : states[j];
    }
  }
  double norm(std::uint32_t i, const Values& states, const Base& base) const {
    const Values defect = defect_of(i, states, base);
    double sum = 0.0;
    for (std::size_t j = 0; j < S; ++j) {
      const double scaled = defect[j] / Traits::StateList::get()[j].scale;
      sum += scaled * scaled;
    }
    return std::sqrt(sum);
  }

  // Newton's method with a line search on the defect, from where the step starts, within bounds. With one state also
  // between two points where the defect has opposite signs, once they are known.
  SPRINGNET_APART bool search(std::uint32_t i, const Base& base, Base& next) const {
    constexpr int most_iterations = 200, most_halvings = 40;
    constexpr double settled = 4.0 * std::numeric_limits<double>::epsilon();
    Values at;
    for (std::size_t j = 0; j < S; ++j) at[j] = chunk_.states[j][i];
    confine(at);
    double size = norm(i, at, base);
    double low = std::numeric_limits<double>::quiet_NaN(), high = low;  // defect above 0 at low, below at high
    const double first_size = size;
    bool is_between = false;  // two neighbouring numbers, on both sides of the solution
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      const Values change = correction(i, at, base);
      double share = 1.0;
      Values trial = at;
      double trial_size = size;
      for (int halving = 0; halving < most_halvings; ++halving, share *= 0.5) {
        for (std::size_t j = 0; j < S; ++j) trial[j] = at[j] + share * change[j];
        confine(trial);
        trial_size = norm(i, trial, base);
        if (trial_size < size || trial_size == 0.0) break;
      }
      bool moves = false;
      for (std::size_t j = 0; j < S; ++j) {
        const double scale = std::abs(trial[j]) > std::abs(at[j]) ? std::abs(trial[j]) : std::abs(at[j]);
        moves = moves || !(std::abs(change[j]) <= settled * scale + rounding_of(j));
      }
      // Newton's correction is rounding; after it a kink may be passed, with another slope.
      const bool settles = !moves;
      if constexpr (S == 1) {
        // A kink may throw Newton's method from side to side: keep the two nearest, and halve between them.
        const double defect = defect_of(i, at, base)[0];
        (defect > 0.0 ? low : high) = at[0];
        if (moves && !(trial_size < size)) {
          // Where only one side is known, the whole step may end on the other.
          const bool both = low == low && high == high;
          const double middle = both ? low + 0.5 * (high - low) : at[0] + change[0];
          moves = !both || (middle != low && middle != high);
          // Next to a kink the slope may be that of the wrong side, and what is left of the defect more than rounding.
          is_between = !moves;
          trial[0] = middle;
          confine(trial);
          trial_size = norm(i, trial, base);
        }
      }
      const bool improves = trial_size < size || S == 1;
      if (improves && trial_size == trial_size) {
        at = trial;
        size = trial_size;
      }
      if (!moves || size == 0.0) {
        for (std::size_t j = 0; j < S; ++j) {
          if (!std::isfinite(at[j])) return false;
          next[j][i] = at[j];
        }
        // At a pole of the rate the defect changes its sign, too, but is greater than at the start.
        return settles || (is_between && size <= first_size) || is_solution(i, at, base);
      }
      if (!improves) break;
    }
    for (std::size_t j = 0; j < S; ++j) next[j][i] = at[j];
    return is_solution(i, at, base);
  }
  // Whether what is left of the defect is the rounding of its terms; a bound may hold the state back from there.
  bool is_solution(std::uint32_t i, const Values& states, const Base& base) const {
    constexpr double rounding = 1e-9;
    const Values change = correction(i, states, base);
    for (std::size_t j = 0; j < S; ++j) {
      const double size = std::abs(states[j]) + std::abs(base[j][i]);
      if (!(std::abs(change[j]) <= rounding * size + rounding_of(j))) return false;
    }
    return true;
  }

  const Chunk& chunk_;
  std::array<double, Chunk::N> constants_;
  double weight_;
};

}  // namespace springnet::sdk::detail
