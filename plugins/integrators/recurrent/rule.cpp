#include "rule.hpp"

#include "newton.hpp"
#include "ordered.hpp"
#include "synchronous.hpp"

namespace springnet::recurrent {

const char* name_of(Update update) noexcept {
  switch (update) {
    case Update::synchronous:
      return "synchronous";
    case Update::wavefront:
      return "wavefront";
    case Update::block:
      return "block";
    case Update::coloured:
      return "coloured";
    case Update::newton:
      return "newton";
    case Update::automatic:
      break;
  }
  return "automatic";
}

std::unique_ptr<Rule> make_rule(Update update, Workspace& workspace) {
  switch (update) {
    case Update::synchronous:
      return std::make_unique<Synchronous>(workspace);
    case Update::wavefront:
      return std::make_unique<WavefrontRule>(workspace, false);
    case Update::block:
      return std::make_unique<WavefrontRule>(workspace, true);
    case Update::coloured:
      return std::make_unique<Coloured>(workspace);
    case Update::newton:
    case Update::automatic:
      break;
  }
  return std::make_unique<Newton>(workspace);
}

}  // namespace springnet::recurrent
