// What the tool says when code of a plugin crashes.
#pragma once

#include <filesystem>

namespace springnet::tool {

// From now on a crash (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT) is reported in one line on stderr, with the component
// that was called and the springs or elements it was called for; complete records that wait in buffers are written.
// Then the process ends by that signal as it would have. Signals that somebody else handles, as sanitizers do, are left
// alone.
void report_crashes() noexcept;

// Where the present run writes, for the report.
void set_crash_folder(const std::filesystem::path& folder);

}  // namespace springnet::tool
