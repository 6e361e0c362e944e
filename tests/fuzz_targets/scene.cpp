// A scene, with the project's own plugins and no file to refer to: refused, or a network.
#include <algorithm>
#include <cctype>

#include <springnet/scene.hpp>

#include "target.hpp"

using namespace springnet;

namespace {

// Whether a lattice has more than 20,000 nodes, or may have: a scene may ask for that, the search has no time for it.
bool asks_for_much(std::string_view text) {
  constexpr std::string_view key = "lattice";
  for (std::size_t at = 0; (at = text.find(key, at)) != std::string_view::npos;) {
    at += key.size();
    double nodes = 1.0, number = 0.0;
    for (const char c : text.substr(at, 100)) {
      if (std::isalpha(static_cast<unsigned char>(c)) != 0) return true;  // 0xffff
      if (std::isdigit(static_cast<unsigned char>(c)) != 0) {
        number = 10.0 * number + (c - '0');
      } else if (c != '_') {
        nodes *= std::max(number, 1.0);
        number = 0.0;
      }
      if (c == ']') break;
    }
    if (nodes > 20'000.0) return true;
  }
  return false;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const PluginHost plugins = PluginHost::with_default_search();
  static const testing::TemporaryFolder nothing;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (asks_for_much(text)) return -1;  // not kept
  testing::read_or_refuse("scene.toml", [&] {
    const Scene scene = parse_scene(text, "scene.toml", plugins, {}, nothing.path());
    testing::require(!scene.network.nodes().empty(), "a scene has nodes");
  });
  return 0;
}
