#include "scene/toml_text.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace springnet::scene::toml_text {

std::string number(double value) {
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  std::string text = fmt::format("{}", value);  // the shortest that reads back
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string vector(const Vector3& value) {
  return fmt::format("[{}, {}, {}]", number(value[0]), number(value[1]), number(value[2]));
}

std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      result += {'\\', c};
    else if (c == '\n')
      result += "\\n";
    else if (c == '\t')
      result += "\\t";
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      result += fmt::format("\\u{:04x}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    else
      result += c;
  }
  return result + "\"";
}

std::string key(std::string_view name) {
  const bool bare = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? std::string(name) : in_quotes(name);
}

std::string numbers(const std::vector<double>& values) {
  return list(values.size(), [&](std::size_t k) { return number(values[k]); });
}
std::string vectors(const std::vector<Vector3>& values) {
  return list(values.size(), [&](std::size_t k) { return vector(values[k]); });
}

}  // namespace springnet::scene::toml_text
