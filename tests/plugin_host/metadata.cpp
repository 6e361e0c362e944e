// Descriptions of plugins that are wrong in every way that the host must detect before it uses them.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/plugin_host.hpp>

using springnet::PluginHost;

namespace {

springnet_status evaluate_law(void*, const springnet_law_batch*) { return SPRINGNET_OK; }
springnet_status update(void*, const springnet_law_update*) { return SPRINGNET_OK; }
springnet_status prepare(void*, springnet_preparation*) { return SPRINGNET_OK; }
springnet_status evaluate_neuron(void*, const springnet_neuron_batch*) { return SPRINGNET_OK; }
springnet_status create(void*, springnet_integrator_creation*) { return SPRINGNET_OK; }
springnet_status destroy(void*) { return SPRINGNET_OK; }
springnet_status advance(void*, const springnet_advance*) { return SPRINGNET_OK; }

// A plugin with a law, a neuron and an integrator that is right until a test changes it.
struct Sample {
  springnet_parameter number{
      sizeof(springnet_parameter), SPRINGNET_NUMBER, "stiffness", "N/m", "k", 1, 0, 10, 1, 0, 0, nullptr};
  const char* choice_names[2] = {"soft", "hard"};
  springnet_parameter choice{
      sizeof(springnet_parameter), SPRINGNET_CHOICE, "kind", "1", "which", 1, 0, 0, 0, 0, 2, choice_names};
  const springnet_parameter* law_parameters[2] = {&number, &choice};
  springnet_table table{sizeof(springnet_table),           SPRINGNET_INCREASING, "curve", "N", "tension", 2, 0, 0,
                        std::numeric_limits<double>::max()};
  const springnet_table* tables[1] = {&table};
  springnet_law law = [this] {
    springnet_law result{};
    result.struct_size = sizeof result;
    result.invariant = SPRINGNET_LENGTH;
    result.table_count = 1;
    result.tables = tables;
    result.update_order = 1;
    result.largest_stretch = std::numeric_limits<double>::infinity();
    result.evaluate = evaluate_law;
    result.prepare = prepare;
    result.release = prepare;
    return result;
  }();
  springnet_neuron_model neuron{sizeof(springnet_neuron_model), 0, nullptr, evaluate_neuron};
  springnet_integrator integrator{sizeof(springnet_integrator),
                                  0,
                                  nullptr,
                                  create,
                                  destroy,
                                  advance,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr};
  springnet_component components[3] = {
      {sizeof(springnet_component), SPRINGNET_SPRING_FUNCTION, "law", "", "", 0, 0, 0, 2, law_parameters, &law},
      {sizeof(springnet_component), SPRINGNET_NEURON, "neuron", "", "", 0, 0, 0, 0, nullptr, &neuron},
      {sizeof(springnet_component), SPRINGNET_INTEGRATOR, "integrator", "", "", 0, 0, 0, 0, nullptr, &integrator}};
  const springnet_component* list[3] = {&components[0], &components[1], &components[2]};
  springnet_plugin plugin{SPRINGNET_MAGIC,
                          sizeof(springnet_plugin),
                          SPRINGNET_ABI_MAJOR,
                          SPRINGNET_ABI_MINOR,
                          0,
                          3,
                          0,
                          "org.example.sample",
                          "1.0",
                          "tests",
                          "MIT",
                          list};

  Sample() = default;
  Sample(const Sample&) = delete;
  Sample& operator=(const Sample&) = delete;
};

// The reason of the refusal, or "" if the plugin was taken.
std::string reason_of(const springnet_plugin& plugin) {
  PluginHost host;
  if (host.add(plugin)) {
    CHECK(host.components().size() == plugin.component_count);
    return {};
  }
  CHECK(host.components().empty());
  REQUIRE(host.refusals().size() == 1);
  CHECK(host.refusals()[0].file.empty());
  return host.refusals()[0].reason;
}

}  // namespace

TEST_CASE("the sample is valid, so that below it is refused for what is changed") {
  const Sample sample;
  CHECK(reason_of(sample.plugin) == "");
}

