#pragma once

namespace handgraft {

/// Whether this was built with a sanitizer that needs addresses and system calls of its own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kIsSanitized = true;  // g++
#elif defined(__has_feature)
inline constexpr bool kIsSanitized =
    __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);  // clang
#else
inline constexpr bool kIsSanitized = false;
#endif

}  // namespace handgraft
