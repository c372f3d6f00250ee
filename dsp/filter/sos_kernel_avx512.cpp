#include "dsp/filter/sos_kernel_body.h"

namespace powbench::dsp {

const SosKernel& avx512_sos_kernel() {
  static constexpr SosKernel kernel{"avx512", run_frames, run_one, run_pieces};
  return kernel;
}

}  // namespace powbench::dsp
