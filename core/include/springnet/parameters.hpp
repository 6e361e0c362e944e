// Parameters of components, as a scene or a program gives them.
#pragma once

#include <functional>
#include <map>
#include <string>

namespace springnet {

// Values by name, each in the unit that the component declares. A choice is given by its index, a boolean as 0 or 1.
using ParameterValues = std::map<std::string, double, std::less<>>;

}  // namespace springnet
