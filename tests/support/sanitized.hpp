#pragma once
// For tests of what the sanitizers replace or slow down.

namespace collided::test {

/// Whether the address or the thread sanitizer is in the program, with its allocator and its handlers of signals.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif

}  // namespace collided::test
