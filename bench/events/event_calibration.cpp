#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/dsp_figures.h"
#include "bench/dsp_methods.h"
#include "bench/dsp_rig_truth.h"
#include "bench/events/scenes.h"
#include "bench/events/tally.h"
#include "core/memory.h"
#include "core/units.h"
#include "dsp/events/event_stream.h"
#include "dsp/events/extract.h"

/// Are the events and their uncertainties true on records that the extraction was not made with? Impacts from an
/// equation of motion, disturbances one at a time, and records in which nothing touches. Prints one table.
/// Usage: bench_event_calibration [--records N] [--seed FIRST] [--class SUBSTRING] [--json PATH] [--list all|wrong]
/// --list prints the records whose sequence is wrong or whose times lie beyond 3 u, contact by contact.

namespace {

using namespace powbench;
using namespace powbench::bench;

struct Arguments {
  int records = 40;
  std::uint64_t seed = 500000;  // tuning looks at other seeds
  std::string only, json, list;
};

Arguments parse(int argc, char** argv) {
  Arguments a;
  for (int i = 1; i < argc; i += 2) {
    const std::string key = argv[i];
    if (i + 1 >= argc) throw std::invalid_argument(key + ": unknown, or its value is missing");
    const std::string value = argv[i + 1];
    if (key == "--records")
      a.records = std::stoi(value);
    else if (key == "--seed")
      a.seed = std::stoull(value);
    else if (key == "--class")
      a.only = value;
    else if (key == "--json")
      a.json = value;
    else if (key == "--list" && (value == "all" || value == "wrong"))
      a.list = value;
    else
      throw std::invalid_argument(key + ": allowed --records --seed --class --json --list all|wrong");
  }
  return a;
}

double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Row {
  std::string name;
  bool touches = true;
  Tally tally;
  double cpu_ms = 0;  ///< a record
};

/// Truth and result of one record, us and N; a wrong one, or every one.
void list(const Row& row, std::uint64_t seed, const std::vector<TrueContact>& truth, const ContactTrain& t,
          bool every) {
  Tally one;
  one.add(truth, t);
  const auto far = [](const QuantityErrors& e) { return e.beyond() > 0; };
  if (!every && one.exact == 1 && !far(one.touch) && !far(one.release) && !far(one.peak) && !far(one.settled))
    return;
  std::printf("# %s, seed %llu: %d missed, %d invented, %s%s%s\n", row.name.c_str(),
              static_cast<unsigned long long>(seed), one.missed, one.invented,
              std::string(powbench::name(t.shows)).c_str(), t.reason.empty() ? "" : ", ", t.reason.c_str());
  for (const TrueContact& c : truth)
    std::printf("#   true  %9.1f .. %9.1f  peak %6.2f\n", 1e6 * c.touch, 1e6 * c.release, c.peak);
  const auto near = [&](const Contact& c) {
    return std::any_of(truth.begin(), truth.end(),
                       [&](const TrueContact& x) { return std::abs(x.touch - c.touch.value) < 300e-6; });
  };
  for (const Contact& c : t.contacts)
    std::printf("#   found %9.1f +- %5.1f .. %9.1f +- %5.1f  peak %6.2f +- %.2f  flags %x  p %.3f%s\n",
                1e6 * c.touch.value, 1e6 * c.touch.u, 1e6 * c.release.value, 1e6 * c.release.u, c.peak.value,
                c.peak.u, c.flags, c.probability, near(c) ? "" : "  invented");
  std::printf("#   settled %.1f +- %.1f\n", 1e6 * t.settled.value, 1e6 * t.settled.u);
}

void head() {
  std::printf("%-26s %4s %6s %6s %6s | %7s %7s %7s %5s %5s | %7s %7s %7s %5s %5s | %5s %5s | %5s %5s\n",
              "class", "rec", "recall", "prec", "exact", "touch", "median", "bias", "z std", ">3u %",
              "release", "median", "bias", "z std", ">3u %", "peak%", "settl", "flags", "CPU");
}

void print(const Row& r) {
  const Tally& t = r.tally;
  std::printf("%-26s %4d %6.3f %6.3f %6.3f |", r.name.c_str(), t.records, t.recall(), t.precision(),
              t.exact_share());
  for (const QuantityErrors* e : {&t.touch, &t.release})
    std::printf(" %7.2f %7.2f %7.2f %5.2f %5.1f |", 1e6 * e->rms(), 1e6 * e->median(), 1e6 * e->bias(),
                e->spread(), 100 * e->beyond());
  std::printf(" %5.1f %5.1f | %5.2f %5.1f\n", 100 * t.peak.beyond(), 100 * t.settled.beyond(),
              static_cast<double>(t.flagged) / std::max(1, t.contacts), r.cpu_ms);
}

nlohmann::json json_of(const QuantityErrors& e) {
  return {{"rms", e.rms()},      {"median", e.median()},    {"bias", e.bias()},
          {"z_std", e.spread()}, {"beyond_3u", e.beyond()}, {"values", e.error.size()}};
}

nlohmann::json json_of(const Row& r) {
  const Tally& t = r.tally;
  return {{"class", r.name},
          {"records", t.records},
          {"recall", t.recall()},
          {"precision", t.precision()},
          {"exact", t.exact_share()},
          {"touch_s", json_of(t.touch)},
          {"release_s", json_of(t.release)},
          {"peak_N", json_of(t.peak)},
          {"settled_s", json_of(t.settled)},
          {"invented", t.invented},
          {"cpu_ms", r.cpu_ms}};
}

/// Are edges beside a short opening as certain as they say?
nlohmann::json print_openings(const char* of, const Tally& t) {
  nlohmann::json rows = nlohmann::json::array();
  std::printf("%-14s", of);
  for (std::size_t k = 0; k < t.beside_opening.size(); ++k) {
    const QuantityErrors& e = t.beside_opening[k];
    std::printf(" | %5zu %6.2f %5.2f %5.1f", e.error.size(), 1e6 * e.rms(), e.spread(), 100 * e.beyond());
    nlohmann::json row = json_of(e);
    row["of"] = of, row["up_to_ms"] = Tally::longest_opening[k];
    rows.push_back(row);
  }
  std::printf("\n");
  return rows;
}

/// Both films of the simulated rig, six channels, one angle a record.
std::array<Row, 2> rig_rows(const Arguments& a) {
  std::array<Row, 2> rows{Row{"simulated rig, film A", true, {}, 0},
                          Row{"simulated rig, film B", true, {}, 0}};
  for (int k = 0; k < a.records; ++k) {
    const double angle = 2 * pi * (k + 0.3) / a.records;
    RigTruth r = rig_record(200e3, angle, 50.0, a.seed + static_cast<std::uint64_t>(k));
    std::erase_if(r.record.channels, [](const ChannelRecord& c) {
      return c.channel == Channel::contact_a || c.channel == Channel::aux;
    });
    const double before = cpu_ms();
    const Events e = dsp::extract_events(r.record, {});
    for (Row& row : rows) row.cpu_ms += (cpu_ms() - before) / a.records;
    for (std::vector<TrueContact>* film : {&r.film_a, &r.film_b})
      for (TrueContact& c : *film) c.peak = std::nan("");  // the plant's events have none
    rows[0].tally.add(r.film_a, e.pvdf_a);
    rows[1].tally.add(r.film_b, e.pvdf_b);
    if (a.list.empty()) continue;
    const auto seed = a.seed + static_cast<std::uint64_t>(k);
    list(rows[0], seed, r.film_a, e.pvdf_a, a.list == "all");
    list(rows[1], seed, r.film_b, e.pvdf_b, a.list == "all");
  }
  return rows;
}

/// The streaming form on impacts with restitution: what a sample costs, and its touches beside those of the whole
/// record.
nlohmann::json streamed(const Arguments& a) {
  double cpu = 0, latest = 0, samples = 0;
  QuantityErrors apart, error;
  int edges = 0, late = 0;
  for (int k = 0; k < a.records; ++k) {
    const Scene s = scene_classes()[2].make(a.seed + static_cast<std::uint64_t>(k));
    Record shape = s.record;
    for (ChannelRecord& c : shape.channels) c.raw.clear();
    dsp::EventStream stream(shape);
    const double before = cpu_ms();
    std::vector<dsp::StreamEvent> found = stream.push(0, s.record.channels.front().raw);  // one channel
    cpu += cpu_ms() - before, samples += static_cast<double>(s.record.samples());
    const Events whole = dsp::extract_events(s.record, {});
    for (const dsp::StreamEvent& e : found) {
      ++edges, latest = std::max(latest, e.latency()), late += e.latency() > dsp::stream_latency;
      if (e.kind != dsp::StreamEvent::Kind::touch) continue;
      for (const Contact& c : whole.pvdf_a.contacts)
        if (std::abs(c.touch.value - e.time.value) < 100e-6) apart.add(e.time, c.touch.value);
      for (const TrueContact& c : s.contacts)
        if (std::abs(c.touch - e.time.value) < 100e-6) error.add(e.time, c.touch);
    }
  }
  std::printf(
      "\nas a stream (%s): %.2f us of CPU a sample, %d edges, latest %.1f ms after it, %d later than stated; "
      "touch rms %.2f us, "
      "beyond 3 u %.1f %%, from the whole record's %.2f us\n",
      scene_classes()[2].name.c_str(), 1e3 * cpu / std::max(samples, 1.0), edges, 1e3 * latest, late,
      1e6 * error.rms(), 100 * error.beyond(), 1e6 * apart.rms());
  return {{"cpu_us_per_sample", 1e3 * cpu / std::max(samples, 1.0)},
          {"latest_s", latest},
          {"later_than_stated", late},
          {"touch_s", json_of(error)},
          {"from_whole_s", json_of(apart)}};
}

}  // namespace

