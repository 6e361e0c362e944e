#include "critical_time.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include <springnet/sdk/limits.hpp>

namespace springnet::recurrent {
namespace {

constexpr double accuracy = 0.01;
constexpr std::uint32_t max_vectors = 20;

}  // namespace

double critical_weight(const sdk::Host& host, const Step& step) {
  host.linearise(sdk::evaluation_at(step.from, step.start));
  sdk::LinearisedNetwork network(host);
  const std::optional<double> guess = network.first_guess();
  if (!guess) return std::numeric_limits<double>::infinity();
  std::vector<double> start = network.start();
  return sdk::critical_step(
      host, *guess, start, std::min(max_vectors, network.max_vectors()),
      [&](double w, double* x) { network.times(-w * w, -w, x); }, accuracy);
}

}  // namespace springnet::recurrent
