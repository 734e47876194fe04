// Whether the build uses a sanitizer of addresses or threads: it is then at
// least five times slower, and tests with repetitions run fewer of them.
#ifndef KINEGRAPH_TESTS_SUPPORT_SANITIZED_H_
#define KINEGRAPH_TESTS_SUPPORT_SANITIZED_H_

namespace kinegraph::testing {

// GCC defines macros, Clang has __has_feature.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_SANITIZED_H_
