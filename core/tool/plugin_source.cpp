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
  constexpr std::size_t longest = 50;
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
  // As many a line as it has room for.
  std::string text = start;
  std::size_t column = start.size();
  for (const std::string& entry : list.entries) {
    const bool is_first = &entry == &list.entries.front(), fits = column + entry.size() + 2 <= line_length;
    if (!is_first) text += fits ? " " : "\n" + std::string(start.size(), ' ');
    column = (is_first || fits ? column : start.size()) + entry.size() + 2;
    text += entry + (&entry == &list.entries.back() ? "" : ",");
  }
  return text + "};\n";
}

// Constants of one type that follow each other are one declaration: static constexpr bool a = true, b = true;
std::string declarations_text(const std::vector<std::string>& declarations) {
  constexpr std::string_view constant = "static constexpr bool ";
  std::string text, line;
  for (const std::string& each : declarations) {
    const bool joins = line.starts_with(constant) && each.starts_with(constant) &&
                       2 + line.size() + 1 + each.size() - constant.size() <= line_length;
    if (joins) {
      line.back() = ',';
      line += " " + each.substr(constant.size());
      continue;
    }
    if (!line.empty()) text += "  " + line + "\n";
    line = each;
  }
  return line.empty() ? text : text + "  " + line + "\n";
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
  text += declarations_text(source.declarations);
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
