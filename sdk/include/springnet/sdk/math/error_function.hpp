// erf.
#pragma once

#include <springnet/sdk/math/exponential.hpp>

namespace springnet::sdk {

// Within 1.5 ulp. Below 1: x + x p(x^2); above: 1 - e^(-x^2) q(t) with t = (x - 3) / (x + 3). The polynomials
// interpolate erf(x) / x - 1 and e^(x^2) erfc(x) in the Chebyshev points of [0, 1] and of 1 <= x <= 6, and change the
// result by at most 2^-55.8 and 2^-57.3 of itself. From 6 on the result is 1.
[[nodiscard]] SPRINGNET_INLINE double erf(double x) {
  using namespace detail;
  constexpr double p[] = {0x1.06eba8214db69p-3,  -0x1.812746b0379e6p-2,  0x1.ce2f21a042b30p-4,  -0x1.b82ce31284e00p-6,
                          0x1.565bcd0dbaa38p-8,  -0x1.c02db3dac435fp-11, 0x1.f9a321d5b8e1ep-14, -0x1.f4d1e3183f7aep-17,
                          0x1.b9df224ca4b97p-20, -0x1.5f1ecb6f0764cp-23, 0x1.f7b4bf3b13964p-27, -0x1.389d4f2641625p-30,
                          0x1.05ffd737fb32ep-34};
  constexpr double q[] = {0x1.6e9827d229d2dp-3,   -0x1.4e102b9cf8512p-2, 0x1.f6ff20410599bp-3,  -0x1.336ffbef08cbbp-3,
                          0x1.258b13b0139fep-4,   -0x1.8fa58eb5bd68fp-6, 0x1.17c838fea5806p-8,  0x1.73101ea8fe252p-11,
                          -0x1.39085a31b18abp-11, 0x1.7b9fc8eb630e9p-15, 0x1.0cb1db32e0c9fp-14, -0x1.af2329d757293p-17,
                          -0x1.0cb4611cc29f6p-17, 0x1.0f9a79cee3e31p-19, 0x1.57a5fe2b9b75ep-20};
  const double size = magnitude(x), bounded = size > 6.0 ? 6.0 : size, square = bounded * bounded;
  const double small = size + size * polynomial(square, p);
  const double t = (bounded - 3.0) / (bounded + 3.0);
  const double large = 1.0 - scaled_exp(-square, 0) * polynomial(t, q);
  return with_sign(size < 1.0 ? small : large, x);
}

}  // namespace springnet::sdk
