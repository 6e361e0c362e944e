// Laws and neurons of the program that embeds springnet: from a class, from lambdas, or from C functions, without a
// plugin's file.
//
//   struct Muscle : springnet::sdk::SpringFunction {                      // sdk/law.hpp; here it may have members
//     static constexpr const char* id = "muscle";
//     static constexpr const char* summary = "pulls with a tension that depends on its length";
//     std::vector<double> curve;
//     auto force(const auto& e, const auto&) const { … }
//   };
//   plugins.add(springnet::spring_function(Muscle{.curve = measured}));
//
//   plugins.add(springnet::spring_function(
//       springnet::describe("cubic", "T = s x^3 / l0^2", springnet::sdk::number("stiffness", "N/m", "s").at_least(0)),
//       [](const auto& e, const auto& p) { return p[0] * e.strain() * e.strain() * e.elongation(); }));
//
// Networks and scenes then name them by their ids, as those of plugins. The object, or the lambda with what it
// captures, is moved to the host and is freed with the last PluginHost and Simulation that use it. It is constant, and
// several threads read it at a time; if they must not, the law declares calling_thread_only. What its functions throw
// ends the step with an Error that names the law.
//
// Compile sources with laws as a plugin's (-ffp-contract=off …; springnet_add_law_flags(target) in CMake): results then
// do not depend on the processor.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <springnet/export.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/sdk/law.hpp>
#include <springnet/sdk/neuron.hpp>

namespace springnet {

// A component made by the program, for PluginHost::add. Copies share it.
class SPRINGNET_API HostComponent {
 public:
  // As in C: the description and all that it points to is copied, the contexts of its functions are not. `owner` keeps
  // them: std::shared_ptr<void>(context, release). Throws Error(plugin) that says what is wrong with the description;
  // `owner` is then released.
  HostComponent(const springnet_component& description, std::shared_ptr<const void> owner);

  // The same under another id: two objects of one class in one host.
  [[nodiscard]] HostComponent renamed(const std::string& id) const;

  [[nodiscard]] const springnet_component& description() const noexcept;

 private:
  struct SPRINGNET_LOCAL Copy;
  std::shared_ptr<const Copy> copy_;
};

// What formulas given as lambdas read.
enum class Reads : unsigned { nothing = 0, rate = 1, time = 2, relative_speed = 4 };

namespace detail {

constexpr bool includes(unsigned reads, Reads what) { return (reads & static_cast<unsigned>(what)) != 0; }

// A law's or neuron's glue with an object that the component owns.
template <class Class>
HostComponent component_of(Class object) {
  const auto owner = std::make_shared<Class>(std::move(object));
  const auto implementation = Class::template Glue<Class>::with(owner.get());
  return {sdk::ComponentEntry<Class>::with(&implementation), owner};
}

template <class Class, class Base>
concept IsA = std::derived_from<Class, Base>;

}  // namespace detail

// Id, summary and parameters of a law or neuron whose formulas are lambdas, and what it promises. The texts of
// parameters are copied when the component is made. `reads`: a combination of Reads.
template <std::size_t P, unsigned reads = 0>
class Description {
 public:
  std::string id, summary, literature;
  std::array<sdk::Parameter, P> parameters;
  std::uint64_t promises = SPRINGNET_ACTS_IN_COMPRESSION;
  double smallest_stretch = 0.0, largest_stretch = std::numeric_limits<double>::infinity();

  // Formulas read e.rate (those of viscosity functions do anyway), e.time.
  [[nodiscard]] auto reads_rate() const { return reading<Reads::rate>(); }
  [[nodiscard]] auto reads_time() const { return reading<Reads::time>(); }
  // e.q is the relative speed: of viscosity functions.
  [[nodiscard]] auto on_relative_speed() const { return reading<Reads::relative_speed>(); }

  [[nodiscard]] Description reference(std::string_view text) const {
    Description result = *this;
    result.literature = text;
    return result;
  }
  // As the constants of laws of these names (sdk/README.md).
  [[nodiscard]] Description monotone() const { return with(SPRINGNET_MONOTONE); }
  [[nodiscard]] Description not_zero_at_rest() const { return with(SPRINGNET_NOT_ZERO_AT_REST); }
  [[nodiscard]] Description adds_power() const { return with(SPRINGNET_ADDS_POWER); }
  [[nodiscard]] Description calling_thread_only() const { return with(SPRINGNET_CALLING_THREAD_ONLY); }
  [[nodiscard]] Description fits_elements() const { return with(SPRINGNET_FITS_ELEMENTS); }
  [[nodiscard]] Description divides_by_reference() const { return with(SPRINGNET_DIVIDES_BY_REFERENCE); }
  // It pulls, and does not push.
  [[nodiscard]] Description pulls_only() const {
    Description result = *this;
    result.promises &= ~SPRINGNET_ACTS_IN_COMPRESSION;
    return result;
  }
  // The formulas hold for these q / reference.
  [[nodiscard]] Description holds_for_stretch(double smallest, double largest) const {
    Description result = *this;
    result.smallest_stretch = smallest;
    result.largest_stretch = largest;
    return result;
  }