TEST_CASE("a plugin that misdescribes itself is refused with the reason") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  struct Case {
    std::function<void(Sample&)> change;
    std::string reason;
  };
  const std::vector<Case> cases{
      {[](Sample& s) { s.plugin.magic ^= 1; }, "magic number"},
      {[](Sample& s) { s.plugin.abi_major = 3; }, "built for plugin ABI 3."},
      {[](Sample& s) { s.plugin.abi_major = 1; }, "built for plugin ABI 1."},
      {[](Sample& s) { s.plugin.needs_minor = 7; }, "it needs plugin ABI 2.7, this springnet has 2."},
      {[](Sample& s) { s.plugin.id = nullptr; }, "the plugin has no id"},
      {[](Sample& s) { s.plugin.id = ""; }, "the plugin has no id"},
      {[](Sample& s) { s.plugin.version = nullptr; }, "null pointer"},
      {[](Sample& s) { s.plugin.author = nullptr; }, "null pointer"},
      {[](Sample& s) { s.plugin.licence = nullptr; }, "null pointer"},
      {[](Sample& s) { s.plugin.components = nullptr; }, "null pointer"},
      {[](Sample& s) { s.plugin.component_count = 0; }, "offers 0 components"},
      {[](Sample& s) { s.plugin.component_count = 4000000000u; }, "offers 4000000000 components"},
      {[](Sample& s) { s.list[1] = nullptr; }, "component 1 is a null pointer"},
      {[](Sample& s) { s.components[0].id = nullptr; }, "component 0 has the id ''"},
      {[](Sample& s) { s.components[0].id = ""; }, "component 0 has the id ''"},
      {[](Sample& s) { s.components[0].id = "two words"; }, "lower-case letters"},
      {[](Sample& s) { s.components[0].id = "none"; }, "rename it"},
      {[](Sample& s) { s.components[0].summary = nullptr; }, "no summary"},
      {[](Sample& s) { s.components[0].reference = nullptr; }, "no summary or reference"},
      {[](Sample& s) { s.components[0].implementation = nullptr; }, "its law is a null pointer"},
      {[](Sample& s) { s.components[1].implementation = nullptr; }, "its model is a null pointer"},
      {[](Sample& s) { s.components[2].implementation = nullptr; }, "its implementation is a null pointer"},
      {[](Sample& s) { s.components[0].parameters = nullptr; }, "list of parameters is a null pointer"},
      {[](Sample& s) { s.components[0].parameter_count = 1u << 30; }, "claims to have 1073741824 parameters"},
      {[](Sample& s) { s.list[2] = &s.components[1]; }, "two neurons 'neuron'"},
      {[](Sample& s) { s.law_parameters[1] = nullptr; }, "parameter 1 is a null pointer"},
      {[](Sample& s) { s.law_parameters[1] = &s.number; }, "two parameters 'stiffness'"},
      {[](Sample& s) { s.number.name = nullptr; }, "has the name ''"},
      {[](Sample& s) { s.number.name = "Stiffness"; }, "has the name 'Stiffness'"},
      {[](Sample& s) { s.number.name = "type"; }, "scenes use 'type'"},
      {[](Sample& s) { s.number.unit = nullptr; }, "has no unit"},
      {[](Sample& s) { s.number.unit = ""; }, "has no unit"},
      {[](Sample& s) { s.number.summary = nullptr; }, "has no summary"},
      {[](Sample& s) { s.number.type = 4; }, "is of type 4"},
      {[](Sample& s) { s.number.smallest = 11; }, "no value is between"},
      {[=](Sample& s) { s.number.smallest = nan; }, "no value is between"},
      {[=](Sample& s) { s.number.largest = nan; }, "no value is between"},
      {[](Sample& s) { s.number.default_value = -1; }, "default must be at least 0 N/m, is -1"},
      {[](Sample& s) { s.number.default_value = 11; }, "default must be at most 10 N/m, is 11"},
      {[=](Sample& s) { s.number.default_value = nan; }, "default must be a finite number"},
      {[=](Sample& s) { s.number.largest = s.number.default_value = inf; }, "default must be a finite number"},
      {[](Sample& s) {
         s.number.flags = SPRINGNET_EXCLUDES_SMALLEST;
         s.number.default_value = 0;
       },
       "default must be above 0 N/m"},
      {[](Sample& s) {
         s.number.type = SPRINGNET_INTEGER;
         s.number.default_value = 1.5;
       },
       "default must be a whole number"},
      {[](Sample& s) {
         s.number.type = SPRINGNET_BOOLEAN;
         s.number.default_value = 2;
       },
       "default must be true or false"},
      {[](Sample& s) { s.number.scale = 0; }, "scale must be a finite number above 0"},
      {[=](Sample& s) { s.number.scale = inf; }, "scale must be a finite number above 0"},
      {[](Sample& s) { s.choice.choices = nullptr; }, "choice without a list"},
      {[](Sample& s) { s.choice.choice_count = 0; }, "choice without a list"},
      {[](Sample& s) { s.choice_names[1] = nullptr; }, "choice 1 has no name"},
      {[](Sample& s) { s.choice_names[1] = "soft"; }, "two choices 'soft'"},
      {[](Sample& s) { s.choice.default_value = 2; }, "default must be one of 'soft', 'hard'"},
      {[](Sample& s) { s.law.evaluate = nullptr; }, "no function 'evaluate'"},
      {[](Sample& s) { s.law.release = nullptr; }, "no function 'release'"},
      {[](Sample& s) { s.law.prepare = nullptr; }, "no function 'prepare'"},
      {[](Sample& s) { s.law.state_count = 1; }, "no function 'update'"},
      {[](Sample& s) {
         s.law.state_count = 1;
         s.law.update = update;
       },
       "list of states is a null pointer"},
      {[](Sample& s) { s.law.update_order = 0; }, "update of order 0"},
      {[](Sample& s) { s.law.update_order = 3; }, "update of order 3"},
      {[](Sample& s) {
         s.law.smallest_stretch = 2;
         s.law.largest_stretch = 1;
       },
       "from a stretch of 2 to 1"},
      {[=](Sample& s) { s.law.largest_stretch = nan; }, "from a stretch of 0 to nan"},
      {[](Sample& s) { s.law.tables = nullptr; }, "list of tables is a null pointer"},
      {[](Sample& s) { s.law.table_count = 1u << 30; }, "claims to have 1073741824 tables"},
      {[](Sample& s) { s.tables[0] = nullptr; }, "table 0 is a null pointer"},
      {[](Sample& s) { s.table.name = "Curve"; }, "has the name 'Curve'"},
      {[](Sample& s) { s.table.name = "type"; }, "its name is taken"},
      {[](Sample& s) { s.table.name = "kind"; }, "its name is taken"},  // by a parameter
      {[](Sample& s) { s.table.flags = 4; }, "has flags 0x4"},
      {[](Sample& s) { s.table.least = 1'000'001; }, "asks for 1000001 values"},
      {[](Sample& s) { s.table.unit = ""; }, "no unit or summary"},
      {[](Sample& s) { s.table.summary = nullptr; }, "no unit or summary"},
      {[](Sample& s) { s.table.as_long_as = 1; }, "as long as table 1, of 1"},
      {[=](Sample& s) { s.table.largest = nan; }, "no value is between"},
      {[](Sample& s) { s.law.input_count = 1; }, "list of inputs is a null pointer"},
      {[](Sample& s) {
         s.law.invariant = SPRINGNET_RELATIVE_SPEED;
         s.components[0].capabilities = SPRINGNET_READS_RATE;
       },
       "drop SPRINGNET_READS_RATE"},
      {[](Sample& s) { s.neuron.evaluate = nullptr; }, "no function 'evaluate'"},
      {[](Sample& s) { s.integrator.create = nullptr; }, "no function 'create'"},
      {[](Sample& s) { s.integrator.destroy = nullptr; }, "no function 'destroy'"},
      {[](Sample& s) { s.integrator.advance = nullptr; }, "no function 'advance'"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.reason);
    Sample sample;
    c.change(sample);
    const std::string reason = reason_of(sample.plugin);
    CAPTURE(reason);
    CHECK(reason.find(c.reason) != std::string::npos);
  }
}

