#include <springnet/version.hpp>

namespace springnet {

std::string_view version() noexcept { return SPRINGNET_VERSION; }

}  // namespace springnet
