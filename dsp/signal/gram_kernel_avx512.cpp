#include "dsp/signal/gram_kernel_body.h"

namespace powbench::dsp {

const GramKernel& avx512_gram_kernel() {
  static constexpr GramKernel kernel{"avx512", gram_run<1>};
  return kernel;
}

}  // namespace powbench::dsp
