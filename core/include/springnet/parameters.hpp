// Parameters and tables of components, as a scene or a program gives them.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace springnet {

// Values by name, each in the unit that the component declares. A choice is given by its index, a boolean as 0 or 1.
using ParameterValues = std::map<std::string, double, std::less<>>;

// Tables by name: arrays of numbers, each in the unit that the law declares.
using TableValues = std::map<std::string, std::vector<double>, std::less<>>;

}  // namespace springnet
