// The keys of a scene. The reader accepts exactly these (and the parameters of the components named), and the reference
// page is checked against them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace springnet::scene {

// What a key's value looks like, as it stands in messages: "a number above 0, s". Throws std::logic_error for a key
// that is not listed, which would be a mistake in the reader.
[[nodiscard]] std::string_view form_of(std::string_view key);

// The same for a table, which need not be listed: "a table with type and parameters".
[[nodiscard]] std::string_view form_of_table(std::string_view table);

// Names of the keys directly in a table: those of "simulation" are "duration", "time_step", …; of "", the top level.
[[nodiscard]] std::vector<std::string> keys_in(std::string_view table);

}  // namespace springnet::scene
