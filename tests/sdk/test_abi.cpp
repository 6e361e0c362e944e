#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>

#include "abi_sizes.h"

TEST_CASE("structs of ABI 2.x end at their frozen sizes, in C and in C++") {
#define CHECK_END(type, last, end)               \
  {                                              \
    INFO(#type " up to " #last);                 \
    CHECK(SPRINGNET_SIZE_TO(type, last) == end); \
  }
  SPRINGNET_ENDS_2_0(CHECK_END)
  SPRINGNET_ENDS_2_1(CHECK_END)
  CHECK(springnet_ends_wrong_in_c() == 0);
}

TEST_CASE("the magic number reads SPRNGNET in memory") {
  const std::uint64_t magic = SPRINGNET_MAGIC;
  CHECK(std::memcmp(&magic, "SPRNGNET", sizeof magic) == 0);
}

TEST_CASE("HAS_FIELD is false for fields beyond struct_size") {
  springnet_integrator integrator{};
  integrator.struct_size = SPRINGNET_SIZE_TO(springnet_integrator, destroy);
  CHECK(SPRINGNET_HAS_FIELD(springnet_integrator, &integrator, destroy));
  CHECK_FALSE(SPRINGNET_HAS_FIELD(springnet_integrator, &integrator, advance));
}
