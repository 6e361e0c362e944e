#include "constraints/edge.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "constraints/friction.hpp"

namespace springnet {
namespace {

// Two surfaces meet in an edge if the cross product of their normals is at least this long.
constexpr double min_sine = 1e-6;

}  // namespace

EdgeResponse solve_edge(const Eigen::Matrix3d& mobility, const Vector3& relative, const Vector3& first,
                        const Vector3& second, double first_friction, double second_friction, const Vector3* kept) {
  const Vector3 stop = -(mobility.inverse() * relative);
  const Vector3 cross = first.cross(second);
  const double sine = cross.norm();
  if (sine < min_sine) return {Vector3::Zero(), stop, first.dot(stop), second.dot(stop), true};
  const Vector3 e = cross / sine;
  const double cosine = first.dot(second), square = sine * sine;
  EdgeResponse held{Vector3::Zero(), stop, (first.dot(stop) - cosine * second.dot(stop)) / square,
                    (second.dot(stop) - cosine * first.dot(stop)) / square, true};
  const bool free_to_stick = kept == nullptr;
  if (std::isinf(first_friction) || std::isinf(second_friction)) return held;
  if (free_to_stick && held.first >= 0.0 && held.second >= 0.0 &&
      cone_margin(first_friction, held.first, 0.0) + cone_margin(second_friction, held.second, std::abs(e.dot(stop))) >=
          0.0)
    return held;
  // Slip along sign e: each normal impulse comes with its friction.
  const auto slipping = [&](double sign) {
    Eigen::Matrix<double, 3, 2> normals, directions;
    normals << first, second;
    directions << first - sign * first_friction * e, second - sign * second_friction * e;
    const Eigen::Matrix2d system = normals.transpose() * mobility * directions;
    const Eigen::Vector2d pressing = system.inverse() * -(normals.transpose() * relative);
    const Vector3 impulse = directions * pressing;
    return EdgeResponse{relative + mobility * impulse, impulse, pressing[0], pressing[1], false};
  };
  if (kept != nullptr) return slipping(e.dot(*kept) < 0.0 ? -1.0 : 1.0);
  EdgeResponse smooth = slipping(0.0);
  if (smooth.first < 0.0 || smooth.second < 0.0) return smooth;
  if (first_friction == 0.0 && second_friction == 0.0) return smooth;
  const double slip = e.dot(smooth.velocity), sign = slip != 0.0 ? std::copysign(1.0, slip) : 1.0;
  for (const double direction : {sign, -sign}) {
    const EdgeResponse answer = slipping(direction);
    if (answer.first >= 0.0 && answer.second >= 0.0 && direction * e.dot(answer.velocity) > 0.0) return answer;
  }
  held.fits = false;
  return held;
}

}  // namespace springnet
