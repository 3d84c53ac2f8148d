#pragma once
// For tests of what the sanitizers replace.

namespace collided::test {

/// Whether the address and undefined-behaviour sanitizers are in the program, with their allocator and handlers of
/// signals.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace collided::test
