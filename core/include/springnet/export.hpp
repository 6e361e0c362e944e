// What the shared library exports. All else of it is hidden: a function of a public header without SPRINGNET_API is
// either defined in the header or a mistake, which the linker reports.
#pragma once

// SPRINGNET_STATIC is defined where the library is linked statically: nothing is exported then, not even from a shared
// library that it becomes a part of.
#if defined(__GNUC__) && !defined(SPRINGNET_STATIC)
#define SPRINGNET_API __attribute__((visibility("default")))
#define SPRINGNET_LOCAL __attribute__((visibility("hidden")))
#else
#define SPRINGNET_API
#define SPRINGNET_LOCAL
#endif
