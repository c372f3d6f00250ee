#include "rigs/rig.h"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "host/gather/begin.h"
#include "python/binding/binding.h"
#include "rigs/iio_rig.h"
#include "rigs/registry.h"
#include "rigs/rig_watch.h"

/// A rig for Python: the functions of `powbench run`, so the same lease, interlocks and limits. A second line does
/// nothing but look on and stop; it works while a shot is under way, and Ctrl-C uses it.

namespace py = pybind11;

namespace powbench::python {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds watch_limit{1500};
constexpr milliseconds look_interval{50};

/// What a shot gave, judged by the plan's rule on the angle.
struct FiredShot {
  Outcome outcome = Outcome::error;
  std::string reason;
  std::optional<Record> record;
  std::optional<Events> events;
};

/// Of one request: nothing more is fired once `flag` is set or a stop has come since it was made.
struct StopFlag final : host::RunWatcher {
  explicit StopFlag(const std::atomic<int>& all) : stops(all) {}
  std::atomic<bool> flag = false;
  const std::atomic<int>& stops;
  const int before = stops;
  bool stopped() override { return flag || stops != before; }
};

rigs::Endpoint endpoint_of(const std::string& uri, const std::string& specimen_file) {
  const auto known = [&](const rigs::RigKind& kind) { return uri.starts_with(kind.scheme); };
  if (std::none_of(std::begin(rigs::rig_kinds), std::end(rigs::rig_kinds), known))
    rigs::open(uri, {}, {});  // says what a rig is named like
  const host::RigFile file = host::rig_file(uri);
  return rigs::endpoint(
      uri, file.config,
      specimen_file.empty() ? host::load_specimen(file) : host::read_specimen(specimen_file));
}

class OpenRig {
 public:
  OpenRig(const std::string& uri, const std::string& specimen_file)
      : uri_(uri), endpoint_(endpoint_of(uri, specimen_file)), rig_(rigs::connect_iio(endpoint_.uri)) {}

  const rigs::RigInfo& info() {
    check_open();
    return rig_->info();
  }

  FiredShot fire(const ClosingArgs& args) {
    const host::Scene scene = one_closing(args, "fire");
    FiredShot out;
    work([&](StopFlag&) {
      const host::RunOptions options = host::run_options(scene.plan);
      rigs::Shot shot = rig_->fire(scene.shots.front().conditions, options.shot_limit);
      out.outcome = shot.outcome;
      out.reason = shot.reason;
      if (shot.outcome != Outcome::pass) return;
      out.events = host::extract_checked(shot.record, options);
      host::Judgement j = host::judge_shot(*out.events, shot.record.conditions, options);
      out.outcome = j.outcome;
      out.reason = std::move(j.reason);
      out.record = std::move(shot.record);
    });
    return out;
  }

  py::dict run(const std::string& plan, const std::string& database, bool resume,
               const std::string& progress_word) {
    host::RunSummary summary;
    std::int64_t campaign = 0;
    std::vector<std::string> notes;
    work([&](StopFlag& stop) {
      const host::Scene scene = host::load_scene(plan);
      host::Store store(database);
      campaign = host::begin_campaign(store, scene, uri_, rig_->info(), resume,
                                      [&](const std::string& text) { notes.push_back(text); });
      host::RunOptions options = host::run_options(scene.plan);
      options.watcher = &stop;
      host::Progress progress("acquire", scene.shots.size(), host::progress_style(progress_word));
      summary = host::run_campaign(store, campaign, scene.shots, *rig_, options, progress);
      progress.finish();
    });
    py::dict d;
    d["campaign"] = campaign;
    d["planned"] = summary.planned;
    d["done"] = summary.done();
    for (std::size_t i = 0; i < outcome_names.size(); ++i) d[outcome_names[i].data()] = summary.counts[i];
    d["stopped"] = summary.stopped.empty() ? py::object(py::none()) : py::object(py::str(summary.stopped));
    d["notes"] = notes;
    return d;
  }

  /// Coil off, whoever owns the rig; any thread. Returns the rig's state afterwards.
  std::string stop() {
    ++stops_;
    const py::gil_scoped_release release;
    return stop_now();
  }

  rigs::RigStatus status() {
    const py::gil_scoped_release release;
    const std::scoped_lock lock(watch_mutex_);
    return watch().status();
  }

  void close() {
    const py::gil_scoped_release release;
    const std::scoped_lock lock(rig_mutex_, watch_mutex_);
    watch_.reset();
    rig_.reset();
    endpoint_ = {};
  }

 private:
  void check_open() const {
    if (!rig_) throw rigs::RigError(uri_ + ": is closed");
  }

  rigs::RigWatch& watch() {
    if (endpoint_.uri.empty()) throw rigs::RigError(uri_ + ": is closed");
    if (!watch_) watch_ = std::make_unique<rigs::RigWatch>(endpoint_.uri, watch_limit);
    return *watch_;
  }