TEST_CASE("a plugin with laws for more than springs of two nodes is accepted") {
  Sample sample;
  SUBCASE("an invariant of later hosts") { sample.law.invariant = SPRINGNET_VOLUME; }
  SUBCASE("internal state") {
    sample.law.state_count = 1;
    sample.law.states = sample.law_parameters;
    sample.law.update = update;
  }
  SUBCASE("no table") { sample.law.table_count = 0; }
  CHECK(reason_of(sample.plugin) == "");
}

TEST_CASE("a required parameter needs no sensible default") {
  Sample sample;
  sample.number.flags = SPRINGNET_REQUIRED;
  sample.number.default_value = std::numeric_limits<double>::quiet_NaN();
  CHECK(reason_of(sample.plugin) == "");
}

TEST_CASE("a neuron's parameter cannot have the name of another key in the same table of a scene") {
  Sample sample;
  sample.number.name = "mass";
  CHECK(reason_of(sample.plugin) == "");  // of a law it can
  sample.components[1].parameters = sample.law_parameters;
  sample.components[1].parameter_count = 1;
  CHECK(reason_of(sample.plugin).find("scenes use 'mass'") != std::string::npos);
}

namespace {

// The first `size` bytes of a struct in memory of exactly that size, so that a sanitizer detects reads beyond.
template <class Struct>
const Struct* shortened(const Struct& whole, std::uint32_t size, std::vector<std::unique_ptr<char[]>>& keep) {
  keep.push_back(std::make_unique<char[]>(size));
  Struct copy = whole;
  copy.struct_size = size;
  std::memcpy(keep.back().get(), &copy, size);
  return reinterpret_cast<const Struct*>(keep.back().get());
}

}  // namespace

