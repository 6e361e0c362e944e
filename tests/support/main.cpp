#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
// doctest derives this from the first one, unless its header has been included before, in a precompiled one.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
