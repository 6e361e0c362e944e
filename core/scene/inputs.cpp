// [[input]]: signals over time that laws read.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "layers/input_sets.hpp"
#include "scene/element_sets.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"
#include "scene/time_table.hpp"

namespace springnet::scene {
namespace {

constexpr std::array<std::string_view, 4> courses{"times", "file", "sinusoid", "value"};

// Values of all signals of a scene.
constexpr std::size_t most_values = 10'000'000;

using Readers = std::vector<layers::InputReader>;

void check_value_at(const Value& place, const Readers& readers, double number, std::string_view what) {
  place.at_this_place([&] { layers::check_input_value(readers, number, what); });
}

// The one of `courses` that is given.
std::string_view course_of(const Table& table) {
  std::string_view course;
  for (const std::string_view key : courses) {
    const auto value = table.find(key);
    if (!value) continue;
    if (!course.empty()) value->fail(fmt::format("cannot be combined with '{}'; remove one", course));
    course = key;
  }
  if (course.empty())
    table.fail("gives no signal; add times = […] with values = […], file = \"….csv\", sinusoid = { … } or value = …");
  return course;
}

void read_lists(const Table& table, const Readers& readers, Signal& signal) {
  const Value times = table.need("times");
  for (const Value& time : times.elements()) {
    const double number = time.number();
    if (!signal.times.empty() && !(signal.times.back() < number))
      time.fail(fmt::format("times must increase, but {} s follows {} s; sort them, and give each time once", number,
                            signal.times.back()));
    signal.times.push_back(number);
  }
  if (signal.times.size() < 2) times.fail(fmt::format("needs two times or more, has {}", signal.times.size()));
  const Value values = table.need("values");
  for (const Value& value : values.elements()) {
    signal.values.push_back(value.number());
    check_value_at(value, readers, signal.values.back(), "the value");
  }
  if (signal.values.size() != signal.times.size())
    values.fail(
        fmt::format("has {} values for {} times; give one for each", signal.values.size(), signal.times.size()));
}

void read_file(const Table& table, const Files& files, const std::string& input, const Readers& readers,
               Signal& signal) {
  const Value file = table.need("file");
  const auto column = table.find("column");
  const std::string name = column ? column->text() : input;
  if (name == "time") file.fail("the column 'time' has the times; name that of the values by 'column'");
  CsvColumns columns = files.csv_columns(file, {"time", name});
  const std::vector<double>& times = columns.values[0];
  if (times.size() < 2) file.fail(fmt::format("has {} rows below its header; give two or more", times.size()));
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (!(times[k - 1] < times[k]))
      file.fail(fmt::format("{}: times must increase; sort the rows, and give each time once", columns.place(k)));
  }
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto refuses = [value = columns.values[1][k]](const layers::InputReader& reader) {
      return !check_value(*reader.declared, value).empty();
    };
    if (std::any_of(readers.begin(), readers.end(), refuses))  // a text only then: there may be a million rows
      check_value_at(file, readers, columns.values[1][k], columns.place(k) + ": the value");
  }
  signal.times = std::move(columns.values[0]);
  signal.values = std::move(columns.values[1]);
}

