// What a crash would lose of the tables: records that wait in buffers.
#pragma once

#include <springnet/export.hpp>

namespace springnet {

// Writes the complete records in the buffers of all open output files, for handlers of signals such as SIGSEGV after
// which the process ends: nothing else may use the files any more. Async-signal-safe. Call it only if no thread is
// recording, as while a law is evaluated.
SPRINGNET_API void write_whole_records() noexcept;

}  // namespace springnet
