// Thrown when a file of a run cannot be written to the end, or has been removed.
#pragma once

#include <limits>
#include <string>

#include <springnet/error.hpp>

namespace springnet {

class OutputError : public Error {
 public:
  OutputError(const std::string& message, double kept_until, bool lost = false)
      : Error(ErrorKind::simulation, message), kept_until_(kept_until), lost_(lost) {}

  [[nodiscard]] double kept_until() const noexcept { return kept_until_; }  // s, of its last record; nan if it has none
  [[nodiscard]] bool lost() const noexcept { return lost_; }                // the file no longer exists

 private:
  double kept_until_;
  bool lost_;
};

}  // namespace springnet
