// Whether the units of a law's formulas fit together.
#pragma once

#include <springnet/formula.hpp>

namespace springnet::formula {

// Throws Error(input) where units are added or compared that differ, a function gets a unit, or a result has not the
// one that it must have. Looks only if a parameter or input declares its unit; those that do not have whatever fits.
// Names such as `e`, which go with every invariant, may have the unit of any: check_units() looks at a use.
void check_units_of_some_use(const LawFormula& law);

}  // namespace springnet::formula
