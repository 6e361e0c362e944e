// Points that were seen on the surface of a net, without a node, as residuals of its simulated motion.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <springnet/motion_derivatives.hpp>
#include <springnet/observations.hpp>

#include "learning/between_states.hpp"
#include "learning/surface.hpp"

namespace springnet::learning {

// The residual of a point is the vector to it from the nearest point of the surface, which is found anew with each
// motion. Its derivative is that with this point held on the surface, without what slides along it (the tangent plane
// of iterative closest points): the gradient of the squared distance is exact, as the residual is normal to the
// surface. A corner that is nearest gives all three components, an edge two, a face one. The
// residual of an outlier is the vector whose half square is Huber's function.
class ObservedSurface {
 public:
  ObservedSurface(Surface& surface, const Observations& observations, const std::vector<double>& state_times);

  [[nodiscard]] Eigen::Index count() const noexcept { return 3 * static_cast<Eigen::Index>(rows_.size()); }
  // As of ObservedMotion.
  void residuals(const MotionDerivatives& motion, Eigen::Ref<Eigen::VectorXd> out);
  void add_tangent(std::size_t state, const Eigen::MatrixXd& positions, const Eigen::MatrixXd& velocities,
                   Eigen::Ref<Eigen::MatrixXd> out) const;
  void add_adjoint(std::size_t state, const Eigen::Ref<const Eigen::VectorXd>& weights,
                   MotionDerivatives::StateChange& to) const;

 private:
  struct Row {
    double time;
    Between at;
    Vector3 observed;
    double root_weight;
    Surface::Nearest nearest{};
    Eigen::Matrix3d by_point = Eigen::Matrix3d::Zero();  // derivative of the residual by the nearest point
  };
  // Calls what(row, number of its first residual, end) for the rows between a state and those beside it; end: which one
  // of the two states of the row this is.
  template <class What>
  void for_each_beside(std::size_t state, const What& what) const;

  Surface& surface_;
  double outlier_distance_;         // m
  std::vector<Row> rows_;           // by time
  std::vector<std::size_t> first_;  // [state] of its rows; and their number
};

}  // namespace springnet::learning
