// Laws with one mistake each, chosen by a macro: none of them may compile.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Mistaken : SpringFunction {
  static constexpr const char* id = "mistaken";
  static constexpr const char* summary = "has a mistake that the compiler must find";

#if defined(NONE)
  using has = Has<Energy>;
  static auto force(const auto& e, const auto&) { return e.q; }
  static auto energy(const auto& e, const auto&) { return 0.5 * e.q * e.q; }
#elif defined(UNDECLARED_RATE)
  template <class Real>
  static Real force(const Element<Real>& e, const Parameters<Real>&) {
    return e.rate;
  }
#elif defined(UNDECLARED_TIME)
  template <class Real>
  static Real force(const Element<Real>& e, const Parameters<Real>&) {
    return e.q * e.time;
  }
#elif defined(MISSPELT_MEMBER)
  using has = Has<Energy>;
  static auto force(const auto& e, const auto&) { return e.q; }
  static auto enegry(const auto& e, const auto&) { return 0.5 * e.q * e.q; }
#elif defined(UNNAMED_MEMBER)
  static auto force(const auto& e, const auto&) { return e.q; }
  static auto margin(const auto& e, const auto&) { return 2.0 - e.q; }
#elif defined(UNKNOWN_WORD)
  using has = Has<Enegry>;
  static auto force(const auto& e, const auto&) { return e.q; }
#elif defined(STATES_WITHOUT_RATES)
  static constexpr Parameter states[] = {number("creep", "m", "").preset(0)};
  static auto force(const auto& e, const auto&) { return e.q - e.state(0); }
#elif defined(TABLES_WITHOUT_PREPARE)
  static constexpr Table tables[] = {table("curve", "N", "tension")};
  static auto force(const auto& e, const auto&) { return e.q; }
#elif defined(START_WITHOUT_STATES)
  using has = Has<Start>;
  static auto force(const auto& e, const auto&) { return e.q; }
  static auto start(const auto& e, const auto&) { return std::array{e.q}; }
#elif defined(CORNER_OF_ANOTHER_SHAPE)
  static constexpr Shape shape = Shape::triangle;
  static constexpr Scalar invariants[] = {length_of(0, 1), length_of(1, 3)};
  static auto force(const auto& e, const auto&) { return e.q; }
#elif defined(SHAPE_WITHOUT_LIST)
  static constexpr Shape shape = Shape::triangle;
  static auto force(const auto& e, const auto&) { return e.q; }
#elif defined(ONE_FORCE_FOR_SEVERAL)
  static constexpr Shape shape = Shape::triangle;
  static constexpr Scalar invariants[] = {length_of(0, 1), length_of(1, 2)};
  static auto force(const auto& e, const auto&) { return e.q[0]; }
#elif defined(UNDECLARED_DIRECTION)
  static constexpr Shape shape = Shape::triangle;
  static constexpr Scalar invariants[] = {length_of(0, 1), length_of(1, 2)};
  static auto force(const auto& e, const auto&) { return std::array{e.q[0] * e.direction[0], e.q[1]}; }
#elif defined(STATES_OF_SEVERAL)
  static constexpr Shape shape = Shape::triangle;
  static constexpr Scalar invariants[] = {length_of(0, 1), length_of(1, 2)};
  static constexpr Parameter states[] = {number("creep", "m", "").preset(0)};
  static auto force(const auto& e, const auto&) { return std::array{e.q[0] - e.state(0), e.q[1]}; }
  static auto state_rates(const auto& e, const auto&) { return std::array{e.q[0]}; }
#endif
};

}  // namespace

SPRINGNET_PLUGIN("test.mistaken", "1.0.0", "springnet", "MIT", Mistaken);
