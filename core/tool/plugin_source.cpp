#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

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

// In one line where it fits, else as many entries a line as it has room for.
std::string list_text(const SourceList& list, const std::string& to_do) {
  const std::string start = fmt::format("  static constexpr {} {}[] = {{", list.type, list.name);
  const std::string in_one = fmt::format("{}{}}};\n", start, fmt::join(list.entries, ", "));
  if (to_do.empty() && in_one.size() <= line_length + 1) return in_one;
  std::string text = start + to_do, line;
  for (const std::string& entry : list.entries) {
    const std::string next = entry + (&entry == &list.entries.back() ? "};" : ",");
    const bool fits = !line.empty() && line.size() + 1 + next.size() <= line_length;
    if (!fits) text += line + "\n";
    line = (fits ? line + " " : std::string(6, ' ')) + next;
  }
  return text + line + "\n";
}

// enum { stiffness, limit, z = 0 }: states and inputs count from 0, as parameters do.
std::string enums_text(const std::vector<std::vector<std::string>>& enums) {
  std::string all, each;
  for (const std::vector<std::string>& names : enums) {
    all += all.empty() ? names.front() : fmt::format(", {} = 0", names.front());
    for (std::size_t k = 1; k < names.size(); ++k) all += ", " + names[k];
    each += fmt::format("  enum {{ {} }};\n", fmt::join(names, ", "));
  }
  const std::string one = fmt::format("  enum {{ {} }};\n", all);
  return enums.size() > 1 && one.size() <= line_length + 1 ? one : each;
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

// What the parameters still lack, behind the bracket that opens their list.
std::string to_do(const LawFormula& law, const FormulaSource& source) {
  bool units = true, meanings = true;
  for (const std::string& name : source.parameters)
    for (const FormulaSymbol& each : law.parameters) {
      if (each.name != name) continue;
      units = units && !each.unit.empty();
      meanings = meanings && !each.summary.empty();
    }
  for (const FormulaState& each : law.states) units = units && !each.unit.empty();
  if (units && meanings) return {};
  return fmt::format("  // TODO: {}meanings, bounds: number(\"m\", \"kg\", \"of a bob\").above(0)",
                     units ? "" : "units, ");
}

// A law is seen at a glance: empty lines are there as far as twenty lines have room for them, the first one longest.
std::string with_room(std::string text) {
  constexpr std::ptrdiff_t most_lines = 20;
  for (std::ptrdiff_t more = std::count(text.begin(), text.end(), '\n') - most_lines; more > 0; --more) {
    const std::size_t empty = text.rfind("\n\n");
    if (empty == std::string::npos) break;
    text.erase(empty, 1);
  }
  return text;
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
  text += enums_text(source.enums);
  const std::string start = "  static constexpr const char ", id = fmt::format("*id = \"{}\",", project.name);
  const std::string summary = fmt::format("*summary = \"{}\";\n", summary_of(law));
  const bool fits = start.size() + id.size() + summary.size() <= line_length;
  text += start + id + (fits ? " " : "\n" + std::string(start.size(), ' ')) + summary;
  text += declarations_text(source.declarations);
  for (const SourceList& list : source.lists)
    text += list_text(list, list.name == "parameters" ? to_do(law, source) : std::string());
  if (!source.prepare.empty()) text += "  " + source.prepare + "\n";
  text += "\n";
  for (const SourceFunction& function : source.functions) text += function_text(function);
  text += fmt::format(
      "}};\n}}  // namespace\nSPRINGNET_PLUGIN(\"org.example.{}\", \"0.1.0\", \"your name\", \"MIT\", {});\n",
      project.name, type);
  return with_room(std::move(text));
}

}  // namespace springnet::tool
