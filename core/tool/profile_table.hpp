// The profile of a run as a table.
#pragma once

#include <cstdint>
#include <string>

#include <springnet/profile.hpp>

namespace springnet::tool {

// Stages of less than a thousandth of the whole are left out and counted.
[[nodiscard]] std::string profile_text(const Profile& profile, std::uint64_t steps);

}  // namespace springnet::tool
