#include <fmt/format.h>

#include "law_course.hpp"
#include "law_plot.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

// What a law answers: by columns, each with its unit ("": none).
struct Column {
  std::string name, unit;
  Numbers values;
};

struct Answer {
  std::vector<Column> columns;
  std::string failure;  // where the law has no answer; else empty
};

Answer answer_of(const ShownLaw& law, const PlotArguments& arguments) {
  const LawCourse course(law.component->law(), law.reference);
  LawSetting setting = law.setting;
  setting.references = course.references();
  LawCaller caller(std::move(setting));
  const std::size_t count = arguments.at.size();
  const LawCurves curves = caller.evaluate(course.values(arguments.at), course.rates(Numbers(count, arguments.rate)));
  Answer answer;
  std::vector<Column>& columns = answer.columns;
  columns.push_back({course.name(), course.unit() == "1" ? "" : course.unit(), arguments.at});
  const bool several = curves.forces.size() > 1;
  for (std::size_t i = 0; i < curves.forces.size(); ++i) {
    const LawCourse::Units units = course.units(i);
    columns.push_back({several ? fmt::format("force {} ({})", i, units.name) : "force", units.force, curves.forces[i]});
  }
  const LawCourse::Units units = course.units(0);
  const auto add = [&](const char* name, const std::string& unit, const Numbers& values) {
    if (!values.empty()) columns.push_back({name, unit, values});
  };
  add("stiffness", units.by_value, curves.by_value);
  add("damping", units.by_rate, curves.by_rate);
  add("energy", "J", curves.energy);
  add("margin", "", curves.margin);
  answer.failure = caller.failure();
  return answer;
}

}  // namespace

std::string values_text(const std::vector<ShownLaw>& laws, const PlotArguments& arguments) {
  std::string text;
  for (const ShownLaw& law : laws) {
    const Answer answer = answer_of(law, arguments);
    if (!text.empty()) text += "\n";
    text += law.title + "\n";
    for (const std::string& note : law.notes) text += "  " + note + "\n";
    std::vector<std::vector<std::string>> rows(arguments.at.size() + 1);
    for (const Column& column : answer.columns) {
      rows[0].push_back(column.unit.empty() ? column.name : fmt::format("{}, {}", column.name, column.unit));
      for (std::size_t k = 0; k < column.values.size(); ++k) rows[k + 1].push_back(fmt::format("{}", column.values[k]));
    }
    text += align_columns(rows);
    if (!answer.failure.empty()) text += fmt::format("  nan: {}\n", answer.failure);
  }
  return text;
}

nlohmann::ordered_json values_json(const std::vector<ShownLaw>& laws, const PlotArguments& arguments) {
  using Json = nlohmann::ordered_json;
  Json all = Json::array();
  for (const ShownLaw& law : laws) {
    const Answer answer = answer_of(law, arguments);
    Json values = Json::array();
    for (const Column& column : answer.columns)
      values.push_back({{"name", column.name}, {"unit", column.unit}, {"values", column.values}});
    all.push_back({{"law", law.title}, {"columns", values}, {"failure", answer.failure}});
  }
  return all;
}

}  // namespace springnet::tool