TEST_CASE("a struct of any smaller size is refused without reading beyond its end") {
  std::vector<std::unique_ptr<char[]>> keep;
  const auto refused = [](const springnet_plugin& plugin) {
    return reason_of(plugin).find("rebuild the plugin") != std::string::npos;
  };
  constexpr std::uint32_t size_field = 4, magic_and_size = 12;
  for (std::uint32_t size = magic_and_size; size < SPRINGNET_PLUGIN_SIZE_2_0; ++size) {
    CAPTURE(size);
    const Sample sample;
    CHECK(refused(*shortened(sample.plugin, size, keep)));
  }
  for (std::uint32_t size = size_field; size < SPRINGNET_COMPONENT_SIZE_2_0; ++size) {
    CAPTURE(size);
    Sample sample;
    sample.list[2] = shortened(sample.components[2], size, keep);
    CHECK(refused(sample.plugin));
  }
  for (std::uint32_t size = size_field; size < SPRINGNET_PARAMETER_SIZE_2_0; ++size) {
    CAPTURE(size);
    Sample sample;
    sample.law_parameters[1] = shortened(sample.choice, size, keep);
    CHECK(refused(sample.plugin));
  }
  for (std::uint32_t size = size_field; size < SPRINGNET_TABLE_SIZE_2_0; ++size) {
    CAPTURE(size);
    Sample sample;
    sample.tables[0] = shortened(sample.table, size, keep);
    CHECK(refused(sample.plugin));
  }
  for (std::uint32_t size = size_field; size < SPRINGNET_LAW_SIZE_2_0; ++size) {
    CAPTURE(size);
    Sample sample;
    sample.components[0].implementation = shortened(sample.law, size, keep);
    CHECK(refused(sample.plugin));
  }
  for (std::uint32_t size = size_field; size < SPRINGNET_NEURON_MODEL_SIZE_2_0; ++size) {
    CAPTURE(size);
    Sample sample;
    sample.components[1].implementation = shortened(sample.neuron, size, keep);
    CHECK(refused(sample.plugin));
  }
  for (std::uint32_t size = size_field; size < SPRINGNET_INTEGRATOR_SIZE_2_0; ++size) {
    CAPTURE(size);
    Sample sample;
    sample.components[2].implementation = shortened(sample.integrator, size, keep);
    CHECK(refused(sample.plugin));
  }
}

TEST_CASE("a component that this host cannot use is refused by name, and the plugin's others are taken") {
  struct Case {
    std::function<void(springnet_component&)> change;
    std::string reason;
  };
  const std::vector<Case> cases{
      {[](springnet_component& c) { c.kind = 0; }, "is of kind 0, which this springnet does not know"},
      {[](springnet_component& c) { c.kind = 99; }, "is of kind 99, which this springnet does not know"},
      {[](springnet_component& c) { c.needs = SPRINGNET_NEEDS_STATES | UINT64_C(1) << 63; },
       "needs what this springnet does not provide (bits 0x8000000000000000 of `needs`)"},
      {[](springnet_component& c) { c.needs_minor = 7; }, "needs plugin ABI 2.7, this springnet has 2."},
      // What a later kind means by the rest is not known.
      {[](springnet_component& c) {
         c.kind = 5;
         c.summary = nullptr;
         c.implementation = nullptr;
       },
       "is of kind 5"},
  };
  for (const Case& c : cases) {
    for (const std::size_t which : {0, 1, 2}) {
      CAPTURE(c.reason);
      CAPTURE(which);
      Sample sample;
      c.change(sample.components[which]);
      PluginHost host;
      CHECK(host.add(sample.plugin));
      CHECK(host.components().size() == 2);
      for (const auto& component : host.components()) CHECK(component->id() != sample.components[which].id);
      REQUIRE(host.refusals().size() == 1);
      const std::string reason = host.refusals()[0].reason;
      CAPTURE(reason);
      CHECK(reason.find("component '" + std::string(sample.components[which].id) + "' ") == 0);
      CHECK(reason.find(c.reason) != std::string::npos);
      CHECK(reason.find("use a newer springnet") != std::string::npos);
    }
  }
}

