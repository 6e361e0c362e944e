// Newton's linear systems. With y = (p, v), p' = v, v' = a(p, v) CVODE asks for (I - gamma J) (dp, dv) = (rp, rv),
// which is, after elimination of dp = rp + gamma dv,
//
//   (I - gamma a_v - gamma^2 a_p) dv = rv + gamma a_p rp
//
// with 3 node_count unknowns. Both solvers use that form: `direct` factorises it in the host; `krylov` iterates (GMRES
// on the whole system, with products of the analytic Jacobian) with its 3x3 diagonal blocks as preconditioner, which
// gives the spectrum of block Jacobi on the eliminated system.
#pragma once

#include <memory>

#include "equations.hpp"
#include "sundials.hpp"

namespace springnet::cvode {

// Owns what CVODE uses of a solver; must outlive the CVODE memory that it is attached to.
class NewtonSystem {
 public:
  NewtonSystem() = default;
  NewtonSystem(const NewtonSystem&) = delete;
  NewtonSystem& operator=(const NewtonSystem&) = delete;
  virtual ~NewtonSystem() = default;
};

class Sensitivities;

// User data of CVODE's memory.
struct Callbacks {
  Equations& equations;
  Sensitivities* sensitivities;
  std::unique_ptr<NewtonSystem> newton;
};

// Set callbacks.newton and attach it to CVODE's memory. Throw std::bad_alloc.
void attach_direct(void* memory, Callbacks& callbacks, const Context& context);
void attach_krylov(void* memory, N_Vector y, Callbacks& callbacks, const Context& context);

}  // namespace springnet::cvode
