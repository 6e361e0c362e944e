// math_accuracy COUNT: the functions of sdk/math.hpp against MPFR on COUNT random arguments all together. Prints the
// largest error of each; the status is 1 if one is above its bound.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "functions.hpp"

int main(int argc, char** argv) {
  using namespace springnet::test;
  const std::uint64_t count = argc == 2 ? std::strtoull(argv[1], nullptr, 10) : 0;
  if (count == 0) {
    std::fprintf(stderr, "usage: math_accuracy COUNT\n");
    return 2;
  }
  const auto all = functions();
  const unsigned threads = std::thread::hardware_concurrency() == 0 ? 1 : std::thread::hardware_concurrency();
  const std::uint64_t each = (count + all.size() - 1) / all.size(), share = (each + threads - 1) / threads;
  bool good = true;
  for (const Function& function : all) {
    std::vector<Worst> worst(threads);
    std::vector<std::thread> team;
    for (unsigned k = 0; k < threads; ++k) {
      team.emplace_back([&, k] { worst[k] = worst_error(function, share, 1000 + k); });
    }
    for (std::thread& thread : team) thread.join();
    Worst greatest;
    for (const Worst& part : worst) {
      if (part.error >= greatest.error) greatest = part;
    }
    std::printf("%-6s %.3f ulp at %a %a\n", function.name.c_str(), greatest.error, greatest.x, greatest.y);
    std::fflush(stdout);
    good = good && greatest.error <= function.bound;
  }
  return good ? 0 : 1;
}
