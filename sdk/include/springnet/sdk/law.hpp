// Spring functions and viscosity functions in C++: one formula makes a plugin.
//
//   #include <springnet/sdk/law.hpp>
//   namespace {
//   using namespace springnet::sdk;
//   struct Linear : SpringFunction {
//     static constexpr const char* id = "linear";
//     static constexpr const char* summary = "Hooke's law";
//     static constexpr Parameter parameters[] = {number("stiffness", "N/m", "tension per elongation").at_least(0)};
//     static auto force(const auto& e, const auto& p) { return p[0] * e.elongation(); }
//   };
//   }  // namespace
//   SPRINGNET_PLUGIN("org.example.linear", "1.0.0", "author", "MIT", Linear);
//
// force() gets an Element<Real> and Parameters<Real>; Real is a dual number (dual.hpp), without derivatives for the
// forces. A formula that needs to name Real is written
//   template <class Real> static Real force(const Element<Real>& e, const Parameters<Real>& p)
// Beside force() a class may have:
//   energy(e, p)                            J; force must be its derivative with respect to e.q
//   margin(e, p)                            1 when unloaded; the element breaks where it is <= 0
//   static constexpr std::uint32_t invariant        SPRINGNET_LENGTH unless given
//   static constexpr bool reads_rate                see SpringFunction, ViscosityFunction
//   static constexpr bool acts_in_compression       true unless given
//   static constexpr Parameter states[], inputs[]   internal state (preset = value at the start), input signals
//   state_rates(e, p)                       std::array<Real, S>: dz/dt of the S states
//   static Table prepare(const TableSource&)        data made once for a material, read as: const Table& t = e.table
//
// The functions must be pure: they read only their arguments and may be called from any thread. A result that is not
// finite ends the run with an error that names the law and the spring.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include <springnet/sdk/component.hpp>
#include <springnet/sdk/kernel.hpp>
#include <springnet/sdk/math/members.hpp>

namespace springnet::sdk {

// A law's table, converted to the type that its prepare() returned.
class TableView {
 public:
  SPRINGNET_INLINE explicit constexpr TableView(const void* table) : table_(table) {}
  template <class Table>
  SPRINGNET_INLINE operator const Table&() const {  // NOLINT(google-explicit-constructor)
    return *static_cast<const Table*>(table_);
  }

 private:
  const void* table_;
};

// The inputs of a law for one element, besides its parameters.
template <class Real>
struct Element {
  Real q;          // the invariant: length, m; or relative speed, m/s
  Real rate;       // dq/dt, if the law declares reads_rate
  Real reference;  // rest length, m
  double time;     // s
  TableView table;
  const Real* states;
  const Real* inputs;

  [[nodiscard]] SPRINGNET_INLINE Real elongation() const { return q - reference; }            // m
  [[nodiscard]] SPRINGNET_INLINE Real strain() const { return (q - reference) / reference; }  // 1
  [[nodiscard]] SPRINGNET_INLINE const Real& state(std::size_t index) const { return states[index]; }
  [[nodiscard]] SPRINGNET_INLINE const Real& input(std::size_t index) const { return inputs[index]; }
};

// Laws without `static constexpr bool reads_rate = true` are compiled once with elements whose rate has this type,
// which has no operations: a compiler error that mentions it means that the law reads e.rate.
struct ReadsRateIsNotDeclared {};
using Rateless = Dual<7>;
template <>
struct Element<Rateless> {
  using Real = Rateless;
  Real q;
  ReadsRateIsNotDeclared rate;
  Real reference;
  double time;
  TableView table;
  const Real* states;
  const Real* inputs;
  [[nodiscard]] Real elongation() const { return q - reference; }
  [[nodiscard]] Real strain() const { return (q - reference) / reference; }
  [[nodiscard]] const Real& state(std::size_t index) const { return states[index]; }
  [[nodiscard]] const Real& input(std::size_t index) const { return inputs[index]; }
};

// Named arrays of a scene, from which a law makes its table.
class TableSource {
 public:
  explicit TableSource(const springnet_table_source& source) : source_(&source) {}
  // Empty if the scene has none under that name. Valid during prepare().
  [[nodiscard]] std::span<const double> array(const char* name) const {
    std::uint64_t count = 0;
    const double* values = source_->array(source_->context, name, &count);
    return {values, values == nullptr ? 0 : static_cast<std::size_t>(count)};
  }

