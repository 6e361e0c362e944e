// Memory of the test program that runs out when a test says so.
#pragma once

namespace springnet::testing {

// Of this thread: allocations that still succeed, then one that does not, then all do again. Below 0: all do.
extern thread_local int allocations_left;

}  // namespace springnet::testing
