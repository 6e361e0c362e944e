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
// Beside force() a class may have, each named in `using has = Has<…>;`, so that a misspelt name is an error:
//   Energy   energy(e, p)                   J; force must be its derivative with respect to e.q
//   Margin   margin(e, p)                   1 when unloaded; the element breaks where it is <= 0
//   Update   update(e, p, step)             std::array<Real, S>: the states at the end of a step (law/element.hpp)
//   Start    start(e, p)                    std::array<Real, S>: the states at the start, if not as declared
// A law may give its energy alone, without force(): its force is then the derivative. And without being named there:
//   static constexpr Scalar invariants[]    up to seven scalars of the nodes of a `shape`, in place of one: force()
//   then
//                                           returns std::array<Real, N>, and e.q[i], e.rate[i], e.reference[i] are
//                                           read (law/invariants.hpp)
//   static constexpr Parameter states[]     internal state, with bounds and scale (preset = value at the start), and
//   state_rates(e, p)                       std::array<Real, S>: dz/dt of the S states
//   static constexpr Parameter inputs[]     input signals (preset = where a scene gives none)
//   static constexpr Table tables[]         arrays of numbers, and
//   prepare(const TableSource&)             what is made of them once for a material, read as e.table: an object of
//                                           any type; table.hpp has curves
//   static constexpr …                      what LawDefaults below lists: what the law reads, and what it promises
//
// The functions must be pure: they read only their arguments (and constant members, in a law of a host) and may be
// called from any thread. A result that is not finite ends the run with an error that names the law and the spring.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include <springnet/sdk/component.hpp>
#include <springnet/sdk/law/kernel.hpp>
#include <springnet/sdk/law/update.hpp>
#include <springnet/sdk/math/members.hpp>
#include <springnet/sdk/polynomial.hpp>

namespace springnet::sdk {

// springnet_law for a law's class. A context is an object of it; a null pointer stands for one without members.
template <class Law>
struct LawGlue {
  using Traits = LawTraits<Law>;
  static constexpr std::size_t S = Traits::state_count;

  static constexpr std::uint64_t capabilities = Traits::capabilities;
  static constexpr std::uint64_t needs = Traits::needs;
  static constexpr std::uint32_t needs_minor = Traits::several ? 1 : 0;

  static springnet_status evaluate(void* context, const springnet_law_batch* batch) noexcept {
    if (batch->struct_size < SPRINGNET_SIZE_TO(springnet_law_batch, message)) return SPRINGNET_FAILED;
    springnet_law_batch older;  // of a host of ABI 2.0
    batch = &complete(*batch, older);
    if (const char* mistake = mistake_in(*batch)) return refuse(batch->message, mistake);
    return detail::guarded(batch->message, [&]() -> springnet_status {
      detail::run<LawKernel<Law>>(typename LawKernel<Law>::Call{law(context), batch, batch->instruction_set});
      return SPRINGNET_OK;
    });
  }

  static springnet_status update(void* context, const springnet_law_update* update) noexcept {
    if (update->struct_size < SPRINGNET_SIZE_TO(springnet_law_update, next_by_parameters)) return SPRINGNET_FAILED;
    springnet_law_batch older;
    const springnet_law_batch& batch = complete(*update->batch, older);
    springnet_law_update whole{};
    std::memcpy(&whole, update, std::min<std::size_t>(update->struct_size, sizeof whole));
    whole.batch = &batch;
    update = &whole;
    if (const char* mistake = mistake_in(batch)) return refuse(batch.message, mistake);
    if (!(update->time_step > 0.0)) return refuse(batch.message, "the host asked for a step that takes no time");
    const bool reads_start = update->order >= 2 || Traits::has_update;
    const bool lacks_start = Traits::several
                                 ? lacks(update->start_values, update->start_rates)
                                 : update->start_q == nullptr || (Traits::reads_rate && update->start_rate == nullptr);
    if (reads_start && lacks_start)
      return refuse(batch.message, "the host did not give the invariant at the start of the step");
    return detail::guarded(batch.message, [&]() -> springnet_status {
      if constexpr (S > 0) {
        bool found = true;
        detail::run<UpdateKernel<Law>>(
            typename UpdateKernel<Law>::Call{law(context), update, batch.instruction_set, &found});
        if (found && batch.derivatives != nullptr) found = UpdateKernel<Law>::run_matrix(*law(context), *update);
        if (!found) {
          detail::write_message(batch.message,
                                "no internal state satisfies the equation of its step within the bounds that the law "
                                "declares");
          return SPRINGNET_RECOVERABLE;
        }
      }
      return SPRINGNET_OK;
    });
  }

