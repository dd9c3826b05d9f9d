// Included before every source that clang compiles. Debian's ITK 5.2 accepts GCC only, so its compiler check sees clang
// as GCC 12 here; later includes of that header do nothing.
#if __has_include(<itk_compiler_detection.h>)
#pragma push_macro("__clang__")
#pragma push_macro("__GNUC__")
#undef __clang__
#undef __GNUC__
#define __GNUC__ 12
#include <itk_compiler_detection.h>
#pragma pop_macro("__GNUC__")
#pragma pop_macro("__clang__")
#endif
