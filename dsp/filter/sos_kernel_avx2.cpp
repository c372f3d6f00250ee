#include "dsp/filter/sos_kernel_body.h"

namespace powbench::dsp {

const SosKernel& avx2_sos_kernel() {
  static constexpr SosKernel kernel{"avx2", run_frames, run_one, run_pieces};
  return kernel;
}

}  // namespace powbench::dsp
