// The elementary functions as members of a class, for the bases of laws and neurons.
#pragma once

#include <springnet/sdk/dual.hpp>

namespace springnet::sdk {

// Within a class derived from this one an unqualified exp(x) is that of sdk/math.hpp also for x of type double, for
// which the C library has another in the global namespace. Elsewhere, as in a function that a formula calls, exp(x) of
// a double is ambiguous and does not compile: write sdk::exp(x). Calls with a dual number are fine everywhere.
struct ElementaryFunctions {
#define SPRINGNET_ELEMENTARY(name) \
  SPRINGNET_INLINE static auto name(const auto&... x) { return sdk::name(x...); }
  SPRINGNET_ELEMENTARY(exp)
  SPRINGNET_ELEMENTARY(expm1)
  SPRINGNET_ELEMENTARY(log)
  SPRINGNET_ELEMENTARY(log1p)
  SPRINGNET_ELEMENTARY(log10)
  SPRINGNET_ELEMENTARY(sqrt)
  SPRINGNET_ELEMENTARY(cbrt)
  SPRINGNET_ELEMENTARY(sin)
  SPRINGNET_ELEMENTARY(cos)
  SPRINGNET_ELEMENTARY(tan)
  SPRINGNET_ELEMENTARY(asin)
  SPRINGNET_ELEMENTARY(acos)
  SPRINGNET_ELEMENTARY(atan)
  SPRINGNET_ELEMENTARY(sinh)
  SPRINGNET_ELEMENTARY(cosh)
  SPRINGNET_ELEMENTARY(tanh)
  SPRINGNET_ELEMENTARY(erf)
  SPRINGNET_ELEMENTARY(pow)
  SPRINGNET_ELEMENTARY(hypot)
  SPRINGNET_ELEMENTARY(atan2)
#undef SPRINGNET_ELEMENTARY
};

}  // namespace springnet::sdk
