// What a law's class has, and whether that agrees with what it declares.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include <springnet/sdk/law/element.hpp>
#include <springnet/sdk/law/invariants.hpp>
#include <springnet/sdk/law/jacobian.hpp>
#include <springnet/sdk/metadata.hpp>

namespace springnet::sdk {

// The optional members of a law, one word each: using has = Has<Energy, Margin>;
struct Energy {};  // energy(e, p)
struct Margin {};  // margin(e, p)
struct Update {};  // update(e, p, step)
struct Start {};   // start(e, p)
template <class... Members>
struct Has {
  template <class Member>
  static constexpr bool names = (std::is_same_v<Member, Members> || ...);
};

namespace detail {

template <class Law>
struct TableOf {
  using type = NoTable;
};
template <class Law>
requires requires(const Law& law, const TableSource& source) { law.prepare(source); }
struct TableOf<Law> {
  using type = std::remove_cvref_t<decltype(std::declval<const Law&>().prepare(std::declval<const TableSource&>()))>;
};

}  // namespace detail

template <class Law>
struct LawTraits {
  struct StateList {
    static constexpr std::span<const Parameter> get() {
      if constexpr (requires { Law::states; }) return Law::states;
      return {};
    }
  };
  struct InputList {
    static constexpr std::span<const Parameter> get() {
      if constexpr (requires { Law::inputs; }) return Law::inputs;
      return {};
    }
  };
  struct TableList {
    static constexpr std::span<const Table> get() {
      if constexpr (requires { Law::tables; }) return Law::tables;
      return {};
    }
  };
  struct InvariantList {
    static constexpr std::span<const Scalar> get() {
      if constexpr (requires { Law::invariants; }) return Law::invariants;
      return {};
    }
  };
  // Whether the law reads a list of invariants. Else it reads the one that it names, in place of a list of one.
  static constexpr bool several = !InvariantList::get().empty();
  static constexpr std::size_t invariant_count = several ? InvariantList::get().size() : 1;
  static constexpr bool reads_value(std::size_t i) { return !several || !InvariantList::get()[i].reference_only(); }
  static constexpr std::size_t parameter_count = parameters_of<Law>().size();
  static constexpr std::size_t state_count = StateList::get().size();
  static constexpr std::size_t input_count = InputList::get().size();
  static constexpr std::size_t table_count = TableList::get().size();

  using Table = typename detail::TableOf<Law>::type;
  static constexpr JacobianLayout jacobian{invariant_count, parameter_count, state_count, input_count};
  template <class Number>
  using ElementOf = std::conditional_t<several, SeveralOf<Number, invariant_count, Table>, Element<Number, Table>>;
  using Real = Dual<0>;
  using E = ElementOf<Real>;
  using P = Parameters<Real>;
  // What force() returns.
  template <class Number>
  using ForceOf = std::conditional_t<several, std::array<Number, invariant_count>, Number>;

  static constexpr bool has_force = requires(const Law& law, const E& e, const P& p) {
    { law.force(e, p) } -> std::convertible_to<ForceOf<Real>>;
  };
  static constexpr bool defines_energy = requires(const Law& law, const E& e, const P& p) { Real{law.energy(e, p)}; };
  static constexpr bool defines_margin = requires(const Law& law, const E& e, const P& p) { Real{law.margin(e, p)}; };
  static constexpr bool defines_rates = requires(const Law& law, const E& e, const P& p) { law.state_rates(e, p)[0]; };
  static constexpr bool defines_update = requires(const Law& law, const E& e, const P& p, const Step<Real>& step) {
    law.update(e, p, step)[0];
  };
  static constexpr bool defines_start = requires(const Law& law, const E& e, const P& p) { law.start(e, p)[0]; };
  static constexpr bool defines_table = requires(const Law& law, const TableSource& source) { law.prepare(source); };

  static constexpr bool has_energy = Law::has::template names<Energy>;
  static constexpr bool has_margin = Law::has::template names<Margin>;
  static constexpr bool has_update = Law::has::template names<Update>;
  static constexpr bool has_start = Law::has::template names<Start>;
  static constexpr bool reads_rate = Law::reads_rate && (several || Law::invariant != SPRINGNET_RELATIVE_SPEED);

