// The keys of a scene. The reader accepts exactly these and the parameters of components. The reference page is tested
// against them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace springnet::scene {

// The form of a key's value for messages: "a number above 0, s". Throws std::logic_error for an unlisted key, which is
// a bug of the reader.
[[nodiscard]] std::string_view form_of(std::string_view key);

// The same for a table, which need not be listed: "a table with type and parameters".
[[nodiscard]] std::string_view form_of_table(std::string_view table);

// Names of the keys directly in a table: those of "simulation" are "duration", "time_step", …; of "", the top level.
[[nodiscard]] std::vector<std::string> keys_in(std::string_view table);

// All keys of this name with their forms, in whatever table: "body.neuron.type" and others of "type".
struct KeyForm {
  std::string_view path, form;
};
[[nodiscard]] std::vector<KeyForm> keys_named(std::string_view name);

}  // namespace springnet::scene
