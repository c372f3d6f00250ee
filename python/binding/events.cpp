#include "core/events.h"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "core/quantities.h"
#include "host/store/json.h"
#include "python/binding/binding.h"

namespace py = pybind11;

namespace powbench::python {

namespace {

/// The names of the flags that are set.
std::vector<std::string> flags_of(std::uint32_t flags) {
  std::vector<std::string> list;
  const std::string names = host::flag_names(flags);
  for (std::size_t at = 0; at < names.size();) {
    const std::size_t end = std::min(names.find(", ", at), names.size());
    list.push_back(names.substr(at, end - at));
    at = end + 2;
  }
  return list;
}

template <class T>
auto flags() {
  return [](const T& of) { return flags_of(of.flags); };
}

std::string repr(const Measured& m) {
  if (!m.known()) return "<not observed>";
  return py::str("{:.6g} +- {:.2g}").format(m.value, m.u).cast<std::string>();
}

py::dict quantities(const Events& e) {
  py::dict all;
  for (const Quantity& q : quantity_table) all[py::str(q.symbol.data(), q.symbol.size())] = q.of(e);
  return all;
}

}  // namespace

void add_events(py::module_& m) {
  py::class_<Measured>(m, "Measured",
                       "A value (SI) with its standard uncertainty u (k = 1). NaN: not observed.")
      .def_readonly("value", &Measured::value, "SI; NaN where it was not observed.")
      .def_readonly("u", &Measured::u, "Standard uncertainty, SI.")
      .def_property_readonly("known", &Measured::known, "The value was observed.")
      .def("__float__", [](const Measured& v) { return v.value; })
      .def("__repr__", &repr);
  py::class_<Contact>(m, "Contact", "One closed interval of one contact.")
      .def_readonly("touch", &Contact::touch, "s: the force leaves zero.")
      .def_readonly("release", &Contact::release,
                    "s: the force is back at zero; not known while it stays closed.")
      .def_readonly("peak", &Contact::peak, "N; NaN on the contact-voltage channel.")
      .def_readonly("impulse", &Contact::impulse,
                    "N s over the interval; NaN for the last, open-ended contact.")
      .def_readonly("probability", &Contact::probability, "That it is a contact of its own.")
      .def_property_readonly("flags", flags<Contact>(), "Why the values deserve less trust.");
  py::class_<ContactTrain>(m, "ContactTrain", "The touches that one channel shows.")
      .def_readonly("present", &ContactTrain::present, "The channel exists and passed its quality gate.")
      .def_property_readonly(
          "shows", [](const ContactTrain& t) { return std::string(name(t.shows)); },
          "contact, nothing, vibration or not usable.")
      .def_readonly("reason", &ContactTrain::reason, "Why it shows no contact; empty where it does.")
      .def_readonly("contacts", &ContactTrain::contacts, "In the order of touch.")
      .def_readonly("settled", &ContactTrain::settled, "s: last touch.")
      .def_readonly("settled_force", &ContactTrain::settled_force, "N: mean at the end of the record.")
      .def_readonly("bounce_time", &ContactTrain::bounce_time, "s: from the first touch to the last.")
      .def_readonly("bounce_count", &ContactTrain::bounce_count, "Re-openings within the bounce time.")
      .def_readonly("resolution", &ContactTrain::resolution,
                    "s: shortest opening that the channel can resolve.")
      .def_readonly("noise", &ContactTrain::noise, "rms before switch-on, in the channel's unit.")
      .def_property_readonly("flags", flags<ContactTrain>(), "Why the values deserve less trust.");
  py::class_<CoreEvents>(m, "CoreEvents", "The moving core, by the laser.")
      .def_readonly("present", &CoreEvents::present, "The channel exists and passed its quality gate.")
      .def_readonly("seat", &CoreEvents::seat, "s: first arrival at the closed position.")
      .def_readonly("settled", &CoreEvents::settled, "s: last arrival.")
      .def_readonly("bounce_time", &CoreEvents::bounce_time, "s: settled - seat.")
      .def_readonly("impact_velocity", &CoreEvents::impact_velocity, "m/s at the seat.")
      .def_readonly("travel", &CoreEvents::travel, "m: closed minus open position.")
      .def_property_readonly("flags", flags<CoreEvents>(), "Why the values deserve less trust.");
  py::class_<CoilEvents>(m, "CoilEvents", "The coil and its supply.")
      .def_readonly("closing_angle", &CoilEvents::closing_angle,
                    "rad, [0, 2 pi): phase of the mains at switch-on.")
      .def_readonly("no_angle", &CoilEvents::no_angle,
                    "Why the closing angle is not known; empty where it is.")
      .def_readonly("switch_on", &CoilEvents::switch_on,
                    "s: step of the coil voltage against the rig's fire sample.")
      .def_readonly("mains_hertz", &CoilEvents::mains_hertz, "Hz.")
      .def_readonly("supply_volts", &CoilEvents::supply_volts, "V rms of the fundamental before switch-on.")
      .def_readonly("peak_current", &CoilEvents::peak_current, "A: largest |i|.")
      .def_property_readonly("flags", flags<CoilEvents>(), "Why the values deserve less trust.");
  py::class_<Events>(m, "Events",
                     "All that happened in one closing. Times in s after switch-on; SI throughout.")
      .def_readonly("pvdf_a", &Events::pvdf_a, "Contacts by the force of film A.")
      .def_readonly("pvdf_b", &Events::pvdf_b, "Contacts by the force of film B.")
      .def_readonly("contact_voltage", &Events::contact_voltage, "The measured pole by its voltage.")
      .def_property_readonly(
          "pole_by_force", [](const Events& e) { return e.pole.by_force; },
          "The measured pole by both films.")
      .def_readonly("core", &Events::core, "The moving core.")
      .def_readonly("coil", &Events::coil, "Coil and supply.")
      .def_readonly("method", &Events::method, "Name of the extraction chain.")
      .def_readonly("parameters_hash", &Events::parameters_hash, "Of the extraction's options.")
      .def_property_readonly("flags", flags<Events>(), "Why the values deserve less trust.")
      .def_property_readonly(
          "quantities", &quantities,
          "The quantities of plans and reports, by symbol: t_ct1, t_ct_bon, ... (powbench.quantities()).")
      .def(
          "to_json", [](const Events& e) { return host::to_json(e, 2); },
          "The text that `powbench show --json` has under `events`: SI, null for what is not known.")
      .def("__repr__", [](const Events& e) {
        std::string text = "<Events";
        for (const Quantity& q : quantity_table)
          if (q.of(e).known())
            text += " " + std::string(q.symbol) + " = " + repr(q.of(e)) + " " + std::string(q.unit) + ";";
        return text + ">";
      });
  m.def(
      "quantities",
      [] {
        py::dict all;
        for (const Quantity& q : quantity_table)
          all[py::str(q.symbol.data(), q.symbol.size())] =
              py::make_tuple(std::string(q.unit), std::string(q.meaning));
        return all;
      },
      "Symbol -> (SI unit, meaning) of every quantity that plans limit and reports list.");
  m.def(
      "channels",
      [] {
        py::dict all;
        for (const ChannelInfo& c : channel_table)
          all[py::str(c.name.data(), c.name.size())] =
              py::make_tuple(std::string(c.unit), std::string(c.meaning));
        return all;
      },
      "Name -> (SI unit, meaning) of every channel of a record.");
}

}  // namespace powbench::python
