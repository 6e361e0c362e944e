// What saved bytes are of: name and value of each property, which have to be the same where the bytes are taken up, so
// that an error says which one is not.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "text/archive.hpp"

namespace springnet {

using Identity = std::vector<std::pair<std::string, std::string>>;

void write_identity(Archive& archive, const Identity& identity);

struct IdentityDifference {
  bool is_of_values;  // of one property; else other properties are told
  std::string text;   // "duration: 1 s there, 2 s here", "which tells 'length' in place of 'duration'"
};
// Reads one that was written: the first difference from `here`, if there is one; the archive is then not read on.
[[nodiscard]] std::optional<IdentityDifference> identity_difference(Archive& archive, const Identity& here,
                                                                    std::string_view here_word = "here");

}  // namespace springnet
