// What the tool asks of its process: standard streams and signals. A program that embeds the library has its own ways,
// so none of this is in the library.
#pragma once

namespace springnet::tool {

// Before anything is opened. Standard streams that are closed name nothing else from then on, though they cannot be
// used: else what is printed would end up in the first file that a run makes. A file that grows beyond its limit
// (ulimit -f) is a full disk, not the end of the process.
void prepare_process() noexcept;

// For commands that work for long: a pipe that nobody reads any more is an error of the stream, not the end of the
// process.
void outlive_readers() noexcept;

// After this, the first request to end (Ctrl-C, SIGTERM), a terminal that goes
// (SIGHUP) and spent processor time (SIGXCPU) make interrupted() true, so that a run can end in order. Ctrl-C and
// SIGTERM end the process at once when they come again. What is ignored at the start, as by nohup, stays ignored.
void catch_interrupts() noexcept;
[[nodiscard]] bool interrupted() noexcept;

}  // namespace springnet::tool