  std::string stop_now() {
    const std::scoped_lock lock(watch_mutex_);
    try {
      watch().stop();
      return watch().state();
    } catch (const rigs::RigError&) {
      watch_.reset();  // a new line the next time
      throw;
    }
  }

  /// Runs body(stop) on another thread, without the interpreter, and looks for Ctrl-C: then the coil is switched off,
  /// the body ends and KeyboardInterrupt is raised. One body at a time.
  template <class Body>
  void work(const Body& body) {
    check_open();
    std::mutex mutex;
    std::condition_variable ended;
    bool done = false;
    std::exception_ptr trouble;
    StopFlag stop(stops_);
    std::thread thread([&] {
      const std::scoped_lock one(rig_mutex_);
      try {
        if (!rig_) throw rigs::RigError(uri_ + ": is closed");
        rig_->stop_when([&stop] { return stop.stopped(); });
        body(stop);
        rig_->stop_when({});
      } catch (...) {
        trouble = std::current_exception();
      }
      const std::scoped_lock lock(mutex);
      done = true;
      ended.notify_all();
    });
    const auto wait = [&] {
      const py::gil_scoped_release release;
      std::unique_lock lock(mutex);
      return ended.wait_for(lock, look_interval, [&] { return done; });
    };
    bool interrupted = false;
    while (!wait())
      if (!interrupted && PyErr_CheckSignals() != 0) {
        interrupted = true;
        stop.flag = true;
        const py::error_already_set kept;  // KeyboardInterrupt, raised again below
        const py::gil_scoped_release release;
        try {
          stop_now();
        } catch (const rigs::RigError&) {
          // the rig's own limits switch the coil off
        }
      }
    thread.join();
    if (interrupted) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
      throw py::error_already_set();
    }
    if (trouble) std::rethrow_exception(trouble);
  }

  std::string uri_;
  std::atomic<int> stops_ = 0;
  rigs::Endpoint endpoint_;
  std::unique_ptr<rigs::Rig> rig_;
  std::unique_ptr<rigs::RigWatch> watch_;
  std::mutex rig_mutex_, watch_mutex_;
};

py::dict info_dict(OpenRig& open) {
  const rigs::RigInfo& i = open.info();
  py::dict d;
  d["uri"] = i.uri;
  d["description"] = i.description;
  d["model"] = i.model;
  d["serial"] = i.serial;
  d["firmware"] = i.firmware;
  d["kind"] = i.kind;
  d["origin"] = std::string(name(origin_of_kind(i.kind)));
  d["programmable_source"] = i.programmable_source;
  d["sample_rate_hz"] = i.sample_rate;
  d["calibration"] = i.calibration;
  d["calibration_expires"] = i.calibration_expires;
  py::dict channels;
  for (const auto& c : i.channels) channels[c.label.c_str()] = py::make_tuple(c.unit, c.scale);
  d["channels"] = channels;
  return d;
}

py::dict status_dict(OpenRig& open) {
  const rigs::RigStatus s = open.status();
  py::dict d;
  d["state"] = s.state;
  d["fault"] = s.fault;
  d["phase"] = s.phase;
  d["owner"] = s.owner;
  d["last_error"] = s.last_error;
  return d;
}

py::list rig_kinds() {
  py::list list;
  for (const rigs::RigKind& k : rigs::rig_kinds)
    list.append(py::make_tuple(std::string(k.scheme), std::string(k.example), std::string(k.meaning)));
  return list;
}

}  // namespace

void add_rig(py::module_& m) {
  py::class_<FiredShot>(m, "Shot",
                        "How one closing on a rig ended. Record and events are None where none was taken.")
      .def_property_readonly(
          "outcome", [](const FiredShot& s) { return std::string(name(s.outcome)); },
          "PASS, FAIL, ERROR, TIMEOUT, ABORTED, NOT JUDGED or NOT OBSERVED.")
      .def_readonly("reason", &FiredShot::reason,
                    "Why it is no PASS, one sentence; empty where nothing is to say.")
      .def_readonly("record", &FiredShot::record,
                    "The record, checked against the rig's own checksum; or None.")
      .def_readonly("events", &FiredShot::events, "Events extracted from it; or None.");
  py::class_<OpenRig>(m, "Rig")
      .def(py::init([](const std::string& uri, const std::string& specimen) {
             const py::gil_scoped_release release;
             return std::make_unique<OpenRig>(uri, specimen);
           }),
           py::arg("uri"), py::arg("specimen"))
      .def("info", &info_dict)
      .def("status", &status_dict)
      .def("fire", &OpenRig::fire, py::arg("args"))
      .def("run", &OpenRig::run, py::arg("plan"), py::arg("db"), py::arg("resume"), py::arg("progress"))
      .def("stop", &OpenRig::stop)
      .def("close", &OpenRig::close);
  m.def("rig_kinds", &rig_kinds, "(scheme, example, meaning) of every kind of rig that a URI can name.");
}

}  // namespace powbench::python
