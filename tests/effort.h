#pragma once

/// Long walks over many alike cases keep one case in `every` under the sanitizers, which slow each down tenfold; the
/// release build walks them all. The step is a prime, so that no pattern of the cases hides behind it.
namespace powbench::effort {

#if defined(__SANITIZE_ADDRESS__)
inline constexpr int every = 7;
#else
inline constexpr int every = 1;
#endif

}  // namespace powbench::effort
