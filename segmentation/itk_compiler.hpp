// Include before ITK's headers. Debian's ITK 5.2 knows GCC alone as a compiler: clang passes for it while it
// looks.
#pragma once

#ifdef __clang__
#pragma push_macro("__clang__")
#pragma push_macro("__GNUC__")
#undef __clang__
#undef __GNUC__
#define __GNUC__ 12
#include <itk_compiler_detection.h>
#pragma pop_macro("__GNUC__")
#pragma pop_macro("__clang__")
#endif
