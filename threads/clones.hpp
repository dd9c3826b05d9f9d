// Lets one portable build use wide vector registers where the CPU has them.
#pragma once

/// Compiles a function twice: for CPUs with registers of four doubles (AVX2), and for any. The loader picks
/// the clone that the machine can run. Functions it calls are compiled with it only if they are always
/// inlined.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define BORELLI_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define BORELLI_VECTOR_CLONES
#endif
