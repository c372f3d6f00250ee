#pragma once

#include <cstdlib>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace powbench {

/// For the first line of a program that works on records: memory of arrays up to 4 MB stays with the process once
/// freed, 16 MB of it at most at the end of the heap. As delivered, the C library gives arrays above 128 KB back at
/// once, and to be given new pages for each array of a record took a sixth of the time of an extraction.
inline void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 4 << 20);
  mallopt(M_TRIM_THRESHOLD, 16 << 20);
  mallopt(M_TOP_PAD, 1 << 20);
#endif
}

}  // namespace powbench
