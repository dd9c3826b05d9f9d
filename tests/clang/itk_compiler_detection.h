// Stands before ITK's header of this name. Debian's ITK 5.2 knows no compiler but GCC: clang passes for it while
// ITK looks.
#pragma push_macro("__clang__")
#pragma push_macro("__GNUC__")
#undef __clang__
#undef __GNUC__
#define __GNUC__ 12
#include_next <itk_compiler_detection.h>
#pragma pop_macro("__GNUC__")
#pragma pop_macro("__clang__")
