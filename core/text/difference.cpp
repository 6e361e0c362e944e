#include "text/difference.hpp"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>
#include <springnet/printable.hpp>

namespace springnet {

namespace {

constexpr std::size_t longest = 120;  // characters of each

}  // namespace

std::string difference_of(std::string_view there, std::string_view here, std::string_view here_word) {
  std::string_view cut = "";
  if (std::max(there.size(), here.size()) > longest) {
    const auto [mine, yours] = std::mismatch(there.begin(), there.end(), here.begin(), here.end());
    const auto first = static_cast<std::size_t>(mine - there.begin());
    // From the beginning of the entry of a list.
    const std::size_t before = there.substr(0, first).rfind(", ");
    std::size_t begin = before == std::string_view::npos ? 0 : before + 2;
    if (first - begin > longest / 2) begin = first - longest / 2;
    if (begin > 0) cut = "…, ";
    there.remove_prefix(begin);
    here.remove_prefix(std::min(begin, here.size()));
  }
  return fmt::format("{}{} there, {}{} {}", cut, printable(there, longest), cut, printable(here, longest), here_word);
}

}  // namespace springnet
