// Standard streams and signals of the tool's process. Not in the library, because a host has its own policy.
#pragma once

namespace springnet::tool {

// Call it before anything is opened. Reserves the descriptors of closed standard streams: otherwise the first file of a
// run would get one of them, and what is printed would end up in it. Turns a file beyond its size limit (ulimit -f)
// into a write error, like a full disk, instead of a fatal signal.
void prepare_process() noexcept;

// For long commands: a pipe without a reader becomes a write error instead of a fatal signal.
void outlive_readers() noexcept;

// After this, Ctrl-C, SIGTERM, the loss of the terminal (SIGHUP) and the limit of processor time (SIGXCPU) make
// interrupted() true, so that a run can end in order; if that takes longer than a second, a line on standard error says
// what it waits for. A second Ctrl-C or SIGTERM ends the process at once. Signals that
// are ignored at the start, as under nohup, stay ignored.
void catch_interrupts() noexcept;
[[nodiscard]] bool interrupted() noexcept;

}  // namespace springnet::tool
