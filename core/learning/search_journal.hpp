// What a search has made, as bytes from which learn() goes on: minima of the legs that have ended, and the state of the
// present one. learn() decides again what it had decided then, without making those legs again.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <springnet/learn.hpp>

#include "learning/minimise.hpp"
#include "text/archive.hpp"
#include "text/identity.hpp"

namespace springnet::learning {

// What must be the same where a search goes on.
[[nodiscard]] Identity identity_of(const std::vector<Experiment>& experiments, const PluginHost& plugins,
                                   const std::vector<Learnable>& learnables, const LearnOptions& options);

class SearchJournal {
 public:
  // bytes: of with(); empty: the search begins. Throws Error(input) if they are damaged or have another identity.
  SearchJournal(Identity identity, std::string_view bytes);

  // The next leg, if it has ended; then of the one after.
  [[nodiscard]] std::optional<Minimum> ended_leg();
  // The state to go on from, if the next leg is the one that had not ended; else empty.
  [[nodiscard]] std::string present_leg() const;
  void end_leg(const Minimum& minimum);
  // The bytes, with this state of the present leg.
  [[nodiscard]] std::string with(std::string_view state) const;

 private:
  void archive_legs(Archive& archive);

  Identity identity_;
  std::vector<Minimum> legs_;  // that have ended
  std::size_t next_ = 0;       // leg
  std::string present_;
};

}  // namespace springnet::learning
