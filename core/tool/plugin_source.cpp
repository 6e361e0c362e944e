#include <algorithm>
#include <cctype>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/formula_source.hpp>

#include "plugin_project.hpp"

namespace springnet::tool {

namespace {

constexpr std::size_t line_length = 120;

// `springnet plugin list` has a line for it.
std::string shortened(std::string_view formula) {
  constexpr std::size_t longest = 60;
  std::string line = in_one_line(formula);
  if (line.size() > longest) line = line.substr(0, longest) + "...";
  return line;
}

std::string summary_of(const LawFormula& law) {
  if (law.summary.empty())
    return shortened(!law.force.empty()    ? law.force
                     : !law.energy.empty() ? "energy " + law.energy
                                           : "forces by formulas");
  std::string text;
  for (const char c : law.summary) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text;
}

std::string list_text(const SourceList& list) {
  const std::string start = fmt::format("  static constexpr {} {}[] = {{", list.type, list.name);
  std::size_t length = start.size();
  for (const std::string& entry : list.entries) length += entry.size() + 2;
  const std::string next = length <= line_length ? ", " : ",\n" + std::string(start.size(), ' ');
  return fmt::format("{}{}}};\n", start, fmt::join(list.entries, next));
}

std::string function_text(const SourceFunction& function) {
  std::string text = fmt::format("  static auto {}(const auto&{}, const auto&{}) {{", function.name,
                                 function.uses_element ? " e" : "", function.uses_parameters ? " p" : "");
  if (function.statements.size() == 1 && text.size() + function.statements[0].size() + 3 <= line_length)
    return fmt::format("{} {} }}\n", text, function.statements[0]);
  for (const std::string& statement : function.statements) text += "\n    " + statement;
  return text + "\n  }\n";
}

// What the parameters still lack.
std::string to_do(const LawFormula& law, const FormulaSource& source) {
  bool units = true, meanings = true;
  for (const std::string& name : source.parameters)
    for (const FormulaSymbol& each : law.parameters) {
      if (each.name != name) continue;
      units = units && !each.unit.empty();
      meanings = meanings && !each.summary.empty();
    }
  if (units && meanings) return {};
  return fmt::format("  // TODO: {}meanings and bounds, as number(\"mass\", \"kg\", \"of the bob\").above(0).\n",
                     units ? "" : "units, ");
}

}  // namespace

std::string in_one_line(std::string_view formula) {
  std::string line;
  bool comment = false;
  for (const char c : formula) {
    comment = c != '\n' && (comment || c == '#');
    if (comment) continue;
    const bool space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (!space)
      line += c;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  while (line.ends_with(' ')) line.pop_back();
  return line;
}

std::string law_source(const PluginProject& project, const std::string& type) {
  const LawFormula law = law_of(project);
  const FormulaSource source = source_of(law);
  std::string text = fmt::format(
      "#include <springnet/sdk/law.hpp>\n{}\nnamespace {{\nusing namespace springnet::sdk;\n\nstruct {} : {} {{\n",
      source.uses_tables ? "#include <springnet/sdk/table.hpp>\n" : "", type,
      project.kind == ComponentKind::spring_function ? "SpringFunction" : "ViscosityFunction");
  for (const std::vector<std::string>& names : source.enums)
    text += fmt::format("  enum {{ {} }};\n", fmt::join(names, ", "));
  const std::string start = "  static constexpr const char ", id = fmt::format("*id = \"{}\",", project.name);
  const std::string summary = fmt::format("*summary = \"{}\";\n", summary_of(law));
  const bool fits = start.size() + id.size() + summary.size() <= line_length;
  text += start + id + (fits ? " " : "\n" + std::string(start.size(), ' ')) + summary;
  for (const std::string& declaration : source.declarations) text += "  " + declaration + "\n";
  text += to_do(law, source);
  for (const SourceList& list : source.lists) text += list_text(list);
  if (!source.prepare.empty()) text += "  " + source.prepare + "\n";
  text += "\n";
  for (const SourceFunction& function : source.functions) text += function_text(function);
  return text + fmt::format(
                    "}};\n}}  // namespace\nSPRINGNET_PLUGIN(\"org.example.{}\", \"0.1.0\", \"your name\", "
                    "\"MIT\", {});\n",
                    project.name, type);
}

}  // namespace springnet::tool