 private:
  const springnet_table_source* source_;
};

// Properties deduced from a law's class.
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
  static constexpr std::size_t parameter_count = parameters_of<Law>().size();
  static constexpr std::size_t state_count = StateList::get().size();
  static constexpr std::size_t input_count = InputList::get().size();

  static constexpr bool has_force = requires(const Element<Dual<0>>& e, const Parameters<Dual<0>>& p) {
    Dual<0>{Law::force(e, p)};
  };
  static constexpr bool has_energy = requires(const Element<Dual<0>>& e, const Parameters<Dual<0>>& p) {
    Dual<0>{Law::energy(e, p)};
  };
  static constexpr bool has_margin = requires(const Element<Dual<0>>& e, const Parameters<Dual<0>>& p) {
    Dual<0>{Law::margin(e, p)};
  };
  static constexpr bool has_state_rates = requires(const Element<Dual<0>>& e, const Parameters<Dual<0>>& p) {
    Law::state_rates(e, p)[0];
  };
  static constexpr bool has_table = requires(const TableSource& source) { Law::prepare(source); };
  static constexpr bool reads_rate = Law::reads_rate && Law::invariant != SPRINGNET_RELATIVE_SPEED;

  // Compiles the formulas for elements without a rate.
  static constexpr bool rate_is_declared() {
    using Real = Rateless;
    if constexpr (!reads_rate) {
      return +[](const Element<Real>& e, const Parameters<Real>& p) {
        static_cast<void>(Law::force(e, p));
        if constexpr (has_energy) static_cast<void>(Law::energy(e, p));
        if constexpr (has_margin) static_cast<void>(Law::margin(e, p));
        if constexpr (has_state_rates) static_cast<void>(Law::state_rates(e, p));
      } != nullptr;
    }
    return true;
  }
  static constexpr std::uint32_t flag(bool present, std::uint32_t value) { return present ? value : 0u; }
  static constexpr std::uint32_t capabilities =
      SPRINGNET_HAS_DERIVATIVES | flag(parameter_count > 0, SPRINGNET_HAS_PARAMETER_DERIVATIVES) |
      flag(has_energy, SPRINGNET_HAS_ENERGY) | flag(has_margin, SPRINGNET_HAS_RUPTURE) |
      flag(Law::acts_in_compression, SPRINGNET_ACTS_IN_COMPRESSION) | flag(reads_rate, SPRINGNET_READS_RATE) |
      flag(state_count > 0, SPRINGNET_HAS_STATE_DERIVATIVES);
};

// The loops over a tile.
template <class Law>
class LawKernel {
  using Traits = LawTraits<Law>;
  static constexpr std::size_t P = Traits::parameter_count;
  static constexpr std::size_t S = Traits::state_count;
  static constexpr std::size_t I = Traits::input_count;
  static constexpr std::size_t N = 1 + P + I;  // streams

