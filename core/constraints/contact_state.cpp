#include "constraints/contact_state.hpp"

namespace springnet {

ContactStatus status_of(const Touch& touch) noexcept {
  switch (touch.count()) {
    case 0:
      return ContactStatus::free;
    case 1:
      return touch.slides ? ContactStatus::sliding : ContactStatus::sticking;
    default:
      return ContactStatus::cornered;
  }
}

Touch after(const Touch& before, const ContactCause& cause) noexcept {
  Touch result = before;
  switch (cause.kind) {
    case ContactCause::Kind::touch:
      if (cause.surface < 0 || before.has(cause.surface) || before.third >= 0) break;
      (before.surface < 0 ? result.surface : before.second < 0 ? result.second : result.third) = cause.surface;
      result.slides = !cause.sticks;
      break;
    case ContactCause::Kind::release:
      if (!before.has(cause.surface)) break;
      if (result.surface == cause.surface) result.surface = result.second;
      if (result.second == cause.surface || result.second == result.surface) result.second = result.third;
      result.third = -1;
      if (result.surface < 0) result.slides = false;
      break;
    case ContactCause::Kind::slip:
      if (before.surface >= 0) result.slides = true;
      break;
    case ContactCause::Kind::stick:
      result.slides = false;
      break;
  }
  return result;
}

}  // namespace springnet
