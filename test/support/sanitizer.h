#pragma once
// The build says TALUS_SANITIZER where a sanitizer is in it.
#if defined(TALUS_SANITIZER)
#define TALUS_SKIP_UNDER_SANITIZER(why) GTEST_SKIP() << "built with " TALUS_SANITIZER ": " why
#else
#define TALUS_SKIP_UNDER_SANITIZER(why) static_assert(true)
#endif