 public:
  SPRINGNET_INLINE static void run(const springnet_law_batch& b) {
    // Reference values, parameters and inputs in one list; a host without a reference value gives null.
    static constexpr double no_reference = 0.0;
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
    const detail::Streams<N, true> streams(arrays.data(), strides.data(), b.count);

    for (std::uint32_t begin = 0; begin < b.count; begin += detail::chunk_size) {
      Chunk chunk{};
      chunk.begin = begin;
      chunk.count = std::min(detail::chunk_size, b.count - begin);
      chunk.q = b.q + begin;
      chunk.rate = Traits::reads_rate ? b.rate + begin : nullptr;
      chunk.time = b.time;
      chunk.table = b.table;
      for (std::size_t j = 0; j < S; ++j) chunk.states[j] = b.states[j] + begin;
      for (std::size_t j = 0; j < N; ++j) chunk.streams[j] = streams.at(j, begin);
      if (streams.uniform())
        evaluate<Varying::nothing>(b, chunk);
      else if (streams.rest_is_uniform())
        evaluate<Varying::reference>(b, chunk);
      else
        evaluate<Varying::all>(b, chunk);
    }
  }

 private:
  // What differs between the elements of a batch: springs of one material in a mesh have rest lengths of their own.
  enum class Varying { nothing, reference, all };

  struct Chunk {
    std::uint32_t begin, count;
    const double* q;
    const double* rate;
    double time;
    const void* table;
    std::array<const double*, S> states;
    std::array<const double*, N> streams;  // reference value, parameters, inputs
  };

  // The arguments of a formula for one element.
  template <class Real>
  struct Arguments {
    std::array<Real, P> parameters;
    std::array<Real, S> states;
    std::array<Real, I> inputs;
    Element<Real> element;

    template <Varying varying>
    SPRINGNET_INLINE Arguments(const Chunk& c, const std::array<double, N>& constants, std::uint32_t i,
                               std::integral_constant<Varying, varying>)
        : element{c.q[i],
                  0.0,
                  varying == Varying::nothing ? constants[0] : c.streams[0][i],
                  c.time,
                  TableView(c.table),
                  states.data(),
                  inputs.data()} {
      if constexpr (Traits::reads_rate) element.rate = c.rate[i];
      for (std::size_t j = 0; j < P; ++j)
        parameters[j] = varying != Varying::all ? constants[1 + j] : c.streams[1 + j][i];
      for (std::size_t j = 0; j < I; ++j)
        inputs[j] = varying != Varying::all ? constants[1 + P + j] : c.streams[1 + P + j][i];
      for (std::size_t j = 0; j < S; ++j) states[j] = c.states[j][i];
    }
    Arguments(const Arguments&) = delete;  // element points into it
    Arguments& operator=(const Arguments&) = delete;
    [[nodiscard]] SPRINGNET_INLINE Parameters<Real> values() const { return Parameters<Real>(parameters.data()); }
  };

  template <Varying varying>
  SPRINGNET_INLINE static std::array<double, N> constants(const Chunk& c) {
    std::array<double, N> result{};
    if constexpr (varying != Varying::all) {
      for (std::size_t j = 0; j < N; ++j) result[j] = *c.streams[j];
    }
    return result;
  }

  struct Force {
    template <class Real>
    SPRINGNET_INLINE static Real of(const Element<Real>& e, const Parameters<Real>& p) {
      return Law::force(e, p);
    }
  };
  struct Energy {
    template <class Real>
    SPRINGNET_INLINE static Real of(const Element<Real>& e, const Parameters<Real>& p) {
      return Law::energy(e, p);
    }
  };
  struct Margin {
    template <class Real>
    SPRINGNET_INLINE static Real of(const Element<Real>& e, const Parameters<Real>& p) {
      return Law::margin(e, p);
    }
  };

