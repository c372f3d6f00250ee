#include "core/record.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/events/extract.h"
#include "host/config/bad_input.h"
#include "host/import/counts.h"
#include "python/binding/binding.h"

/// Records for numpy, and numpy's arrays as a record.

namespace py = pybind11;

namespace powbench::python {

namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

constexpr std::size_t least_samples = 8;
constexpr double slowest = 1e3, fastest = 2.5e6;  // Hz

const ChannelRecord& find(const Record& r, const std::string& name) {
  if (const ChannelRecord* c = r.find(channel_named(name))) return *c;
  std::string there;
  for (const ChannelRecord& c : r.channels)
    there += (there.empty() ? "" : ", ") + std::string(info(c.channel).name);
  throw host::BadInput(
      {"the record has no channel '" + name + "'; it has " + (there.empty() ? "none" : there)});
}

py::array counts(const py::object& self, const std::string& name) {
  const ChannelRecord& c = find(self.cast<const Record&>(), name);
  py::array_t<std::int16_t> view(static_cast<py::ssize_t>(c.raw.size()), c.raw.data(), self);  // no copy
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

py::array_t<double> values(const Record& r, const std::string& name) {
  const ChannelRecord& c = find(r, name);
  py::array_t<double> out(static_cast<py::ssize_t>(c.raw.size()));
  fill_values(r, c, out.mutable_data());
  return out;
}

py::array_t<double> times(const Record& r) {
  py::array_t<double> out(static_cast<py::ssize_t>(r.samples()));
  double* to = out.mutable_data();
  for (std::size_t i = 0; i < r.samples(); ++i) to[i] = r.time(i);
  return out;
}

py::dict channel_facts(const Record& r, const std::string& name) {
  const ChannelRecord& c = find(r, name);
  py::dict d;
  d["unit"] = std::string(info(c.channel).unit);
  d["meaning"] = std::string(info(c.channel).meaning);
  d["scale"] = c.scale;
  d["offset"] = c.offset;
  d["delay_s"] = c.delay;
  d["corner_hertz"] = c.corner_hertz;
  d["clip_low"] = c.clip_low;
  d["clip_high"] = c.clip_high;
  return d;
}

py::dict conditions(const Record& r) {
  const Conditions& c = r.conditions;
  py::dict d;
  d["angle_deg"] = degrees(c.closing_angle);
  d["polarity"] = c.polarity;
  d["supply_volts"] = c.supply_volts;
  d["mains_hertz"] = c.mains_hertz;
  d["hold_time_s"] = c.hold_time;
  d["ambient_degC"] = c.ambient - zero_celsius;
  d["specimen"] = c.specimen;
  d["seed"] = c.seed;
  return d;
}

void check_clock(double rate, std::size_t samples, double first_time) {
  std::vector<std::string> wrong;
  if (!(rate >= slowest && rate <= fastest))
    wrong.push_back("sample_rate = " + std::to_string(rate) +
                    " Hz: allowed 1e3 .. 2.5e6; average a faster record down");
  if (samples < least_samples)
    wrong.push_back("the arrays have " + std::to_string(samples) + " sample(s); allowed " +
                    std::to_string(least_samples) + " or more");
  if (!(std::abs(first_time) < 1e6))
    wrong.push_back("first_time = " + std::to_string(first_time) +
                    " s: allowed a time near switch-on, which is 0");
  if (!wrong.empty()) throw host::BadInput(wrong);
}

/// Values of one channel as the counts of a converter; NaN is a lost sample.
ChannelRecord to_channel(const std::string& name, const Array& array, std::size_t samples) {
  if (array.ndim() != 1 || static_cast<std::size_t>(array.size()) != samples)
    throw host::BadInput({name + ": has " + std::to_string(array.ndim()) + " dimension(s) and " +
                          std::to_string(array.size()) +
                          " values; allowed one dimension and as many as the first, " +
                          std::to_string(samples)});
  ChannelRecord c;
  c.channel = channel_named(name);
  std::vector<double> value(array.data(), array.data() + samples);
  std::vector<bool> valid(samples);
  std::int64_t lost_from = -1;
  for (std::size_t i = 0; i < samples; ++i) {
    valid[i] = !std::isnan(value[i]);
    if (valid[i] && !(std::abs(value[i]) < 1e9))
      throw host::BadInput({name + "[" + std::to_string(i) + "] = " + std::to_string(value[i]) +
                            ": allowed below 1e9 in " + std::string(info(c.channel).unit) +
                            ", nan for a lost sample"});
    const auto at = static_cast<std::int64_t>(i);
    if (!valid[i] && lost_from < 0) lost_from = at;
    if (lost_from >= 0 && (valid[i] || i + 1 == samples)) {
      c.gaps.push_back({lost_from, at + (valid[i] ? 0 : 1) - lost_from});
      lost_from = -1;
    }
  }
  const bool film = c.channel == Channel::pvdf_a || c.channel == Channel::pvdf_b;
  host::to_counts(value, valid, film, std::numeric_limits<double>::quiet_NaN(), c);
  return c;
}

Record from_arrays(const py::dict& channels, double sample_rate, double first_time, double mains_hertz,
                   const std::string& calibration) {
  if (channels.empty())
    throw host::BadInput({"no channel is given; allowed one or more, as {\"pvdf_a\": array}"});
  Record r;
  std::size_t samples = 0;
  for (const auto& [key, value] : channels) {
    const auto name = key.cast<std::string>();
    const auto array = value.cast<Array>();
    if (r.channels.empty()) {
      samples = static_cast<std::size_t>(array.size());
      check_clock(sample_rate, samples, first_time);
    }
    r.channels.push_back(to_channel(name, array, samples));
  }
  std::sort(r.channels.begin(), r.channels.end(),
            [](const ChannelRecord& a, const ChannelRecord& b) { return a.channel < b.channel; });
  r.sample_rate = sample_rate;
  const double fire = std::ceil(-first_time * sample_rate - 1e-6);
  r.fire_sample = static_cast<std::int64_t>(fire);
  r.fire_offset = std::max(0.0, first_time + fire / sample_rate);
  Conditions& c = r.conditions;  // what nobody gave stays unknown
  c.closing_angle = c.supply_volts = c.ambient = std::numeric_limits<double>::quiet_NaN();
  c.mains_hertz = mains_hertz;
  c.specimen = "array";
  c.hold_time = std::max(r.time(samples - 1), 1e-3);
  r.rig = "array";
  r.calibration = calibration;
  return r;
}

/// Overrides by name; each must be one of the table, and be in its range.
dsp::ExtractOptions options_of(const Record& record, const py::dict& given) {
  dsp::ExtractOptions options;
  if (std::isfinite(record.conditions.mains_hertz)) options.mains_hertz = record.conditions.mains_hertz;
  for (const auto& [key, value] : given) {
    const auto name = key.cast<std::string>();
    bool known = false;
#define POWBENCH_X(type, option, unused, meaning) \
  if (name == #option) options.option = value.cast<type>(), known = true;
    POWBENCH_EXTRACT_OPTIONS(POWBENCH_X)
#undef POWBENCH_X
    if (!known)
      throw host::BadInput({"no extraction option '" + name + "'; powbench.extract_options() lists them"});
  }
  dsp::check(options);
  return options;
}

Events extract(const Record& record, const py::dict& given) {
  const dsp::ExtractOptions options = options_of(record, given);
  const py::gil_scoped_release release;
  return dsp::extract_events(record, options);
}

py::dict extract_options() {
  py::dict all;
  const dsp::ExtractOptions options;
#define POWBENCH_X(type, option, unused, meaning) all[#option] = py::make_tuple(options.option, meaning);
  POWBENCH_EXTRACT_OPTIONS(POWBENCH_X)
#undef POWBENCH_X
  return all;
}

std::vector<std::string> names(const Record& r) {
  std::vector<std::string> list;
  for (const ChannelRecord& c : r.channels) list.emplace_back(info(c.channel).name);
  return list;
}

}  // namespace

void add_record(py::module_& m) {
  py::class_<Record>(m, "Record",
                     "The sampled channels of one closing, as the converter gave them; never changed.")
      .def_readonly("sample_rate", &Record::sample_rate, "Hz, of every channel.")
      .def_readonly("fire_sample", &Record::fire_sample, "Index of the first sample at or after switch-on.")
      .def_readonly("fire_offset", &Record::fire_offset, "s from switch-on to fire_sample, below one sample.")
      .def_readonly("overruns", &Record::overruns, "Conversions lost, as counted by the rig.")
      .def_readonly("rig", &Record::rig, "Model and serial number.")
      .def_readonly("firmware", &Record::firmware, "Version.")
      .def_readonly("calibration", &Record::calibration, "Id of the calibration in force; empty: none.")
      .def_property_readonly("conditions", &conditions, "What the closing was asked to be; NaN: not known.")
      .def_property_readonly("channels", &names, "Names of the channels that it has, in scan order.")
      .def("channel", &channel_facts, py::arg("name"),
           "Unit, scale, offset, delay, corner and clip limits of a channel.")
      .def("counts", &counts, py::arg("name"),
           "Counts of a channel (int16, read-only view). SI: (count + offset) * scale.")
      .def("values", &values, py::arg("name"),
           "SI values of a channel (float64); NaN where samples were lost.")
      .def("times", &times, "s after switch-on of each sample (float64).")
      .def("__len__", &Record::samples);
  m.def("record_from_arrays", &from_arrays, py::arg("channels"), py::arg("sample_rate"),
        py::arg("first_time"), py::arg("mains_hertz"), py::arg("calibration"));
  m.def("extract_record", &extract, py::arg("record"), py::arg("options"));
  m.def("extract_options", &extract_options,
        "Name -> (default, meaning with unit) of every option of extract().");
}

}  // namespace powbench::python
