#include "simulation/loop.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "layers/instruction_set.hpp"

namespace springnet {
namespace {

constexpr std::uint64_t usual_part = 1024;

// The failure with the lowest number, so that which one is told does not depend on threads.
class FirstFailure {
 public:
  void add(std::uint64_t part, springnet_status status) noexcept {
    std::uint64_t before = value_.load(std::memory_order_relaxed);
    const auto known = static_cast<std::uint64_t>(status) & 0xffu;
    const std::uint64_t now = (part << 8) | (known == 0 ? static_cast<std::uint64_t>(SPRINGNET_FAILED) : known);
    while (now < before && !value_.compare_exchange_weak(before, now)) continue;
  }
  [[nodiscard]] bool is_before(std::uint64_t part) const noexcept {
    return (value_.load(std::memory_order_relaxed) >> 8) < part;
  }
  [[nodiscard]] springnet_status status() const noexcept {
    const std::uint64_t value = value_.load();
    return value == none ? springnet_status{SPRINGNET_OK} : static_cast<springnet_status>(value & 0xffu);
  }

 private:
  static constexpr std::uint64_t none = ~std::uint64_t{0};
  std::atomic<std::uint64_t> value_{none};
};

}  // namespace

springnet_status run_loop(Model& model, const springnet_loop& loop) {
  const std::uint64_t size = loop.part > 0 ? loop.part : usual_part;
  const std::uint64_t parts = loop.count / size + (loop.count % size > 0 ? 1 : 0);
  const int threads =
      static_cast<int>(std::min<std::uint64_t>(model.evaluator.threads(), std::max<std::uint64_t>(parts, 1)));
  FirstFailure failure;
  struct Updating {
    bool& flag;
    ~Updating() { flag = false; }
  } const updating{model.in_callback};
  model.in_callback = true;
#pragma omp parallel num_threads(threads) if (threads > 1)
  {
    const layers::FlushDenormals flush;
#pragma omp for schedule(dynamic)
    for (std::uint64_t part = 0; part < parts; ++part) {
      if (failure.is_before(part)) continue;
      const std::uint64_t begin = part * size, end = std::min(loop.count, begin + size);
      const springnet_status status = loop.body(loop.user, begin, end);
      if (status != SPRINGNET_OK) failure.add(part, status);
    }
  }
  return failure.status();
}

}  // namespace springnet
