#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "host/run/simulate.h"
#include "python/binding/binding.h"
#include "rigs/simulated_record.h"

/// One closing of the simulator, by the path that `powbench sim` takes.

namespace py = pybind11;

namespace powbench::python {

namespace {

struct Closing {
  Record record;
  Events events;
  sim::ClosingTruth truth;
};

Closing simulate(const ClosingArgs& args, const std::string& sensors) {
  const py::gil_scoped_release release;
  const host::Scene scene = one_closing(args, "simulate");
  const rigs::SimRigConfig rig = sensors.empty() ? rigs::SimRigConfig{} : host::read_rig(sensors).config;
  rigs::SimulatedClosing closing = rigs::simulate_record(scene.specimen, scene.shots.front().conditions, rig);
  Closing out{std::move(closing.record), {}, closing.truth};
  out.events = host::extract_checked(out.record, host::run_options(scene.plan));
  return out;
}

py::dict truth(const Closing& c) {
  const sim::ClosingTruth& t = c.truth;
  py::dict d;
  d["touch_s"] = t.touch;
  d["settled_s"] = t.settled;
  d["touch_a_s"] = t.touch_a;
  d["touch_b_s"] = t.touch_b;
  d["core_seat_s"] = t.core_seat;
  d["core_settled_s"] = t.core_settled;
  // a speed belongs to an event: without one it is not zero
  d["touch_velocity_m_per_s"] = t.touch ? std::optional(t.touch_velocity) : std::nullopt;
  d["seat_velocity_m_per_s"] = t.core_seat ? std::optional(t.seat_velocity) : std::nullopt;
  py::list openings;
  for (const sim::Opening& o : t.openings) openings.append(py::make_tuple(o.release, o.touch));
  d["openings_s"] = openings;
  return d;
}

}  // namespace

void add_simulation(py::module_& m) {
  py::class_<ClosingArgs>(m, "ClosingArgs")
      .def(py::init<double, double, double, double, double, double, unsigned long long, std::string>());
  py::class_<Closing>(m, "Closing",
                      "A simulated closing: record, events extracted from it, and the simulator's own truth.")
      .def_readonly("record", &Closing::record, "As the virtual sensors of the rig gave it.")
      .def_readonly("events", &Closing::events, "Extracted from the record, as from a measured one.")
      .def_property_readonly(
          "truth", &truth,
          "Located by the integrator, unaffected by sensors; s after switch-on; None: did not happen.");
  m.def("simulate_closing", &simulate, py::arg("args"), py::arg("sensors"));
}

}  // namespace powbench::python
