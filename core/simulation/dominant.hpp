// The dominant eigenvalue of a linear map given by its products: Arnoldi's method, restarted with the best vector
// found (Saad, Numerical Methods for Large Eigenvalue Problems, 2nd ed., chapter 6). It sees complex
// pairs as well. Integrators reach it through the host table, springnet_host::dominant_eigenvalue.
#pragma once

#include <complex>
#include <cstddef>
#include <functional>

#include <Eigen/Core>

namespace springnet {

enum class Wanted {
  largest_magnitude,
  largest_real  // the rightmost in the complex plane
};

struct DominantOptions {
  Wanted wanted = Wanted::largest_magnitude;
  std::size_t basis = 40;           // vectors kept at most
  std::size_t applications = 1000;  // of the map, about
  double tolerance = 1e-4;          // of the residual, relative to the eigenvalue
};

struct Dominant {
  std::complex<double> value;       // infinity where an image was not finite
  double error = 0.0;               // norm of the residual map(x) - value x, x the unit vector that was found
  Eigen::VectorXd real, imaginary;  // x
  std::size_t applications = 0;
};

// `start` is replaced by a good start for a similar map. It must not be 0, unless it is empty.
[[nodiscard]] Dominant dominant_eigenvalue(const std::function<void(Eigen::VectorXd&)>& map, Eigen::VectorXd& start,
                                           const DominantOptions& options);

}  // namespace springnet
