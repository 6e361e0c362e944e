#include "learning/motion_checks.hpp"

#include <string>

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet::learning {

double option(const LawUse& integrator, const char* name, double otherwise) {
  const auto given = integrator.parameters.find(name);
  return given == integrator.parameters.end() ? otherwise : given->second;
}

void check_method(const LawUse& integrator) {
  const auto refuse = [](const std::string& what) { throw Error(ErrorKind::input, "learning: " + what); };
  if (integrator.id != "recurrent")
    refuse(fmt::format("the integrator is '{}'; only steps of 'recurrent' are differentiated", integrator.id));
  if (option(integrator, "sweeps", 0.0) != 0.0)
    refuse("a step with a given number of sweeps is no fixed point, which is what is differentiated; set sweeps = 0");
}

void check_net(const Network& network) {
  if (!network.contacts().empty())
    throw Error(ErrorKind::input,
                "learning: contact of bodies with each other ([[contact]]) is not differentiated; leave it out");
}

}  // namespace springnet::learning
