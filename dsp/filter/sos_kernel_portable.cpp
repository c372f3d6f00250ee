#include "dsp/filter/sos_kernel_body.h"

namespace powbench::dsp {

const SosKernel& portable_sos_kernel() {
  static constexpr SosKernel kernel{"portable", run_frames, run_one, run_pieces};
  return kernel;
}

}  // namespace powbench::dsp
