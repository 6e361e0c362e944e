// A saved state: refused, which changes nothing, or taken up, and then the simulation goes on or says why not. Bytes
// that do not begin as a file does are the state itself, behind a head with the right identity and checksums: else
// hardly any would get beyond these.
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <string>

#include <springnet/simulation.hpp>

#include "state_net.hpp"
#include "target.hpp"

using namespace springnet;

namespace {

constexpr std::string_view heading = "springnet state 5\n";

// [heading][identity's size and checksum][state's size and checksum][identity][state]
std::string around(const std::string& saved, std::string_view state) {
  std::uint64_t told = 0;
  std::memcpy(&told, saved.data() + heading.size(), sizeof told);
  std::string result = saved.substr(0, heading.size() + 24 + told);
  const std::uint64_t size = state.size();
  const auto sum = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(state.data()), state.size()));
  std::memcpy(result.data() + heading.size() + 12, &size, sizeof size);
  std::memcpy(result.data() + heading.size() + 20, &sum, sizeof sum);
  return result.append(state);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Simulation simulation = testing::state_simulation();
  static const std::string before = simulation.save();
  const std::string_view given(reinterpret_cast<const char*>(data), size);
  const std::string bytes = given.starts_with("springnet") ? std::string(given) : around(before, given);
  const std::filesystem::path& file =
      testing::file_of(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), "run.state");
  bool taken = false;
  testing::read_or_refuse(file.native(), [&] {
    simulation.restore_from(file);
    taken = true;
  });
  if (taken) {
    try {
      for (int step = 0; step < 2; ++step) simulation.step();
    } catch (const Error&) {  // a motion that cannot be
    }
    simulation.restore(before);
  }
  const std::string now = simulation.save();
  // Where, behind the checksums.
  const auto at =
      std::mismatch(now.begin() + heading.size() + 24, now.end(), before.begin() + heading.size() + 24, before.end())
          .first -
      now.begin();
  testing::require(now == before, "the simulation is as it was, byte", std::to_string(at).c_str());
  return 0;
}
