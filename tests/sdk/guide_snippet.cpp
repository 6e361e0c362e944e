// The part of a function in the page on integrators compiles.
#include <vector>

#include <springnet/sdk/integrator.hpp>

namespace {
using namespace springnet::sdk;

[[maybe_unused]] void add_gradients(Host host, const springnet_evaluation& at, std::vector<double>& weights) {
#include "by_parameters.inl"
}

}  // namespace
