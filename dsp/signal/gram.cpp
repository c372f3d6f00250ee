#include "dsp/signal/gram.h"

namespace powbench::dsp {

namespace {

const GramKernel& best() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f")) return avx512_gram_kernel();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return avx2_gram_kernel();
#endif
  return portable_gram_kernel();
}

}  // namespace

void cross_products(const ColumnSet& a, const ColumnSet& b, std::size_t rows, double* c,
                    std::size_t c_stride) {
  static const GramKernel& kernel = best();
  const bool same = a.data == b.data && a.stride == b.stride && a.count == b.count;
  kernel.run(a, b, rows, c, c_stride, same);
  if (!same) return;
  for (std::size_t k = 0; k < b.count; ++k)
    for (std::size_t i = k + 1; i < a.count; ++i) c[i + k * c_stride] = c[k + i * c_stride];
}

}  // namespace powbench::dsp
