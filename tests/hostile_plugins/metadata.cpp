// Descriptions of plugins with a few fields changed at random: refused with a reason, or taken and usable.
#include <array>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <springnet/plugin_host.hpp>
#include <springnet/printable.hpp>

#include "child.hpp"
#include "hosts.hpp"
#include "nets.hpp"
#include "repetitions.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

springnet_status evaluate(void*, const springnet_law_batch* batch) {
  for (std::uint32_t i = 0; i < batch->count; ++i) {
    if (batch->force != nullptr) batch->force[i] = batch->q[i] - 1.0;
    for (double* values : {batch->energy, batch->force_by_q, batch->force_by_rate, batch->margin})
      if (values != nullptr) values[i] = 1.0;
  }
  return SPRINGNET_OK;
}

// A plugin of one law with two parameters, in memory that can be changed.
struct Description {
  static constexpr const char* names[] = {"soft", "hard"};
  std::array<const char*, 2> choices{names[0], names[1]};
  springnet_parameter stiffness{
      sizeof(springnet_parameter), SPRINGNET_NUMBER, "stiffness", "N/m", "of it", 1.0, 0.0, 10.0, 1.0, 0, 0, nullptr};
  springnet_parameter kind{
      sizeof(springnet_parameter), SPRINGNET_CHOICE, "kind", "1", "of it", 0.0, 0.0, 1.0, 1.0, 0, 2, choices.data()};
  std::array<const springnet_parameter*, 2> parameters{&stiffness, &kind};
  springnet_law law = [] {
    springnet_law result{};
    result.struct_size = sizeof result;
    result.invariant = SPRINGNET_LENGTH;
    result.update_order = 1;
    result.largest_stretch = std::numeric_limits<double>::infinity();
    result.evaluate = evaluate;
    return result;
  }();
  springnet_component component{
      sizeof(springnet_component), SPRINGNET_SPRING_FUNCTION, "hostile", "", "", 0, 0, 0, 2, parameters.data(), &law};
  std::array<const springnet_component*, 1> components{&component};
  springnet_plugin plugin{SPRINGNET_MAGIC,
                          sizeof(springnet_plugin),
                          SPRINGNET_ABI_MAJOR,
                          SPRINGNET_ABI_MINOR,
                          0,
                          1,
                          0,
                          "test.hostile",
                          "1",
                          "tests",
                          "MIT",
                          components.data()};
};

// Changes one field. Counts never lie between what there is and what no plugin has: that nobody can see.
class Mutation {
 public:
  Mutation(std::uint64_t seed, Description& d) : random_(seed), long_text_(1'000'000, 'x'), d_(d) {}

  void once() {
    switch (pick(29)) {
      case 0:
        return set(d_.plugin.magic, {0, 1, ~std::uint64_t{0}});
      case 1:
        return set(d_.plugin.struct_size, sizes(sizeof d_.plugin));
      case 2:
        return set(d_.plugin.abi_major, {0, 1, 2, 0xffffffffu});
      case 3:
        return set(d_.plugin.component_count, {0, 1, 4097, 0xffffffffu});
      case 4:
        return set(d_.plugin.id, texts());
      case 5:
        return set(d_.plugin.version, texts());
      case 6:
        return set(d_.plugin.licence, texts());
      case 7:
        return set(d_.plugin.components, {nullptr, d_.components.data()});
      case 8:
        return set(d_.components[0], {nullptr, &d_.component});
      case 9:
        return set(d_.component.struct_size, sizes(sizeof d_.component));
      case 10:
        return set(d_.component.kind, {0, 1, 2, 5, 0xffffffffu});
      case 11:
        return set(d_.component.id, texts());
      case 12:
        return set(d_.component.summary, texts());
      case 13:
        return set(d_.component.capabilities, {0, 1, 8, 0xffffffffu, ~std::uint64_t{0}});
      case 14:
        return set(d_.component.parameter_count, {0, 1, 2, 4097, 0xffffffffu});
      case 15:
        return set(d_.component.implementation, {nullptr, static_cast<const void*>(&d_.law)});
      case 16:
        return set(d_.law.struct_size, sizes(sizeof d_.law));
      case 17:
        return set(d_.law.invariant, {0, 1, 2, 3, 6, 7, 0xffffffffu});
      case 18:
        return set(d_.law.state_count, {0, 1, 4097, 0xffffffffu});
      case 19:
        return set(d_.law.evaluate, {nullptr, evaluate});
      case 20:
        return set(d_.parameters[pick(2)], {nullptr, &d_.stiffness, &d_.kind});
      case 21:
        return set(d_.plugin.needs_minor, {0, 1, 0xffffffffu});
      case 22:
        return set(d_.component.needs, {0, 1, 7, 8, ~std::uint64_t{0}});
      case 23:
        return set(d_.component.needs_minor, {0, 1, 0xffffffffu});
      case 24:
        return set(d_.law.input_count, {0, 1, 4097, 0xffffffffu});
      case 25:
        return set(d_.law.table_count, {0, 1, 4097, 0xffffffffu});
      case 26:
        return set(d_.law.update_order, {0, 1, 2, 3, 0xffffffffu});
      case 27:
        return set(pick(2) == 0 ? d_.law.smallest_stretch : d_.law.largest_stretch, numbers());
      default:
        return change(pick(2) == 0 ? d_.stiffness : d_.kind);
    }
  }

