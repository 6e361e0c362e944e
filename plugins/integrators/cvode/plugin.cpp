#include <cstdint>
#include <span>

#include <springnet/sdk/integrator.hpp>

#include "integrator.hpp"

namespace {

using namespace springnet::sdk;
using springnet::cvode::LinearSolverKind;
using springnet::cvode::Method;
using springnet::cvode::ReferenceIntegrator;
using springnet::cvode::Settings;

class Cvode : public Integrator {
 public:
  static constexpr const char* id = "cvode";
  static constexpr const char* summary = "the reference: variable order and step, error below a tolerance (SUNDIALS)";
  static constexpr const char* reference =
      "A. C. Hindmarsh et al., SUNDIALS: Suite of nonlinear and differential/algebraic equation solvers, "
      "ACM Transactions on Mathematical Software 31 (2005) 363-396";
  static constexpr bool integrates_states = true;
  static constexpr bool locates_events = true;
  static constexpr bool keeps_bodies_apart = true, keeps_rigid_bodies_apart = true;
  static constexpr bool chooses_steps = true;
  static constexpr Parameter parameters[] = {
      choice("method", {"bdf", "adams"}, "backward differentiation for stiff networks, or Adams-Moulton"),
      number("relative_tolerance", "1", "error of a step, relative to the scales of the network")
          .preset(1e-8)
          .above(0)
          .at_most(0.1),
      number("position_tolerance", "m", "error of a position in a step; 0: relative_tolerance x mean rest length")
          .preset(0)
          .at_least(0),
      number("velocity_tolerance", "m/s", "error of a velocity in a step; 0: relative_tolerance x velocity scale")
          .preset(0)
          .at_least(0),
      choice("linear_solver", {"auto", "direct", "krylov", "none"},
             "sparse factorisation, preconditioned GMRES, or functional iteration; auto: by method and size"),
      integer("max_order", "highest order of the method; 0: its own, 5 (bdf) or 12 (adams)")
          .preset(0)
          .at_least(0)
          .at_most(12),
      number("max_step", "s", "longest internal step; 0: no limit").preset(0).at_least(0),
      integer("max_steps", "largest number of internal steps between two outputs; more end the run")
          .preset(100000)
          .at_least(1)
          .at_most(1e9),
      boolean("dense_output", "keeps the internal steps of a time step, for states within it; takes memory")};

  Cvode(Host host, Options options) : integrator_(host, read(options)) {}

  springnet_status advance(double until, springnet_step_report& report) {
    integrator_.advance(until, report);
    return SPRINGNET_OK;
  }

  void forget() { integrator_.forget(); }
  void interpolate(double time, const springnet_vectors& position, const springnet_vectors& velocity) {
    integrator_.interpolate(time, position, velocity);
  }
  void begin_sensitivities(std::span<const springnet_sensitivity* const> columns) {
    integrator_.begin_sensitivities(columns);
  }
  void sensitivity(std::uint32_t column, double* position, double* velocity) const {
    integrator_.sensitivity(column, position, velocity);
  }
  void limits(const LimitSink& sink) { sink.none("", "it divides time steps by its error test"); }

 private:
  static Settings read(const Options& options) {
    Settings settings;
    settings.method = options.choice<Method>("method");
    settings.relative_tolerance = options["relative_tolerance"];
    settings.position_tolerance = options["position_tolerance"];
    settings.velocity_tolerance = options["velocity_tolerance"];
    settings.linear_solver = options.choice<LinearSolverKind>("linear_solver");
    settings.max_order = options.integer<int>("max_order");
    settings.max_step = options["max_step"];
    settings.max_steps = options.integer<long>("max_steps");
    settings.dense_output = options.boolean("dense_output");
    return settings;
  }

  ReferenceIntegrator integrator_;
};

}  // namespace

SPRINGNET_PLUGIN("springnet.integrator.cvode", "0.1.0", "springnet", "MIT", Cvode);
