#pragma once

#include <cholmod.h>

#include "core/late_library.h"

namespace powbench::sim {

/// CHOLMOD of SuiteSparse, which brings METIS and BLAS with it: loaded by the first field, not by a circuit.
struct Cholmod {
  LateLibrary library{POWBENCH_CHOLMOD};
  POWBENCH_LATE(cholmod_start);
  POWBENCH_LATE(cholmod_finish);
  POWBENCH_LATE(cholmod_analyze);
  POWBENCH_LATE(cholmod_analyze_p);
  POWBENCH_LATE(cholmod_factorize);
  POWBENCH_LATE(cholmod_solve);
  POWBENCH_LATE(cholmod_free_factor);
  POWBENCH_LATE(cholmod_free_dense);
  /// nullptr: a CHOLMOD without OpenMP
  void (*omp_set_max_active_levels)(int) = library.look_for<void (*)(int)>("omp_set_max_active_levels");
};

/// Throws std::runtime_error if it is not installed.
inline const Cholmod& cholmod() try {
  static const Cholmod one;
  return one;
} catch (const std::runtime_error& e) {
  throw std::runtime_error(std::string("fields need CHOLMOD, which ") + e.what() + "; install libcholmod3");
}

}  // namespace powbench::sim
