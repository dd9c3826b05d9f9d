// Functions compiled for several processors: which of them is run the program finds out as it starts. All
// that such a function calls and whose source it sees is inlined, and so compiled with it.
#pragma once

#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
/// For processors with fused multiply-add, and for any.
#define BORELLI_INLINED_FOR_PROCESSOR [[gnu::flatten, gnu::target_clones("arch=x86-64-v3", "default")]]
/// For those with AVX-512 too: for what computes on Lanes.
#define BORELLI_LANES_FOR_PROCESSOR \
  [[gnu::flatten, gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")]]
#else
#define BORELLI_INLINED_FOR_PROCESSOR
#define BORELLI_LANES_FOR_PROCESSOR
#endif
