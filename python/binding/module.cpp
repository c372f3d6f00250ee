#include <pybind11/pybind11.h>

#include "core/version.h"
#include "python/binding/binding.h"

/// The module `powbench._native`: the C++ side of the Python package. The package itself is python/powbench.

PYBIND11_MODULE(_native, m) {
  using namespace powbench::python;
  m.doc() = "C++ side of the package powbench; use the names of powbench itself.";
  m.attr("__version__") = powbench::program_version;
  add_errors(m);
  add_events(m);
  add_record(m);
  add_store(m);
  add_simulation(m);
  add_rig(m);
}