 private:
  void change(springnet_parameter& parameter) {
    switch (pick(11)) {
      case 0:
        return set(parameter.struct_size, sizes(sizeof parameter));
      case 1:
        return set(parameter.type, {0, 1, 2, 4, 0xffffffffu});
      case 2:
        return set(parameter.name, texts());
      case 3:
        return set(parameter.unit, texts());
      case 4:
        return set(parameter.summary, texts());
      case 5:
        return set(parameter.default_value, numbers());
      case 6:
        return set(parameter.smallest, numbers());
      case 7:
        return set(parameter.largest, numbers());
      case 8:
        return set(parameter.scale, numbers());
      case 9:
        return set(parameter.flags, {0, 1, 2, 4, 0xffffffffu});
      default:
        return set(d_.choices[pick(2)], texts());
    }
  }
  std::size_t pick(std::size_t count) { return random_() % count; }
  template <class T>
  void set(T& field, const std::vector<T>& values) {
    field = values[pick(values.size())];
  }
  static std::vector<std::uint32_t> sizes(std::size_t own) {
    const auto size = static_cast<std::uint32_t>(own);
    return {0, 1, 4, 8, size / 2, size - 1, size, size + 64};
  }
  static std::vector<double> numbers() {
    constexpr double inf = std::numeric_limits<double>::infinity();
    return {std::numeric_limits<double>::quiet_NaN(), inf, -inf, -1.0, 0.0, 0.5, 1.0, 1e308, -1e308, 5e-324};
  }
  [[nodiscard]] std::vector<const char*> texts() const {
    return {nullptr, "",          "\x1b[2J",    "\xff\xfe",     "type",
            "none",  "mass",      "UPPER case", "a\nb\rc\t",    "hostile",
            "soft",  "stiffness", "{} {}",      "\u202e\u200b", long_text_.c_str()};
  }

  std::mt19937_64 random_;
  std::string long_text_;
  Description& d_;
};

bool is_printable(const std::string& text) { return printable_message(text) == text && text.size() < 20'000; }

// Everything a host may do with a plugin that it took.
std::string use(const PluginHost& host, const springnet_plugin& plugin) {
  const Component& component = *host.components().front();
  try {
    static_cast<void>(complete_parameters(*component.description, {}, "hostile"));
    for (const char* name : {"stiffness", "kind", "nonsense"}) {
      for (const double value : {-1.0, 0.5, 1e300, std::numeric_limits<double>::quiet_NaN()}) try {
          static_cast<void>(complete_parameters(*component.description, {{name, value}}, "hostile"));
        } catch (const Error& error) {
          if (!is_printable(error.what())) return "an error that is not printable: " + printable(error.what(), 300);
        }
    }
  } catch (const Error& error) {
    if (!is_printable(error.what())) return "an error that is not printable: " + printable(error.what(), 300);
  }
  SimulationOptions options;
  options.time_step = 0.05;
  Material material = damped(1.0, 0.1);
  (component.kind() == ComponentKind::spring_function ? material.spring : material.viscosity) =
      LawUse{std::string(component.id()), {}};
  return run_with(plugin, row(material, {}), options, {});
}

std::string try_mutation(std::uint64_t seed, bool& taken) {
  Description description;
  Mutation mutation(seed, description);
  for (std::uint64_t k = 0; k <= seed % 3; ++k) mutation.once();
  PluginHost host;
  taken = host.add(description.plugin);
  if (taken) return use(host, description.plugin);
  const std::string& reason = host.refusals().back().reason;
  if (reason.size() < 20) return "refused with few words: " + reason;
  return is_printable(reason) ? "" : "a reason that is not printable: " + printable(reason, 300);
}

}  // namespace

TEST_CASE("descriptions changed at random are refused with a reason, or can be used") {
  static_cast<void>(plugins());  // their libraries are open before the children are made
  const std::uint64_t count = repetitions("SPRINGNET_HOSTILE_PLUGINS", 100);
  for (std::uint64_t seed = 0; seed < count; ++seed) {
    bool taken = false;
    const std::string text = in_child([&] { return try_mutation(seed, taken); });
    INFO("mutation ", seed);
    CHECK(text == "");
  }
  MESSAGE(count, " changed descriptions");
}
