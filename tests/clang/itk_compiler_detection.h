// Included instead of ITK's header of this name. Debian's ITK 5.2 accepts GCC only, so this header presents clang as
// GCC 12 while ITK's header checks the compiler.
#pragma push_macro("__clang__")
#pragma push_macro("__GNUC__")
#undef __clang__
#undef __GNUC__
#define __GNUC__ 12
#include_next <itk_compiler_detection.h>
#pragma pop_macro("__GNUC__")
#pragma pop_macro("__clang__")
