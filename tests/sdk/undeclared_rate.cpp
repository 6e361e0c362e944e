#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Undeclared : SpringFunction {
  static constexpr const char* id = "undeclared";
  static constexpr const char* summary = "reads the rate and does not say so";

  template <class Real>
  static Real force(const Element<Real>& e, const Parameters<Real>&) {
    return e.rate;
  }
};

}  // namespace

SPRINGNET_PLUGIN("test.undeclared", "1.0.0", "springnet", "MIT", Undeclared);