  template <class Quantity, Varying varying>
  SPRINGNET_INLINE static void values(const Chunk& c, double* array) {
    double* __restrict out = array + c.begin;
    const auto fixed = constants<varying>(c);
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const Arguments<Dual<0>> a(c, fixed, i, std::integral_constant<Varying, varying>{});
      out[i] = Quantity::of(a.element, a.values()).value;
    }
  }
  template <Varying varying>
  SPRINGNET_INLINE static void state_rates(const Chunk& c, double* const* arrays) {
    const auto fixed = constants<varying>(c);
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const Arguments<Dual<0>> a(c, fixed, i, std::integral_constant<Varying, varying>{});
      const std::array<Dual<0>, S> rates = Law::state_rates(a.element, a.values());
      for (std::size_t j = 0; j < S; ++j) {
        if (arrays[j] != nullptr) arrays[j][c.begin + i] = rates[j].value;
      }
    }
  }
  // dQ/dq, and dQ/dq' for a law that reads it; either output may be null.
  template <Varying varying>
  SPRINGNET_INLINE static void derivatives(const Chunk& c, double* by_q, double* by_rate) {
    double unwanted[detail::chunk_size];
    double* __restrict out_q = by_q != nullptr ? by_q + c.begin : unwanted;
    const auto fixed = constants<varying>(c);
    if constexpr (Traits::reads_rate) {
      double unwanted_too[detail::chunk_size];
      double* __restrict out_rate = by_rate != nullptr ? by_rate + c.begin : unwanted_too;
      for (std::uint32_t i = 0; i < c.count; ++i) {
        Arguments<Dual<2>> a(c, fixed, i, std::integral_constant<Varying, varying>{});
        a.element.q.derivatives[0] = 1.0;
        a.element.rate.derivatives[1] = 1.0;
        const Dual<2> force = Law::force(a.element, a.values());
        out_q[i] = force.derivatives[0];
        out_rate[i] = force.derivatives[1];
      }
    } else {
      if (by_rate != nullptr) std::fill_n(by_rate + c.begin, c.count, 0.0);
      if (by_q == nullptr) return;
      for (std::uint32_t i = 0; i < c.count; ++i) {
        Arguments<Dual<1>> a(c, fixed, i, std::integral_constant<Varying, varying>{});
        a.element.q.derivatives[0] = 1.0;
        const Dual<1> force = Law::force(a.element, a.values());
        out_q[i] = force.derivatives[0];
      }
    }
  }
  // dQ/d(parameter `index`), or dQ/d(state `index`).
  template <Varying varying, bool of_state>
  SPRINGNET_INLINE static void derivative_by(std::size_t index, const Chunk& c, double* array) {
    double* __restrict out = array + c.begin;
    const auto fixed = constants<varying>(c);
    for (std::uint32_t i = 0; i < c.count; ++i) {
      Arguments<Dual<1>> a(c, fixed, i, std::integral_constant<Varying, varying>{});
      auto& variables = [&]() -> auto& {
        if constexpr (of_state)
          return a.states;
        else
          return a.parameters;
      }
      ();
      for (std::size_t j = 0; j < variables.size(); ++j) variables[j].derivatives[0] = j == index ? 1.0 : 0.0;
      const Dual<1> force = Law::force(a.element, a.values());
      out[i] = force.derivatives[0];
    }
  }

  template <Varying varying>
  SPRINGNET_INLINE static void evaluate(const springnet_law_batch& b, const Chunk& c) {
    if (b.force != nullptr) values<Force, varying>(c, b.force);
    if constexpr (Traits::has_energy) {
      if (b.energy != nullptr) values<Energy, varying>(c, b.energy);
    }
    if constexpr (Traits::has_margin) {
      if (b.margin != nullptr) values<Margin, varying>(c, b.margin);
    }
    if constexpr (Traits::has_state_rates) {
      if (b.state_rates != nullptr) state_rates<varying>(c, b.state_rates);
    }
    if (b.force_by_q != nullptr || b.force_by_rate != nullptr) {
      derivatives<varying>(c, b.force_by_q, b.force_by_rate);
    }
    if (b.force_by_parameters != nullptr) {
      for (std::size_t j = 0; j < P; ++j) {
        if (b.force_by_parameters[j] != nullptr) derivative_by<varying, false>(j, c, b.force_by_parameters[j]);
      }
    }
    if (b.force_by_states != nullptr) {
      for (std::size_t j = 0; j < S; ++j) {
        if (b.force_by_states[j] != nullptr) derivative_by<varying, true>(j, c, b.force_by_states[j]);
      }
    }
  }
};

