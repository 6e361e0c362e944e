// What a program needs of each thread in which the library calls plugins.
#pragma once

#include <springnet/export.hpp>

namespace springnet {

// From now on every thread calls `prepare` once, before its first call of a component: those of the program, and the
// library's own, which start when a simulation needs them and end whenever it needs them no more. For what belongs to a
// thread, such as the alternate stack (sigaltstack) on which a signal handler runs once the thread's own is used up;
// the library itself changes nothing of a thread. Set it before the first simulation. Null: nothing is called.
SPRINGNET_API void prepare_calling_threads(void (*prepare)() noexcept) noexcept;

}  // namespace springnet
