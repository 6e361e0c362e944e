#include "dense_output.hpp"

#include <algorithm>
#include <string>

#include <springnet/sdk/host.hpp>

namespace springnet::cvode {

void DenseOutput::begin(double from) {
  while (!steps_.empty() && steps_.front().end < from) steps_.pop_front();
}

void DenseOutput::add_step(void* memory, double restart, const Context& context) {
  double end = 0.0, length = 0.0;
  int order = 0;
  const auto check = [&](int status) {
    if (status < 0) throw sdk::Failure("cvode: " + context.last_error());
  };
  check(CVodeGetCurrentTime(memory, &end));
  check(CVodeGetLastStep(memory, &length));
  check(CVodeGetLastOrder(memory, &order));
  if (length == 0.0 || (!steps_.empty() && steps_.back().end == end)) return;  // none since the last call
  Step step{std::max(end - length, restart), end, {}};
  sunindextype size = 0;
  Vector derivative;
  for (int k = 0; k <= order; ++k) {
    if (!derivative) {
      N_Vector current = nullptr;
      check(CVodeGetCurrentState(memory, &current));
      size = N_VGetLength(current);
      derivative = make_vector(size, context);
    }
    check(CVodeGetDky(memory, end, k, derivative.get()));
    const double* const values = data(derivative.get());
    step.derivatives.emplace_back(values, values + size);
  }
  steps_.push_back(std::move(step));
}

bool DenseOutput::evaluate(double time, std::size_t count, double* y) const {
  // After an event CVODE starts anew within the step before: the last one that has begun counts.
  const auto found = std::find_if(steps_.rbegin(), steps_.rend(), [&](const Step& step) { return step.begin <= time; });
  if (found == steps_.rend() || time > found->end) return false;
  const double from_end = time - found->end;
  std::fill_n(y, count, 0.0);
  for (std::size_t k = found->derivatives.size(); k-- > 0;)  // Horner's scheme
    for (std::size_t i = 0; i < count; ++i)
      y[i] = found->derivatives[k][i] + y[i] * (from_end / static_cast<double>(k + 1));
  return true;
}

}  // namespace springnet::cvode
