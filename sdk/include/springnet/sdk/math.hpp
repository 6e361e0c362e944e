// Elementary functions of doubles with the same bits on every processor: exp, expm1, log, log1p, log10, pow, sqrt,
// cbrt, hypot, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, erf. Those of the C library choose their code
// by processor, and the last bit with it. dual.hpp has them for dual numbers.
//
// They are written without branches, so that a compiler vectorises loops over them (GCC with -fno-math-errno and
// -fno-trapping-math, which springnet_add_plugin sets). Errors are below 1 unit in the last place (ulp) of the exact
// result for exp, expm1 and log, below 2 for the others, for every argument; specials (nan, infinities, zeros with
// signs, subnormal numbers, pow's table of cases) are those of C. Conditions: rounding to nearest, no contraction to
// fused multiply-add (-ffp-contract=off), no -ffast-math. Where the processor flushes subnormal numbers to zero, as it
// does for the engine's threads, those count as zeros, as arguments and as results.
//
// Polynomials were computed for these headers, in 50 digits: they interpolate in Chebyshev points, and coefficients are
// rounded to double.
#pragma once

#include <springnet/sdk/math/arc.hpp>
#include <springnet/sdk/math/error_function.hpp>
#include <springnet/sdk/math/exponential.hpp>
#include <springnet/sdk/math/logarithm.hpp>
#include <springnet/sdk/math/power.hpp>
#include <springnet/sdk/math/trigonometric.hpp>
