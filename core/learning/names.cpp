#include <string>
#include <string_view>

#include <springnet/learn.hpp>

namespace springnet {

using Kind = LearnedValues::Kind;

std::string_view name_of(Kind kind) noexcept {
  switch (kind) {
    case Kind::spring_parameter:
      return "spring";
    case Kind::viscosity_parameter:
      return "viscosity";
    case Kind::rest_length:
      return "rest_length";
    case Kind::mass:
      return "mass";
    case Kind::neuron_parameter:
      return "neuron";
    case Kind::initial_velocity:
      return "velocity";
    case Kind::load:
      return "load";
    case Kind::gravity:
      return "gravity";
    case Kind::friction:
      return "friction";
  }
  return "";
}

std::string_view member_name(Kind kind, bool of_elements) noexcept {
  if (kind == Kind::mass || kind == Kind::neuron_parameter || kind == Kind::initial_velocity) return "node";
  if (kind == Kind::load) return "load";
  if (kind == Kind::gravity) return "axis";
  if (kind == Kind::friction) return "surface";
  return of_elements ? "element" : "spring";
}

std::string_view name_of(Optimiser optimiser) noexcept {
  switch (optimiser) {
    case Optimiser::levenberg_marquardt:
      return "levenberg";
    case Optimiser::lbfgs:
      return "lbfgs";
    case Optimiser::descent:
      return "descent";
  }
  return "";
}

std::string name_of(const LearnedParameter& parameter) {
  std::string name(parameter.of_elements ? "element." : "");
  name += name_of(parameter.kind);
  if (!parameter.parameter.empty()) name += "." + parameter.parameter;
  if (parameter.axis >= 0) name += std::string(".") + "xyz"[parameter.axis];
  if (parameter.kind == Kind::gravity) name += std::string(".") + "xyz"[parameter.member];
  return name;
}

}  // namespace springnet
