#pragma once

// Loops that are worth it are compiled for several generations of processors; the program takes the
// best one when it starts. All give the same bits: IEEE operations have one result, in vectors too,
// and nothing is contracted.

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__gnu_linux__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(TALUS_ONE_CLONE)
#define TALUS_CLONES \
  __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"), flatten))
#else
#define TALUS_CLONES __attribute__((flatten))
#endif

/** The iterations of the next loop touch different memory. */
#if defined(__clang__)
#define TALUS_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define TALUS_INDEPENDENT _Pragma("GCC ivdep")
#endif

/** For functions that only fetch memory into the cache: a compiler sees no effect and would drop
 * the calls. */
#define TALUS_FETCHES [[gnu::always_inline]] inline