 private:
  template <Reads what>
  [[nodiscard]] auto reading() const {
    return Description<P, reads | static_cast<unsigned>(what)>{id,       summary,          literature,     parameters,
                                                               promises, smallest_stretch, largest_stretch};
  }
  [[nodiscard]] Description with(std::uint64_t promise) const {
    Description result = *this;
    result.promises |= promise;
    return result;
  }
};

// describe("cubic", "T = s x^3", number("stiffness", "N/m", "…").at_least(0), …)
template <std::same_as<sdk::Parameter>... Parameters>
[[nodiscard]] Description<sizeof...(Parameters)> describe(std::string_view id, std::string_view summary,
                                                          const Parameters&... parameters) {
  Description<sizeof...(Parameters)> result{};
  result.id = id;
  result.summary = summary;
  result.parameters = {parameters...};
  return result;
}

namespace detail {

struct NoFormula {};

// Classes as an author of a plugin writes them; what Description has replaces their texts.
template <class Base, std::size_t P, unsigned reads, class Force, class Energy>
struct LawOfLambdas : Base {
  static constexpr bool has_energy = !std::is_same_v<Energy, NoFormula>;
  using has = std::conditional_t<has_energy, sdk::Has<sdk::Energy>, sdk::Has<>>;
  static constexpr const char *id = "", *summary = "";
  static constexpr std::array<sdk::Parameter, P> parameters{};
  static constexpr std::uint32_t invariant =
      includes(reads, Reads::relative_speed) ? SPRINGNET_RELATIVE_SPEED : SPRINGNET_LENGTH;
  static constexpr bool reads_rate = Base::reads_rate || includes(reads, Reads::rate);
  static constexpr bool reads_time = includes(reads, Reads::time);

  Force force_of;
  Energy energy_of;
  LawOfLambdas(Force force, Energy energy) : force_of(std::move(force)), energy_of(std::move(energy)) {}
  SPRINGNET_INLINE auto force(const auto& e, const auto& p) const { return force_of(e, p); }
  SPRINGNET_INLINE auto energy(const auto& e, const auto& p) const requires has_energy { return energy_of(e, p); }
};

template <std::size_t P, class Acceleration>
struct NeuronOfLambda : sdk::Neuron {
  static constexpr const char *id = "", *summary = "";
  static constexpr std::array<sdk::Parameter, P> parameters{};

  Acceleration acceleration_of;
  explicit NeuronOfLambda(Acceleration acceleration) : acceleration_of(std::move(acceleration)) {}
  SPRINGNET_INLINE auto acceleration(const auto& n, const auto& p) const { return acceleration_of(n, p); }
};

// The component with the texts and parameters described, and the promises in place of those of the class.
template <class Class, std::size_t P, unsigned reads, class Implementation>
HostComponent described(const Description<P, reads>& given, std::shared_ptr<Class> owner,
                        const Implementation& implementation, std::uint64_t promises) {
  std::array<springnet_parameter, P> parameters;
  std::array<const springnet_parameter*, P> list;
  for (std::size_t j = 0; j < P; ++j) {
    parameters[j] = sdk::to_abi(given.parameters[j]);
    list[j] = &parameters[j];
  }
  springnet_component description = sdk::ComponentEntry<Class>::with(&implementation);
  description.id = given.id.c_str();
  description.summary = given.summary.c_str();
  description.reference = given.literature.c_str();
  description.capabilities = (description.capabilities & ~SPRINGNET_ACTS_IN_COMPRESSION) | promises;
  description.parameters = list.data();
  return {description, std::move(owner)};
}

template <class Base, std::size_t P, unsigned reads, class Force, class Energy>
HostComponent law_of(const Description<P, reads>& given, Force force, Energy energy) {
  using Law = LawOfLambdas<Base, P, reads, Force, Energy>;
  const auto owner = std::make_shared<Law>(std::move(force), std::move(energy));
  springnet_law law = sdk::LawGlue<Law>::with(owner.get());
  law.smallest_stretch = given.smallest_stretch;
  law.largest_stretch = given.largest_stretch;
  return described(given, owner, law, given.promises);
}

}  // namespace detail

// From an object of a class that derives from sdk::SpringFunction, sdk::ViscosityFunction or sdk::Neuron, with all that
// such a class may have.
template <detail::IsA<sdk::SpringFunction> Law>
[[nodiscard]] HostComponent spring_function(Law law) {
  return detail::component_of(std::move(law));
}
template <detail::IsA<sdk::ViscosityFunction> Law>
[[nodiscard]] HostComponent viscosity_function(Law law) {
  return detail::component_of(std::move(law));
}
template <detail::IsA<sdk::Neuron> Model>
[[nodiscard]] HostComponent neuron(Model model) {
  return detail::component_of(std::move(model));
}

// From generic lambdas (const auto& e, const auto& p), as `force` and `energy` of sdk/law.hpp: tension in N, and the
// energy in J whose derivative it is. Derivatives come from dual numbers. A law with rupture, states, inputs or tables
// is a class.
template <std::size_t P, unsigned reads, class Force, class Energy = detail::NoFormula>
[[nodiscard]] HostComponent spring_function(const Description<P, reads>& description, Force force, Energy energy = {}) {
  static_assert(!detail::includes(reads, Reads::relative_speed), "a spring function does not read the relative speed");
  return detail::law_of<sdk::SpringFunction>(description, std::move(force), std::move(energy));
}
template <std::size_t P, unsigned reads, class Force>
[[nodiscard]] HostComponent viscosity_function(const Description<P, reads>& description, Force force) {
  return detail::law_of<sdk::ViscosityFunction>(description, std::move(force), detail::NoFormula{});
}
// (const auto& n, const auto& p), as `acceleration` of sdk/neuron.hpp: m/s^2.
template <std::size_t P, unsigned reads, class Acceleration>
[[nodiscard]] HostComponent neuron(const Description<P, reads>& description, Acceleration acceleration) {
  static_assert(reads == 0, "a neuron reads no rate, and may read n.time without declaring it");
  using Model = detail::NeuronOfLambda<P, Acceleration>;
  const auto owner = std::make_shared<Model>(std::move(acceleration));
  return detail::described(description, owner, sdk::NeuronGlue<Model>::with(owner.get()),
                           description.promises & SPRINGNET_CALLING_THREAD_ONLY);
}

}  // namespace springnet
