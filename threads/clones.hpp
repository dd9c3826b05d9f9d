// One portable build that still uses wider registers where there are some.
#pragma once

/// A function compiled for processors with registers of four doubles, and for any: the loader picks the clone
/// that the machine can run. What it calls is compiled with it where it is inlined by force.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define BORELLI_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define BORELLI_VECTOR_CLONES
#endif
