// Which signals the springs and elements of a network read.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet::layers {

// [material] Whether one of its laws has an input of this name. Throws Error(plugin) for a law that does not exist.
[[nodiscard]] std::vector<bool> materials_reading(const Network& network, std::string_view input,
                                                  const PluginHost& plugins);

// A law that reads a signal, and what it declares of that input.
struct InputReader {
  std::shared_ptr<const Component> law;
  const springnet_parameter* declared;
};
// The laws of the input's springs and elements that read it. Throws Error(input) if there is none.
[[nodiscard]] std::vector<InputReader> find_readers(const Network& network, const Input& input,
                                                    const PluginHost& plugins);
// The same, and throws if the signal leaves the bounds of one.
[[nodiscard]] std::vector<InputReader> readers_of(const Network& network, const Input& input,
                                                  const PluginHost& plugins);
// Throws Error(input), beginning with `what`, if the value is out of the bounds of a reader.
void check_input_value(const std::vector<InputReader>& readers, double value, std::string_view what);

// Sets of signals, numbered; 0 is empty.
class InputSets {
 public:
  static constexpr std::uint32_t none = 0xffffffffu;

  InputSets(const Network& network, const PluginHost& plugins);

  [[nodiscard]] const Column<std::uint32_t>& of_springs() const noexcept { return springs_; }
  [[nodiscard]] const Column<std::uint32_t>& of_elements() const noexcept { return elements_; }
  // The number of the signal that members of a set read for an input, or none.
  [[nodiscard]] std::uint32_t signal(std::uint32_t set, std::string_view input) const;

 private:
  // [set] The first one with the same signals.
  [[nodiscard]] std::vector<std::uint32_t> numbers_of_equal_sets() const;

  const std::vector<Input>& inputs_;
  std::vector<std::vector<InputIndex>> sets_{{}};
  Column<std::uint32_t> springs_, elements_;
};

}  // namespace springnet::layers
