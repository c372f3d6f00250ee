#include "host/store/store.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <mutex>

#include "core/phase.h"
#include "core/quantities.h"
#include "host/gather/gather.h"
#include "host/gather/shown.h"
#include "python/binding/binding.h"
#include "python/binding/waveforms.h"

/// A store for reading. One connection, one thread at a time.

namespace py = pybind11;

namespace powbench::python {

namespace {

using host::CampaignInfo;
using host::ShotKind;
using host::StoredShot;

class OpenStore {
 public:
  explicit OpenStore(std::string path)
      : path_(std::move(path)), store_(path_, host::Store::Mode::read_only) {}

  /// Calls body(store) without the interpreter.
  template <class Body>
  auto with(const Body& body) {
    const py::gil_scoped_release release;
    const std::scoped_lock lock(mutex_);
    return body(store_);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  host::Store store_;
  std::mutex mutex_;
};

std::vector<ShotKind> kinds_of(const std::optional<std::string>& kind) {
  if (!kind) return {ShotKind::measured, ShotKind::simulated};
  for (const ShotKind k : {ShotKind::measured, ShotKind::simulated})
    if (name(k) == *kind) return {k};
  throw host::BadInput({"kind = '" + *kind + "': allowed measured, simulated, None"});
}

py::list campaigns(OpenStore& open) {
  struct Row {
    CampaignInfo c;
    std::size_t measured = 0, simulated = 0;
  };
  const auto rows = open.with([](const host::Store& store) {
    std::vector<Row> list;
    for (CampaignInfo& c : store.campaigns()) {
      Row row{std::move(c)};
      for (const auto& [outcome, n] : store.outcomes(row.c.id, ShotKind::measured)) row.measured += n;
      for (const auto& [outcome, n] : store.outcomes(row.c.id, ShotKind::simulated)) row.simulated += n;
      list.push_back(std::move(row));
    }
    return list;
  });
  py::list out;
  for (const Row& r : rows) {
    py::dict d;
    d["campaign"] = r.c.id;
    d["name"] = r.c.name;
    d["created"] = r.c.created;
    d["origin"] = std::string(name(r.c.origin));
    d["rig"] = r.c.rig_identity;
    d["finished"] = r.c.finished;
    d["measured"] = r.measured;
    d["simulated"] = r.simulated;
    d["plan"] = r.c.plan;
    d["specimen"] = r.c.specimen;
    d["program_version"] = r.c.program_version;
    out.append(d);
  }
  return out;
}

/// What stands in one row of the table of shots.
struct ShotRow {
  StoredShot s;
  std::optional<Events> events;
  std::vector<Measured> shown;  ///< by place in the table of quantities
};

template <class Of>
py::list column(const std::vector<ShotRow>& rows, const Of& of) {
  py::list list(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) list[i] = of(rows[i]);
  return list;
}

template <class Of>
py::array_t<double> numbers(const std::vector<ShotRow>& rows, const Of& of) {
  py::array_t<double> out(static_cast<py::ssize_t>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) out.mutable_data()[i] = of(rows[i]);
  return out;
}

py::dict shots(OpenStore& open, std::optional<std::int64_t> campaign,
               const std::optional<std::string>& kind) {
  const auto kinds = kinds_of(kind);
  const auto rows = open.with([&](const host::Store& store) {
    std::vector<ShotRow> list;
    const std::int64_t id = store.campaign(campaign).id;
    for (const ShotKind k : kinds)
      for (StoredShot& s : store.shots(id, k)) {
        const host::Shown shown(store, s);
        ShotRow row{std::move(s), std::nullopt, {}};
        if (!row.s.record_hash.empty()) row.events = shown.events;
        for (const Quantity& q : quantity_table) row.shown.push_back(row.events ? shown.of(q) : Measured{});
        list.push_back(std::move(row));
      }
    return list;
  });
  const auto reached = [](const ShotRow& r) { return r.events ? r.events->coil.closing_angle : Measured{}; };
  py::dict d;
  d["shot"] = column(rows, [](const ShotRow& r) { return py::int_(r.s.id); });
  d["kind"] = column(rows, [](const ShotRow& r) { return py::str(std::string(name(r.s.kind))); });
  d["number"] = column(rows, [](const ShotRow& r) { return py::int_(r.s.number); });
  d["repeat"] = column(rows, [](const ShotRow& r) { return py::int_(r.s.repeat); });
  d["attempt"] = column(rows, [](const ShotRow& r) { return py::int_(r.s.attempt); });
  d["outcome"] = column(rows, [](const ShotRow& r) { return py::str(std::string(name(r.s.outcome))); });
  d["reason"] = column(rows, [](const ShotRow& r) { return py::str(r.s.reason); });
  d["started"] = column(rows, [](const ShotRow& r) { return py::str(r.s.started); });
  d["record_sha256"] = column(rows, [](const ShotRow& r) { return py::str(r.s.record_hash); });
  d["angle"] = numbers(rows, [](const ShotRow& r) { return r.s.angle_deg; });
  d["supply"] = numbers(rows, [](const ShotRow& r) { return r.s.conditions.supply_volts; });
  d["mains"] = numbers(rows, [](const ShotRow& r) { return r.s.conditions.mains_hertz; });
  d["hold_time"] = numbers(rows, [](const ShotRow& r) { return r.s.conditions.hold_time; });
  d["ambient"] = numbers(rows, [](const ShotRow& r) { return r.s.conditions.ambient; });
  d["angle_reached"] = numbers(rows, [&](const ShotRow& r) { return degrees(reached(r).value); });
  d["u_angle_reached"] = numbers(rows, [&](const ShotRow& r) { return degrees(reached(r).u); });
  for (std::size_t k = 0; k < quantity_table.size(); ++k) {
    const std::string symbol(quantity_table[k].symbol);
    d[symbol.c_str()] = numbers(rows, [&](const ShotRow& r) { return r.shown[k].value; });
    d[("u_" + symbol).c_str()] = numbers(rows, [&](const ShotRow& r) { return r.shown[k].u; });
  }
  return d;
}

py::list compare(OpenStore& open, std::optional<std::int64_t> campaign) {
  const Comparison comparison =
      open.with([&](const host::Store& s) { return host::compare_stored(s, s.campaign(campaign)); });
  py::list out;
  for (const ComparisonRow& r : comparison.rows) {
    py::dict d;
    d["quantity"] = r.quantity;
    d["unit"] = r.unit;
    d["angle"] = degrees(r.closing_angle);
    d["n"] = r.repeats;
    d["measured"] = r.measured.value;
    d["u"] = r.measured.u;
    d["scatter"] = r.scatter;
    d["simulated"] = r.simulated;
    d["u_simulated"] = r.u_simulated;
    d["difference_over_U"] = r.difference_over_U();
    d["agreement"] = std::string(agreement(r.difference_over_U()));
    d["outcome"] = std::string(name(r.outcome));
    out.append(d);
  }
  return out;
}

/// (channel name -> array (shots, samples)) and the clock, for an xarray.Dataset.
template <class Float>
py::dict read_waveforms(const std::string& path, const std::vector<std::int64_t>& ids,
                        const std::vector<Channel>& channels, int threads) {
  std::vector<WaveformClock> clocks(ids.size());
  WaveformClock first;
  std::vector<std::string> units;
  {
    const py::gil_scoped_release release;
    first = clock_of(host::Store(path, host::Store::Mode::read_only), ids.front());
  }
  const auto n = static_cast<py::ssize_t>(ids.size()), samples = static_cast<py::ssize_t>(first.samples);
  py::dict arrays;
  std::vector<Float*> to;
  for (const Channel c : channels) {
    py::array_t<Float> array({n, samples});
    to.push_back(array.mutable_data());
    arrays[info(c).name.data()] = array;
  }
  {
    const py::gil_scoped_release release;
    fill_waveforms(path, ids, channels, first, std::span<Float* const>(to), clocks, threads);
  }
  py::array_t<double> offsets(n);
  for (std::size_t i = 0; i < clocks.size(); ++i) offsets.mutable_data()[i] = clocks[i].fire_offset;
  py::dict d;
  d["sample_rate"] = first.sample_rate;
  d["fire_sample"] = first.fire_sample;
  d["samples"] = first.samples;
  d["fire_offset"] = offsets;
  d["arrays"] = arrays;
  return d;
}

py::dict waveforms(OpenStore& open, const std::vector<std::int64_t>& ids,
                   const std::vector<std::string>& channels, bool doubles, int threads) {
  if (ids.empty()) throw host::BadInput({"waveforms: no shot is named, or none of them has a record"});
  std::vector<Channel> wanted;
  for (const std::string& name : channels) wanted.push_back(channel_named(name));
  return doubles ? read_waveforms<double>(open.path(), ids, wanted, threads)
                 : read_waveforms<float>(open.path(), ids, wanted, threads);
}

}  // namespace

void add_store(py::module_& m) {
  py::class_<OpenStore>(m, "Store")
      .def(py::init([](std::string path) {
             const py::gil_scoped_release release;
             return std::make_unique<OpenStore>(std::move(path));
           }),
           py::arg("path"))
      .def_property_readonly("path", &OpenStore::path)
      .def("campaigns", &campaigns)
      .def("shots", &shots, py::arg("campaign"), py::arg("kind"))
      .def("compare", &compare, py::arg("campaign"))
      .def(
          "record",
          [](OpenStore& s, std::int64_t shot) {
            return s.with([&](const host::Store& store) { return store.load_record(shot); });
          },
          py::arg("shot"))
      .def(
          "events",
          [](OpenStore& s, std::int64_t shot) {
            return s.with([&](const host::Store& store) { return store.load_events(shot); });
          },
          py::arg("shot"))
      .def("waveforms", &waveforms, py::arg("ids"), py::arg("channels"), py::arg("doubles"),
           py::arg("threads"));
}

}  // namespace powbench::python