  // Compiles the formulas for elements without a rate, a time, or a direction.
  template <class Probe>
  static constexpr bool compiles_with() {
    return +[](const Law& law, const ElementOf<Probe>& e, const Parameters<Probe>& p,
               [[maybe_unused]] const Step<Probe>& step) {
      if constexpr (has_force) static_cast<void>(law.force(e, p));
      if constexpr (has_energy) static_cast<void>(law.energy(e, p));
      if constexpr (has_margin) static_cast<void>(law.margin(e, p));
      if constexpr (state_count > 0) static_cast<void>(law.state_rates(e, p));
      if constexpr (has_update) static_cast<void>(law.update(e, p, step));
      if constexpr (has_start) static_cast<void>(law.start(e, p));
    } != nullptr;
  }
  static constexpr bool rate_is_declared() {
    if constexpr (!reads_rate) return compiles_with<Rateless>();
    return true;
  }
  static constexpr bool time_is_declared() {
    if constexpr (!Law::reads_time) return compiles_with<Timeless>();
    return true;
  }
  static constexpr bool direction_is_declared() {
    if constexpr (several && !Law::reads_direction) return compiles_with<Directionless>();
    return true;
  }

  static constexpr std::uint64_t flag(bool present, std::uint64_t value) { return present ? value : 0u; }
  static constexpr std::uint64_t capabilities =
      SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_ALL_DERIVATIVES |
      flag(parameter_count > 0, SPRINGNET_HAS_PARAMETER_DERIVATIVES) | flag(has_energy, SPRINGNET_HAS_ENERGY) |
      flag(has_margin, SPRINGNET_HAS_RUPTURE) | flag(Law::acts_in_compression, SPRINGNET_ACTS_IN_COMPRESSION) |
      flag(reads_rate, SPRINGNET_READS_RATE) | flag(Law::monotone, SPRINGNET_MONOTONE) |
      flag(Law::not_zero_at_rest, SPRINGNET_NOT_ZERO_AT_REST) | flag(Law::adds_power, SPRINGNET_ADDS_POWER) |
      flag(Law::reads_time, SPRINGNET_READS_TIME) | flag(Law::calling_thread_only, SPRINGNET_CALLING_THREAD_ONLY) |
      flag(Law::fits_elements, SPRINGNET_FITS_ELEMENTS) |
      flag(Law::divides_by_reference, SPRINGNET_DIVIDES_BY_REFERENCE);
  static constexpr std::uint64_t needs =
      flag(state_count > 0, SPRINGNET_NEEDS_STATES) | flag(input_count > 0, SPRINGNET_NEEDS_INPUTS) |
      flag(table_count > 0, SPRINGNET_NEEDS_TABLES) | flag(several, SPRINGNET_NEEDS_SEVERAL);

  static_assert(has_force || has_energy,
                "a law needs: static auto force(const auto& e, const auto& p); or an energy(e, p) alone, named in "
                "`using has = Has<Energy>;`, from which its force follows. A law over several invariants returns a "
                "std::array with a force for each");
  static_assert(invariant_count <= SPRINGNET_MOST_INVARIANTS, "a law reads at most 7 invariants");
  static_assert(
      !several || detail::is_valid(Law::shape, InvariantList::get()),
      "a law with a list of invariants needs a `shape`, and its invariants nodes of that shape, each once, and "
      "no invariant twice");
  static_assert(several || (Law::shape == Shape::none && !Law::reads_direction),
                "`shape` and `reads_direction` are for laws with a list of invariants");
  static_assert(!(several && state_count > 0), "a law over several invariants cannot have `states`");
  static_assert(has_energy == defines_energy,
                "`using has = Has<Energy>;` and energy(e, p) belong together: write both, or neither");
  static_assert(has_margin == defines_margin,
                "`using has = Has<Margin>;` and margin(e, p) belong together: write both, or neither");
  static_assert(has_update == defines_update,
                "`using has = Has<Update>;` and update(e, p, step) belong together: write both, or neither");
  static_assert(has_start == defines_start,
                "`using has = Has<Start>;` and start(e, p) belong together: write both, or neither");
  static_assert((state_count > 0) == defines_rates,
                "a law with `states` needs state_rates(e, p), and one with state_rates(e, p) needs `states`");
  static_assert(state_count <= max_states, "a law has at most 8 states");
  static_assert(state_count > 0 || !(has_update || has_start), "update() and start() are for laws with `states`");
  static_assert((table_count > 0) == defines_table,
                "a law with `tables` needs prepare(source), and one with prepare(source) needs `tables`");
  static_assert(Law::update_order == 1 || Law::update_order == 2, "update_order is 1 or 2");
  static_assert(rate_is_declared());
  static_assert(time_is_declared());
  static_assert(direction_is_declared());
};

}  // namespace springnet::sdk
