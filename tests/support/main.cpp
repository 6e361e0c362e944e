#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
// doctest makes this of the first, but not where its header has been included before, in a precompiled one.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