template <class Law>
struct LawGlue {
  using Traits = LawTraits<Law>;
  static_assert(Traits::has_force, "a law needs: static auto force(const auto& e, const auto& p)");
  static_assert((Traits::state_count > 0) == Traits::has_state_rates,
                "a law with `states` needs state_rates(e, p), and one with state_rates(e, p) needs `states`");
  static_assert(Traits::rate_is_declared());

  static constexpr std::uint32_t capabilities = Traits::capabilities;

  static springnet_status evaluate(const springnet_law_batch* batch) noexcept {
    if (batch->struct_size < SPRINGNET_SIZE_TO(springnet_law_batch, message)) return SPRINGNET_FAILED;
    if (const char* mistake = mistake_in(*batch)) {
      detail::write_message(batch->message, mistake);
      return SPRINGNET_FAILED;
    }
    return detail::guarded(batch->message, [batch]() -> springnet_status {
      detail::run<LawKernel<Law>>(*batch);
      return SPRINGNET_OK;
    });
  }

  static springnet_status prepare(const springnet_table_source* source, void** table,
                                  springnet_message* message) noexcept {
    *table = nullptr;
    return detail::guarded(message, [&]() -> springnet_status {
      if constexpr (Traits::has_table) {
        const TableSource arrays(*source);
        *table = new auto(Law::prepare(arrays));
      }
      return SPRINGNET_OK;
    });
  }
  static void release(void* table) noexcept {
    if constexpr (Traits::has_table) {
      delete static_cast<decltype(Law::prepare(std::declval<const TableSource&>()))*>(table);
    }
  }

  static constexpr springnet_law implementation{sizeof(springnet_law),
                                                Law::invariant,
                                                static_cast<std::uint32_t>(Traits::state_count),
                                                static_cast<std::uint32_t>(Traits::input_count),
                                                ParameterTable<typename Traits::StateList>::pointer,
                                                ParameterTable<typename Traits::InputList>::pointer,
                                                &evaluate,
                                                Traits::has_table ? &prepare : nullptr,
                                                Traits::has_table ? &release : nullptr};

 private:
  // Describes a violation of the contract by the host; null if there is none.
  static const char* mistake_in(const springnet_law_batch& b) noexcept {
    if (b.q == nullptr) return "the host gave no invariant";
    if (Traits::reads_rate && b.rate == nullptr) return "the law reads the rate, which the host did not give";
    if (!Traits::has_energy && b.energy != nullptr) return "the host asked for an energy, which the law does not have";
    if (!Traits::has_margin && b.margin != nullptr) return "the host asked for a margin, which the law does not have";
    if (Traits::has_table && b.table == nullptr) return "the host did not prepare the table of the law";
    return nullptr;
  }
};

// Base of spring functions. They do not read the rate unless they declare `static constexpr bool reads_rate = true`.
struct SpringFunction : ElementaryFunctions {
  static constexpr std::uint32_t kind = SPRINGNET_SPRING_FUNCTION;
  static constexpr std::uint32_t invariant = SPRINGNET_LENGTH;
  static constexpr bool reads_rate = false;
  static constexpr bool acts_in_compression = true;
  template <class Law>
  using Glue = LawGlue<Law>;
};

// Base of viscosity functions: on SPRINGNET_LENGTH they read e.rate and act along the spring; on
// SPRINGNET_RELATIVE_SPEED they read the speed e.q and act along the relative velocity.
struct ViscosityFunction : ElementaryFunctions {
  static constexpr std::uint32_t kind = SPRINGNET_VISCOSITY_FUNCTION;
  static constexpr std::uint32_t invariant = SPRINGNET_LENGTH;
  static constexpr bool reads_rate = true;
  static constexpr bool acts_in_compression = true;
  template <class Law>
  using Glue = LawGlue<Law>;
};

}  // namespace springnet::sdk