  static springnet_status start(void* context, const springnet_law_start* start) noexcept {
    if (start->struct_size < SPRINGNET_SIZE_TO(springnet_law_start, states)) return SPRINGNET_FAILED;
    if (const char* mistake = mistake_in(*start->batch)) return refuse(start->batch->message, mistake);
    return detail::guarded(start->batch->message, [&]() -> springnet_status {
      if constexpr (Traits::has_start) {
        detail::for_each_chunk(*law(context), *start->batch, [&](const detail::LawChunk<Law>& chunk, auto kind) {
          const auto fixed = detail::constants_of<decltype(kind)::value>(chunk);
          for (std::uint32_t i = 0; i < chunk.count; ++i) {
            const detail::LawArguments<Law, Dual<0>> a(chunk, fixed, i, kind);
            const std::array<Dual<0>, S> states = chunk.law->start(a.element, a.values());
            for (std::size_t j = 0; j < S; ++j) start->states[j][chunk.begin + i] = states[j].value;
          }
        });
      }
      return SPRINGNET_OK;
    });
  }

  static springnet_status prepare(void* context, springnet_preparation* preparation) noexcept {
    if (preparation->struct_size < SPRINGNET_SIZE_TO(springnet_preparation, message)) return SPRINGNET_FAILED;
    preparation->prepared = nullptr;
    if (preparation->table_count < Traits::table_count)
      return refuse(preparation->message, "the host does not know all tables of the law");
    return detail::guarded(preparation->message, [&]() -> springnet_status {
      if constexpr (Traits::table_count > 0) {
        const TableSource source(*preparation);
        preparation->prepared = new typename Traits::Table(law(context)->prepare(source));
      }
      return SPRINGNET_OK;
    });
  }
  static springnet_status release(void*, springnet_preparation* preparation) noexcept {
    if constexpr (Traits::table_count > 0) delete static_cast<typename Traits::Table*>(preparation->prepared);
    preparation->prepared = nullptr;
    return SPRINGNET_OK;
  }

  // With a context, which must outlive all uses.
  static constexpr springnet_law with(void* context) {
    return {sizeof(springnet_law),
            Traits::several ? std::uint32_t{SPRINGNET_SEVERAL} : Law::invariant,
            static_cast<std::uint32_t>(S),
            static_cast<std::uint32_t>(Traits::input_count),
            static_cast<std::uint32_t>(Traits::table_count),
            Traits::has_update ? static_cast<std::uint32_t>(Law::update_order) : 2u,
            Traits::has_update ? 1u : 0u,
            0,
            ParameterTable<typename Traits::StateList>::pointer,
            ParameterTable<typename Traits::InputList>::pointer,
            TableTable<typename Traits::TableList>::pointer,
            Law::smallest_stretch,
            Law::largest_stretch,
            context,
            &evaluate,
            S > 0 ? &update : nullptr,
            Traits::has_start ? &start : nullptr,
            Traits::table_count > 0 ? &prepare : nullptr,
            Traits::table_count > 0 ? &release : nullptr,
            static_cast<std::uint32_t>(Law::shape),
            Traits::several ? static_cast<std::uint32_t>(Traits::invariant_count) : 0u,
            detail::ScalarTable<typename Traits::InvariantList>::pointer,
            Law::reads_direction ? 1u : 0u,
            0};
  }

 private:
  static constexpr springnet_law without_object() {
    static_assert(std::is_empty_v<Law> && std::is_default_constructible_v<Law>,
                  "a law of a plugin has no members, for there is no object of it; a program gives one with members to "
                  "springnet::spring_function or viscosity_function (host_laws.hpp)");
    return with(nullptr);
  }

 public:
  static constexpr springnet_law implementation = without_object();

