// Makes the test program run out of memory on request.
#pragma once

namespace springnet::testing {

// For this thread: number of allocations that succeed before one fails; after that all succeed again. Below 0: all do.
extern thread_local int allocations_left;

}  // namespace springnet::testing