Signal read_signal(const Table& table, const Files& files, const std::string& input, const Readers& readers) {
  Signal signal;
  const std::string_view course = course_of(table);
  const auto requires_key = [&](const char* key, bool fits, const char* wanted) {
    const auto given = table.find(key);
    if (given && !fits) given->fail(fmt::format("requires {}; remove it", wanted));
  };
  requires_key("values", course == "times", "'times'");
  requires_key("column", course == "file", "'file'");
  requires_key("interpolation", course == "times" || course == "file", "'times' or 'file'");
  if (course == "times") read_lists(table, readers, signal);
  if (course == "file") read_file(table, files, input, readers, signal);
  if (course == "value") {
    signal.mean = table.need("value").number();
    check_value_at(table.need("value"), readers, signal.mean, "the value");
  }
  if (course == "sinusoid") {
    const Table keys = table.need("sinusoid").table("input.sinusoid");
    signal.frequency = keys.need("frequency").number_above_0("Hz");
    signal.amplitude = keys.need("amplitude").number();
    if (const auto mean = keys.find("mean")) signal.mean = mean->number();
    if (const auto phase = keys.find("phase")) signal.phase = phase->number();
    const double swing = std::abs(signal.amplitude);
    check_value_at(table.need("sinusoid"), readers, signal.mean - swing, "its least value");
    check_value_at(table.need("sinusoid"), readers, signal.mean + swing, "its greatest value");
  }
  if (const auto interpolation = table.find("interpolation")) {
    using enum Signal::Interpolation;
    constexpr std::array kinds{hold, linear, cubic};
    signal.interpolation = kinds.at(interpolation->choice({"hold", "linear", "cubic"}));
  }
  return signal;
}

// What reads an input of a name.
struct Reading {
  std::vector<bool> materials;  // [material]
  std::vector<SpringIndex> springs;
  std::vector<ElementIndex> elements;
};

Reading find_reading(const std::string& input, const PluginHost& plugins, const Network& network) {
  Reading reading{layers::materials_reading(network, input, plugins), {}, {}};
  const SpringList& springs = network.springs();
  const Column<MaterialIndex>& materials = springs.materials();
  for (SpringIndex k = 0; k < springs.size(); ++k)
    if (reading.materials[materials[k]]) reading.springs.push_back(k);
  for (ElementIndex k = 0; k < network.elements().size(); ++k)
    if (reading.materials[network.elements()[k].material]) reading.elements.push_back(k);
  return reading;
}

// Those selected, or all, as far as a law of theirs has the input.
void read_members(const Table& table, const Reading& reading, const Scene& scene, Input& input) {
  const Network& network = scene.network;
  const auto select = table.find("select"), elements = table.find("elements");
  if (!select && !elements) {
    input.springs = reading.springs;
    input.elements = reading.elements;
    // None: find_readers then tells what inputs there are.
    if (!input.springs.empty() || !input.elements.empty()) return;
    for (SpringIndex k = 0; k < network.springs().size(); ++k) input.springs.push_back(k);
    for (ElementIndex k = 0; k < network.elements().size(); ++k) input.elements.push_back(k);
    return;
  }
  if (select) input.springs = select_springs(*select, network);
  if (elements) input.elements = select_elements(*elements, scene.elements);
  Input those = input;
  std::erase_if(those.springs, [&](SpringIndex k) { return !reading.materials[network.springs()[k].material]; });
  std::erase_if(those.elements, [&](ElementIndex k) { return !reading.materials[network.elements()[k].material]; });
  if (!those.springs.empty() || !those.elements.empty()) input = std::move(those);
}

}  // namespace

void read_inputs(const Table& root, const PluginHost& plugins, const Files& files, Scene& scene) {
  std::size_t selected = 0, values = 0;
  std::map<std::string, Reading> known;  // by the name of the input
  for (const Value& value : root.tables("input")) {
    const Table table = value.table("input");
    Input input;
    const Value name = table.need("input");
    input.input = name.text();
    if (const auto given = table.find("name")) input.name = given->text();
    const auto [reading, is_new] = known.try_emplace(input.input);
    if (is_new) reading->second = find_reading(input.input, plugins, scene.network);
    read_members(table, reading->second, scene, input);
    count_selected(value, input.springs.size() + input.elements.size(), selected);
    const Readers readers = name.at_this_place([&] { return layers::find_readers(scene.network, input, plugins); });
    input.signal = read_signal(table, files, input.input, readers);
    values += input.signal.values.size();
    if (values > most_values)
      value.fail(fmt::format("the signals of the scene have more than {} values; leave out some", most_values));
    value.at_this_place([&] { return scene.network.add_input(input); });
  }
}

}  // namespace springnet::scene