TEST_CASE("a plugin of which this host can use nothing is refused") {
  Sample sample;
  for (springnet_component& component : sample.components) component.needs_minor = 7;
  PluginHost host;
  CHECK_FALSE(host.add(sample.plugin));
  CHECK(host.components().empty());
  CHECK(host.refusals().size() == 3);
}

TEST_CASE("two components that this host cannot use may have one id") {
  Sample sample;
  for (std::size_t i : {1, 2}) {
    sample.components[i].kind = 99;
    sample.components[i].id = "later";
  }
  PluginHost host;
  CHECK(host.add(sample.plugin));
  CHECK(host.components().size() == 1);
  CHECK(host.refusals().size() == 2);
}

TEST_CASE("an id that plugins of two ids provide is ambiguous until it says whose") {
  const Sample first;
  Sample second;
  second.plugin.id = "org.example.other";
  PluginHost host;
  CHECK(host.add(first.plugin));
  CHECK(host.add(second.plugin));
  CHECK(host.refusals().empty());
  CHECK(host.components().size() == 6);
  using springnet::ComponentKind;
  const std::string ambiguous =
      "2 plugins have a neuron 'neuron': say which, 'neuron@org.example.sample' or 'neuron@org.example.other'";
  CHECK_THROWS_WITH_AS(static_cast<void>(host.find(ComponentKind::neuron, "neuron")), ambiguous.c_str(),
                       springnet::Error);
  CHECK_THROWS_WITH_AS(static_cast<void>(host.require(ComponentKind::neuron, "neuron")), ambiguous.c_str(),
                       springnet::Error);
  CHECK(host.find(ComponentKind::neuron, "neuron@org.example.sample")->plugin == &first.plugin);
  CHECK(host.require(ComponentKind::neuron, "neuron@org.example.other")->plugin == &second.plugin);
  CHECK(host.find(ComponentKind::neuron, "neuron@org.example") == nullptr);
  CHECK(host.find(ComponentKind::neuron, "neuron@") == nullptr);
  CHECK(host.find(ComponentKind::spring_function, "neuron@org.example.other") == nullptr);
  CHECK_THROWS_WITH_AS(static_cast<void>(host.require(ComponentKind::neuron, "neuron@org.example.third")),
                       doctest::Contains("there is no neuron 'neuron@org.example.third'"), springnet::Error);
}

TEST_CASE("an id that one plugin provides may say whose, too") {
  const Sample sample;
  PluginHost host;
  CHECK(host.add(sample.plugin));
  CHECK(host.require(springnet::ComponentKind::integrator, "integrator@org.example.sample") != nullptr);
  CHECK(host.find(springnet::ComponentKind::integrator, "integrator@org.example.other") == nullptr);
}

TEST_CASE("of two plugins of one id the later one is refused, registering the same plugin again is not") {
  const Sample first, second;
  PluginHost host;
  CHECK(host.add(first.plugin));
  CHECK(host.add(first.plugin));
  CHECK(host.components().size() == 3);
  CHECK_FALSE(host.add(second.plugin));
  CHECK(host.components().size() == 3);
  CHECK(host.refusals().back().reason.find("already provided by a plugin of the same id, org.example.sample 1.0") !=
        std::string::npos);
}

TEST_CASE("laws of two kinds may have one id") {
  Sample first, second;
  second.plugin.component_count = 1;
  second.components[0].kind = SPRINGNET_VISCOSITY_FUNCTION;
  PluginHost host;
  CHECK(host.add(first.plugin));
  CHECK(host.add(second.plugin));
  CHECK(host.find(springnet::ComponentKind::spring_function, "law")->plugin == &first.plugin);
  CHECK(host.find(springnet::ComponentKind::viscosity_function, "law")->plugin == &second.plugin);
}
