// Laws with internal states that step along: total derivatives of the forces and of the states at the end of a step.

#include <doctest/doctest.h>

#include "host_at.hpp"
#include "laws.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("in a step of internal states derivatives by parameters are total ones") {
  for (const LawCase& law : spring_laws()) {
    const Parametrised given = springs_with(law);
    if (HostAt(given.net()).internal.empty()) continue;
    for (const std::uint32_t order : {1u, 2u}) {
      CAPTURE(law.id);
      CAPTURE(order);
      check_parameters(given, [order](HostAt& at) {
        at.time_step = at.time = 0.05;
        at.order = order;
        at.position += 0.02 * random_vector(static_cast<std::size_t>(at.position.size()), 3);
      });
    }
  }
}
