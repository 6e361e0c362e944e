// Errors of the library: one exception type, whose message says what is wrong, where, and what to do.
#pragma once

#include <stdexcept>
#include <string>

#include <springnet/export.hpp>

namespace springnet {

enum class ErrorKind {
  simulation,  // the run failed: a step did not settle, a law returned a non-finite number, …
  input,       // a mistake in usage, scene or network
  plugin       // a plugin is missing, was refused, or violated its contract
};

class SPRINGNET_API Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  [[nodiscard]] ErrorKind kind() const noexcept { return kind_; }

 private:
  ErrorKind kind_;
};

}  // namespace springnet
