#pragma once

// The language of the public headers, each of which includes this one.

#if (defined(_MSVC_LANG) ? _MSVC_LANG : __cplusplus) < 202002L
#error "tagcal needs C++20: compile with -std=c++20, or link the CMake target tagcal::tagcal"
#endif
