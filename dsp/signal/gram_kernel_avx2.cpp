#include "dsp/signal/gram_kernel_body.h"

namespace powbench::dsp {

const GramKernel& avx2_gram_kernel() {
  static constexpr GramKernel kernel{"avx2", gram_run<2>};
  return kernel;
}

}  // namespace powbench::dsp
