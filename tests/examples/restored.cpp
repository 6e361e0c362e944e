// Simulations of the examples that are saved at every step: one that takes up the bytes goes on with the same bits.
#include "course.hpp"
#include "simulation/saved_states.hpp"

#include <vector>

using namespace springnet;
using namespace springnet::testing;

namespace {

std::vector<std::filesystem::path> scenes() {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(EXAMPLES))
    if (entry.path().extension() == ".toml") found.push_back(std::filesystem::relative(entry.path(), EXAMPLES));
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

TEST_CASE("the examples go on with the same bits from every state that was saved") {
  // Of a large scene the first steps; the others to their ends, if these are not far.
  constexpr std::size_t springs_times_steps = 100'000, most_steps = 150;
  for (const std::filesystem::path& file : scenes()) {
    CAPTURE(file.string());
    std::optional<Scene> scene;
    try {
      scene = example(file.string());
    } catch (const Error& error) {
      // Its plugin is built outside of the tree.
      CHECK(file == "plugin/chain.toml");
      CHECK(error.kind() == ErrorKind::input);
      continue;
    }
    Simulation own(scene->network, plugins(), scene->options), other(scene->network, plugins(), scene->options);
    const std::size_t most = std::min(most_steps, springs_times_steps / (own.spring_count() + own.element_count() + 1));
    std::size_t steps = 0;
    std::string what;
    for (; steps < most && own.time() < scene->duration - 0.5 * own.time_step() && what.empty(); ++steps) {
      const std::string saved = own.save();
      other.restore(saved);
      Simulation copy = own.clone();
      own.step();
      other.step();
      copy.step();
      what = difference(own, other);
      if (what.empty()) what = difference(own, copy);
      if (steps % 4 == 0) other.step();  // what it takes up next is then a state before its own
    }
    CHECK(steps > 0);
    CHECK(what == "");
  }
}
