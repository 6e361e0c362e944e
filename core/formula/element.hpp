// A program for one element, in the SDK's dual numbers: for what the SDK does element by element.
#pragma once

#include <cstddef>

#include <springnet/sdk/dual.hpp>

#include "formula/program.hpp"

namespace springnet::formula {

// Places that such a program may have.
inline constexpr std::size_t max_element_places = 160;

// columns: the law's arguments by their columns. Not inlined: it is long, and each number type has one.
template <std::size_t N>
void evaluate_element(const Program& program, const Curves& curves, const sdk::Dual<N>* columns, sdk::Dual<N>* outputs);

}  // namespace springnet::formula
