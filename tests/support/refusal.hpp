// What a program is told that asks for something wrong.
#pragma once

#include <string>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

namespace springnet::testing {

// The message of an Error(input); empty if there is none.
template <class Function>
std::string refusal_of(const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return {};
}

}  // namespace springnet::testing
