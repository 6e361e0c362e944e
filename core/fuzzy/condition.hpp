// Conditions as texts: where a tree needs brackets.
#pragma once

#include <springnet/fuzzy.hpp>

namespace springnet::fuzzy {

// AND binds stronger than OR, and both combine from the left.
[[nodiscard]] constexpr bool needs_brackets(ConditionNode::Kind of, ConditionNode::Kind part, bool is_right) {
  using Kind = ConditionNode::Kind;
  if (part == Kind::proposition || part == Kind::negation) return of == Kind::negation;
  return of == Kind::negation || (is_right && of == part) || (of == Kind::both && part == Kind::either);
}

}  // namespace springnet::fuzzy
