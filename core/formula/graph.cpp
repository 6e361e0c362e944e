#include "formula/graph.hpp"

#include <bit>
#include <utility>

#include <springnet/error.hpp>

namespace springnet::formula {
namespace {

// Second derivatives of what max_terms allows are far below this.
constexpr std::size_t max_steps = 200'000;

bool is_symmetric(Code code) {
  return code == Code::sum || code == Code::product || code == Code::both || code == Code::either ||
         code == Code::equal || code == Code::hypot;
}

}  // namespace

Node Graph::add(const Step& given) {
  Step step = given;
  if (is_symmetric(step.code) && step.b < step.a) std::swap(step.a, step.b);
  const auto [place, is_new] =
      known_.try_emplace({step.code, step.a, step.b, step.c, step.index, std::bit_cast<std::uint64_t>(step.number)},
                         static_cast<Node>(steps_.size()));
  if (!is_new) return place->second;
  if (steps_.size() >= max_steps)
    throw Error(ErrorKind::input, "a formula whose derivatives take more than 200,000 operations; write a simpler one");
  steps_.push_back(step);
  return place->second;
}

Node Graph::constant(double value) { return add({Code::constant, no_node, no_node, no_node, 0, value}); }

Node Graph::negative(Node a) {
  if (is_constant(a)) return constant(-steps_[a].number);
  return apply(Code::negative, a);
}
Node Graph::sum(Node a, Node b) {
  if (is_constant(a) && is_constant(b)) return constant(steps_[a].number + steps_[b].number);
  if (a == b) return product(a, constant(2.0));  // the same bits, and a product may be joined to another step
  return apply(Code::sum, a, b);
}
Node Graph::difference(Node a, Node b) {
  if (is_constant(a) && is_constant(b)) return constant(steps_[a].number - steps_[b].number);
  return apply(Code::difference, a, b);
}
Node Graph::product(Node a, Node b) {
  if (is(a, 1.0)) return b;
  if (is(b, 1.0)) return a;
  if (is_constant(a) && is_constant(b)) return constant(steps_[a].number * steps_[b].number);
  return apply(Code::product, a, b);
}
Node Graph::quotient(Node a, Node b) {
  if (is(b, 1.0)) return a;
  if (is_constant(a) && is_constant(b)) return constant(steps_[a].number / steps_[b].number);
  return apply(Code::quotient, a, b);
}
Node Graph::choose(Node condition, Node a, Node b) {
  if (a == b) return a;
  if (is_constant(condition)) return steps_[condition].number != 0.0 ? a : b;
  return add({Code::choose, condition, a, b, 0, 0.0});
}

}  // namespace springnet::formula