int main(int argc, char** argv) try {
  powbench::keep_freed_memory();  // as the program does
  const Arguments a = parse(argc, argv);
  std::printf(
      "%d records a class from seed %llu; times in us; z: error over its stated standard uncertainty\n",
      a.records, static_cast<unsigned long long>(a.seed));
  head();
  Row all{"all", true, {}, 0}, silent{"nothing touches", false, {}, 0};
  Tally lowpass, lowpass_silent;
  nlohmann::json rows = nlohmann::json::array();
  const Method* peer = nullptr;
  for (const Method& m : methods())
    if (m.name == "hysteresis") peer = &m;
  double worst = 0;
  std::string worst_class;
  int classes = 0;
  for (const SceneClass& c : scene_classes()) {
    if (c.name.find(a.only) == std::string::npos) continue;
    Row row{c.name, c.touches, {}, 0};
    for (int k = 0; k < a.records; ++k) {
      const Scene s = c.make(a.seed + static_cast<std::uint64_t>(k));
      const double before = cpu_ms();
      const Events e = dsp::extract_events(s.record, {});
      row.cpu_ms += (cpu_ms() - before) / a.records;
      row.tally.add(s.contacts, e.pvdf_a);
      if (!a.list.empty())
        list(row, a.seed + static_cast<std::uint64_t>(k), s.contacts, e.pvdf_a, a.list == "all");
      if (!peer) continue;
      ContactTrain plain;
      plain.contacts = peer->contacts(s.record);
      (c.touches ? lowpass : lowpass_silent).add(s.contacts, plain);
    }
    print(row);
    std::fflush(stdout);
    rows.push_back(json_of(row));
    Row& sum = c.touches ? all : silent;
    sum.tally.add(row.tally);
    sum.cpu_ms += row.cpu_ms;
    ++classes;
    const double off = std::max(row.tally.touch.beyond(), row.tally.release.beyond());
    if (off > worst) worst = off, worst_class = c.name;
  }
  Tally rig;
  if (std::string("simulated rig").find(a.only) != std::string::npos)
    for (const Row& row : rig_rows(a)) {
      print(row);
      rows.push_back(json_of(row));
      rig.add(row.tally);
    }
  all.cpu_ms /= std::max(1, classes), silent.cpu_ms = 0;
  print(all);
  print(silent);
  std::printf(
      "\nlow-pass and hysteresis on the same records: recall %.3f, precision %.3f, touch median %.1f us; "
      "%d contacts invented where nothing touches\n",
      lowpass.recall(), lowpass.precision(), 1e6 * lowpass.touch.median(), lowpass_silent.invented);
  std::printf(
      "\nrelease before and touch after an opening, by its true length: edges, rms us, std of z, beyond 3 u "
      "%%\n%-14s",
      "");
  for (const char* length : {"up to 0.1 ms", "0.1 .. 0.2 ms", "0.2 .. 0.3 ms", "0.3 .. 0.5 ms", "longer"})
    std::printf(" | %-23s", length);
  std::printf("\n");
  const nlohmann::json openings{print_openings("impacts", all.tally), print_openings("simulated rig", rig)};
  const nlohmann::json stream = streamed(a);
  Tally whole = all.tally;
  whole.add(silent.tally);
  std::vector<Figure> figures{
      at_least("recall", whole.recall(), 0.98, 0.99),
      at_least("precision, records in which nothing touches included", whole.precision(), 0.98, 0.99),
      at_least("exact sequence", whole.exact_share(), 0.95, 0.97),
      at_most("touch rms, us", 1e6 * all.tally.touch.rms(), 6, 3),
      at_most("release rms, us", 1e6 * all.tally.release.rms(), 10, 5),
      at_most("release bias, us", 1e6 * all.tally.release.bias(), 2, 1),
      at_most("touch beyond 3 u, %", 100 * all.tally.touch.beyond(), 1, 0.5),
      at_most("release beyond 3 u, %", 100 * all.tally.release.beyond(), 1, 0.5),
      at_most("peak beyond 3 u, %", 100 * all.tally.peak.beyond(), 1, 0.5),
      at_most("settled beyond 3 u, %", 100 * all.tally.settled.beyond(), 1, 0.5),
      at_most("touch or release beyond 3 u in the worst class (" + worst_class + "), %", 100 * worst, 3, 1),
      between("touch: std of error / uncertainty", all.tally.touch.spread(), 0.8, 1.25, 0.9, 1.1),
      between("release: std of error / uncertainty", all.tally.release.spread(), 0.8, 1.25, 0.9, 1.1)};
  const auto share = [](int part, int of) { return of > 0 ? static_cast<double>(part) / of : std::nan(""); };
  figures.push_back(at_most("contacts of all classes with a flag, %",
                            100 * share(all.tally.flagged, all.tally.contacts), 20, 10));
  if (rig.records > 0) {
    figures.push_back(at_most("simulated rig: touch bias, us", 1e6 * rig.touch.bias(), 2, 1));
    figures.push_back(at_most("simulated rig: release bias, us", 1e6 * rig.release.bias(), 2, 1));
    figures.push_back(
        between("simulated rig: touch: std of error / uncertainty", rig.touch.spread(), 0.8, 1.25, 0.9, 1.1));
    figures.push_back(between("simulated rig: release: std of error / uncertainty", rig.release.spread(), 0.8,
                              1.25, 0.9, 1.1));
    figures.push_back(between("simulated rig: settled: std of error / uncertainty", rig.settled.spread(), 0.8,
                              1.25, 0.9, 1.1));
    figures.push_back(
        at_most("simulated rig: contacts with a flag, %", 100 * share(rig.flagged, rig.contacts), 20, 10));
  }
  const auto say_doubted = [&share](const char* of, const Tally::Doubted& d) {
    std::printf(
        "listed with a probability below 0.9, %s: %d contacts, mean probability %.2f, share that is real "
        "%.2f\n",
        of, d.listed, d.expected / std::max(1, d.listed), share(d.real, d.listed));
  };
  say_doubted("impacts and nothing", whole.doubted);
  say_doubted("simulated rig", rig.doubted);
  const nlohmann::json judged = print(figures);
  if (!a.json.empty()) {
    rows.push_back(json_of(all));
    rows.push_back(json_of(silent));
    std::ofstream(a.json) << nlohmann::json{{"rows", rows},
                                            {"openings", openings},
                                            {"stream", stream},
                                            {"figures", judged}}
                                 .dump(1)
                          << "\n";
  }
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 2;
}
