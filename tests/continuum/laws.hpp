// Laws over several scalars, by the numbers of their materials.
#pragma once

#include "materials.hpp"

namespace springnet::testing {

inline LawUse solid_law(double modulus, double nu) {
  return {"solid", {{"youngs_modulus", modulus}, {"poisson_ratio", nu}}};
}
inline LawUse membrane_law(double modulus, double nu, double thickness, bool neo_hookean = true) {
  return {"membrane",
          {{"youngs_modulus", modulus},
           {"poisson_ratio", nu},
           {"thickness", thickness},
           {"model", neo_hookean ? 0.0 : 1.0}}};
}
inline LawUse fibre_solid_law(const NeoHookean& matrix, const Fibres& fibres) {
  return {"fibre_solid",
          {{"youngs_modulus", matrix.modulus},
           {"poisson_ratio", matrix.nu},
           {"fibre_modulus", fibres.modulus},
           {"fibre_stiffening", fibres.stiffening},
           {"fibres_push", fibres.push ? 1.0 : 0.0}}};
}
inline LawUse shell_law(double modulus, double nu, double thickness) {
  return {"shell", {{"youngs_modulus", modulus}, {"poisson_ratio", nu}, {"thickness", thickness}}};
}
inline LawUse viscous_solid_law(double shear, double bulk) {
  return {"viscous_solid", {{"shear_viscosity", shear}, {"bulk_viscosity", bulk}}};
}
inline LawUse viscous_membrane_law(double shear, double area) {
  return {"viscous_membrane", {{"shear_viscosity", shear}, {"area_viscosity", area}}};
}

}  // namespace springnet::testing
