// What a scene, a command line or a program may ask for.
#pragma once

namespace springnet {

// More than any machine this runs on: a slip of the keyboard.
inline constexpr unsigned max_threads = 1024;

}  // namespace springnet
