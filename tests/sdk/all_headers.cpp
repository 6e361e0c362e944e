// One plugin with a component of each kind.
#include <springnet/sdk/integrator.hpp>
#include <springnet/sdk/law.hpp>
#include <springnet/sdk/neuron.hpp>

namespace {
using namespace springnet::sdk;

struct Tendon : SpringFunction {
  static constexpr const char* id = "tendon";
  static constexpr const char* summary = "pulls and does not push";
  static constexpr bool acts_in_compression = false;
  static constexpr Parameter parameters[] = {number("stiffness", "N/m", "tension per elongation").at_least(0)};

  template <class Real>
  static Real force(const Element<Real>& e, const Parameters<Real>& p) {
    return p[0] * max(e.elongation(), 0.0);
  }
};

struct Dashpot : ViscosityFunction {
  static constexpr const char* id = "dashpot";
  static constexpr const char* summary = "linear damper";
  static constexpr Parameter parameters[] = {number("damping", "N s/m", "force per rate").at_least(0)};

  template <class Real>
  static Real force(const Element<Real>& e, const Parameters<Real>& p) {
    return p[0] * e.rate;
  }
};

struct Mass : Neuron {
  static constexpr const char* id = "mass";
  static constexpr const char* summary = "mass point";

  template <class Real>
  static Vector<Real> acceleration(const Node<Real>& n, const Parameters<Real>&) {
    return n.force / n.mass;
  }
};

class Idle : public Integrator {
 public:
  static constexpr const char* id = "idle";
  static constexpr const char* summary = "advances the time only";

  Idle(Host host, Options) : host_(host), next_(host.make_state()) {}
  springnet_status advance(double until, springnet_step_report& report) {
    host_.commit(until, *next_);
    report.outcome = SPRINGNET_SETTLED;
    return SPRINGNET_OK;
  }

 private:
  Host host_;
  State next_;
};

}  // namespace

SPRINGNET_PLUGIN("test.all_headers", "1.0.0", "springnet", "MIT", Tendon, Dashpot, Mass, Idle);