 private:
  static const Law* law(void* context) noexcept {
    if constexpr (std::is_empty_v<Law> && std::is_default_constructible_v<Law>) {
      static constexpr Law without_members{};
      return &without_members;
    } else {
      return static_cast<const Law*>(context);
    }
  }
  static springnet_status refuse(springnet_message* message, const char* why) noexcept {
    detail::write_message(message, why);
    return SPRINGNET_FAILED;
  }
  // A batch with the fields of this version: those that an older host does not have are null.
  static const springnet_law_batch& complete(const springnet_law_batch& batch, springnet_law_batch& memory) noexcept {
    if (batch.struct_size >= SPRINGNET_SIZE_TO(springnet_law_batch, derivatives)) return batch;
    memory = {};
    std::memcpy(&memory, &batch, std::min<std::size_t>(batch.struct_size, sizeof memory));
    return memory;
  }
  // Of a law over several invariants: whether values or rates that it reads are missing.
  static bool lacks(const double* const* values, const double* const* rates) noexcept {
    for (std::size_t j = 0; j < Traits::invariant_count; ++j) {
      if (!Traits::reads_value(j)) continue;
      if (values == nullptr || values[j] == nullptr) return true;
      if (Traits::reads_rate && (rates == nullptr || rates[j] == nullptr)) return true;
    }
    return false;
  }
  // Describes a violation of the contract by the host; null if there is none.
  static const char* mistake_in(const springnet_law_batch& b) noexcept {
    if constexpr (Traits::several) {
      if (lacks(b.values, b.rates)) return "the host did not give all invariants that the law reads, or their rates";
      for (std::size_t j = 0; j < Traits::invariant_count; ++j)
        if (b.references == nullptr || b.references[j] == nullptr) return "the host gave no reference values";
      for (std::size_t j = 0; Law::reads_direction && j < 3; ++j)
        if (b.direction == nullptr || b.direction[j] == nullptr) return "the host gave no direction";
    } else {
      if (b.q == nullptr) return "the host gave no invariant";
      if (Traits::reads_rate && b.rate == nullptr) return "the law reads the rate, which the host did not give";
    }
    if (!Traits::has_energy && (b.energy != nullptr || b.energy_by_q != nullptr))
      return "the host asked for an energy, which the law does not have";
    if (!Traits::has_margin && b.margin != nullptr) return "the host asked for a margin, which the law does not have";
    if (Traits::table_count > 0 && b.table == nullptr) return "the host did not prepare the table of the law";
    if (S > 0 && b.states == nullptr) return "the host gave no internal state";
    return nullptr;
  }
};

// What spring functions and viscosity functions declare unless their class says otherwise.
struct LawDefaults : ElementaryFunctions {
  using has = Has<>;
  static constexpr std::uint32_t invariant = SPRINGNET_LENGTH;
  static constexpr bool acts_in_compression = true;
  static constexpr bool reads_time = false;
  static constexpr bool monotone = false;
  static constexpr bool not_zero_at_rest = false;
  static constexpr bool adds_power = false;
  static constexpr bool calling_thread_only = false;
  static constexpr bool fits_elements = false;
  static constexpr bool divides_by_reference = false;
  static constexpr double smallest_stretch = 0.0;
  static constexpr double largest_stretch = std::numeric_limits<double>::infinity();
  static constexpr int update_order = 1;
  static constexpr bool smooth_rates = false;
  // Of a law with a list of invariants: the nodes of its elements, and whether these have a direction.
  static constexpr Shape shape = Shape::none;
  static constexpr bool reads_direction = false;
  template <class Law>
  using Glue = LawGlue<Law>;
};

// Base of spring functions. They do not read the rate unless they declare `static constexpr bool reads_rate = true`.
struct SpringFunction : LawDefaults {
  static constexpr std::uint32_t kind = SPRINGNET_SPRING_FUNCTION;
  static constexpr bool reads_rate = false;
};

// Base of viscosity functions: on SPRINGNET_LENGTH they read e.rate and act along the spring; on
// SPRINGNET_RELATIVE_SPEED they read the speed e.q and act along the relative velocity.
struct ViscosityFunction : LawDefaults {
  static constexpr std::uint32_t kind = SPRINGNET_VISCOSITY_FUNCTION;
  static constexpr bool reads_rate = true;
};

}  // namespace springnet::sdk
