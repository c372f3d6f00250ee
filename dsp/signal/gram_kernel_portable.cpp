#include "dsp/signal/gram_kernel_body.h"

namespace powbench::dsp {

const GramKernel& portable_gram_kernel() {
  static constexpr GramKernel kernel{"portable", gram_run<4>};
  return kernel;
}

}  // namespace powbench::dsp
