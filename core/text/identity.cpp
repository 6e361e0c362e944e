#include "text/identity.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

#include <springnet/printable.hpp>

#include "text/difference.hpp"

namespace springnet {

void write_identity(Archive& archive, const Identity& identity) {
  static_cast<void>(archive.count(identity.size(), 1, "properties"));
  for (auto [name, value] : identity) {
    archive.text(name);
    archive.text(value);
  }
}

std::optional<IdentityDifference> identity_difference(Archive& archive, const Identity& here,
                                                      std::string_view here_word) {
  const std::size_t count = archive.count(0, 2 * sizeof(std::uint64_t), "properties");
  for (std::size_t k = 0; k < std::max(count, here.size()); ++k) {
    std::string name, value;
    if (k < count) {
      archive.text(name);
      archive.text(value);
    }
    const std::string own = k < here.size() ? here[k].first : std::string();
    if (k >= count || name != own)
      return IdentityDifference{false, fmt::format("which tells {} in place of {}",
                                                   k < count ? fmt::format("'{}'", printable(name)) : "nothing",
                                                   own.empty() ? "nothing" : fmt::format("'{}'", own))};
    if (value != here[k].second)
      return IdentityDifference{true, fmt::format("{}: {}", name, difference_of(value, here[k].second, here_word))};
  }
  return std::nullopt;
}

}  // namespace springnet
