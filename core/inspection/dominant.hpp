// The dominant eigenvalue of a linear map that is known by what it does to vectors: power iteration, sped up by
// Arnoldi's method (Saad, Numerical Methods for Large Eigenvalue Problems, 2nd ed., chapter 6), which sees complex
// pairs as well.
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
  std::size_t applications = 1000;  // of the map at most
  double tolerance = 1e-4;          // relative
};

struct Dominant {
  std::complex<double> value;
  double error = 0.0;               // norm of map(x) - value x for the unit vector x that was found
  Eigen::VectorXd real, imaginary;  // x
  std::size_t applications = 0;
};

// `start` is replaced by a good start for a map that is nearly the same. It must not be 0 unless the map's size is.
[[nodiscard]] Dominant dominant_eigenvalue(const std::function<void(Eigen::VectorXd&)>& map, Eigen::VectorXd& start,
                                           const DominantOptions& options);

// A vector with a part in every direction, the same on every machine; norm 1.
[[nodiscard]] Eigen::VectorXd scattered_vector(Eigen::Index size);

}  // namespace springnet
