#include <pybind11/pybind11.h>

#include "host/config/bad_input.h"
#include "host/store/store.h"
#include "python/binding/binding.h"
#include "rigs/rig.h"

/// C++ exceptions as Python ones, with the same sentences. The last one registered is tried first.

namespace py = pybind11;

namespace powbench::python {

void add_errors(py::module_& m) {
  static py::object error, bad_input;
  error = py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(
      "powbench.Error", "What powbench says when something cannot be done; one sentence.", PyExc_Exception,
      nullptr));
  m.attr("Error") = error;
  const auto make = [&](const char* name, const char* doc, const py::object& base) {
    const std::string full = std::string("powbench.") + name;
    auto type =
        py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(full.c_str(), doc, base.ptr(), nullptr));
    m.attr(name) = type;
    return type;
  };
  bad_input = make(
      "BadInput",
      "Input that cannot be used. `errors` holds every mistake found: what is wrong, and what is allowed.",
      py::make_tuple(error, py::handle(PyExc_ValueError)));
  static py::object store_error =
      make("StoreError", "The store cannot be used: damaged, full, or not writable.", error);
  static py::object wrong_store = make(
      "WrongStore", "No store, campaign or shot of that name is there; nothing is damaged.", store_error);
  static py::object rig_error =
      make("RigError", "The rig cannot be reached, or its set-up is at fault.", error);

  py::register_exception_translator([](std::exception_ptr p) {
    try {
      std::rethrow_exception(p);
    } catch (const host::BadInput& e) {
      py::object value = bad_input(e.what());
      py::list errors;
      for (const std::string& line : e.errors()) errors.append(line);
      value.attr("errors") = errors;
      PyErr_SetObject(bad_input.ptr(), value.ptr());
    } catch (const host::WrongStore& e) {
      PyErr_SetString(wrong_store.ptr(), e.what());
    } catch (const host::StoreError& e) {
      PyErr_SetString(store_error.ptr(), e.what());
    } catch (const rigs::RigError& e) {
      PyErr_SetString(rig_error.ptr(), e.what());
    }
  });
}

}  // namespace powbench::python
