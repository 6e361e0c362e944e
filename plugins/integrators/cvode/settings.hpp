// Settings of a scene, in the order of the component's parameters.
#pragma once

namespace springnet::cvode {

enum class Method { bdf, adams };
enum class LinearSolverKind { automatic, direct, krylov, none };

struct Settings {
  Method method = Method::bdf;
  double relative_tolerance = 1e-8;
  double position_tolerance = 0.0;  // m; 0: relative_tolerance x length scale of the network
  double velocity_tolerance = 0.0;  // m/s; 0: relative_tolerance x velocity scale of the network
  LinearSolverKind linear_solver = LinearSolverKind::automatic;
  int max_order = 0;        // 0: the method's highest, 5 (bdf) or 12 (adams)
  double max_step = 0.0;    // s; 0: no limit
  long max_steps = 100000;  // between outputs
  bool dense_output = false;
};

}  // namespace springnet::cvode
