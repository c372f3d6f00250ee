#include "host/config/plan_file.h"

#include <algorithm>
#include <cmath>

#include "core/channel_set.h"
#include "core/phase.h"
#include "host/config/file_reader.h"
#include "host/config/solenoid_file.h"
#include "host/config/specimen_file.h"
#include "sim/models/mechanics.h"

namespace powbench::host {
namespace {

constexpr double most_shots = 100'000;

/// Suffix of the limit keys of a quantity: times are given in ms.
std::string limit_suffix(const Quantity& q) {
  if (q.unit == "s") return "ms";
  return q.unit == "m/s" ? "m_per_s" : std::string(q.unit);
}

FileKind kind_of(Plan& p) {
  FileKind kind("plan", "what a campaign does");
  kind.text("name", p.name, "name of the campaign");
  kind.text("specimen", p.specimen,
            "specimen file, relative to this file; without it the built-in reference contactor");
  kind.sweep("angles_deg", p.angles, {0, 360},
             "closing angles (0 = rising zero crossing): a list, or { start = 0, stop = 180, step = 30 }",
             Need::required);
  kind.integer("repeats", p.repeats, {1, 10'000}, "closings at each angle", Need::required);
  kind.choice(
      "order", p.order, {"random", "sequential", "by_hand"},
      "of the angles within each repeat; random keeps coil heating out of the angle's effect; by_hand marks "
      "single closings that nobody planned");
  kind.seed("seed", p.seed, "of the order and of everything random in the shots");
  kind.number("supply_volts", p.supply_volts, {1, 1000}, "rms, at the coil terminals");
  kind.number("mains_hertz", p.mains_hertz, {10, 1000}, "mains frequency");
  kind.number("hold_time_ms", p.hold_time, {1, 10'000}, "how long the coil stays switched on");
  kind.number("pause_s", p.pause, {0, 3600}, "between two shots, for the coil to cool down");
  kind.number("ambient_degC", p.ambient, {-50, 150}, "ambient and coil temperature at the start");
  kind.number(
      "supply_u_percent", p.supply_u, {0, 20},
      "standard uncertainty of the measured supply voltage's scale, for what is simulated; left out: 0.5 %",
      Need::optional);
  kind.number("coil_temperature_u_K", p.coil_temperature_u, {0, 100},
              "standard uncertainty of the coil's temperature, likewise; left out: 2 K", Need::optional);
  kind.choice("polarity", p.polarity, {"positive", "negative", "alternate"},
              "negative fires half a period later; alternate changes from shot to shot");
  kind.choice("decision_rule", p.decision, {"simple", "guarded"},
              "of the limits: simple, the value decides; guarded, it must be inside by its uncertainty U");
  kind.number("angle_tolerance_deg", p.angle_tolerance, {0.01, 90}, "a shot further off its angle fails");
  kind.number("crosstalk_a_percent", p.crosstalk_a, {-50, 50},
              "share of film B's force that film A shows, from the bench's calibration; taken out");
  kind.number("crosstalk_b_percent", p.crosstalk_b, {-50, 50}, "the same of film A's force on film B");
  kind.number("limits_vs_simulation_percent", p.limits_vs_simulation, {0, 1000},
              "largest difference between measurement and simulation", Need::optional);
  for (std::size_t i = 0; i < quantity_table.size(); ++i) {
    const Quantity& q = quantity_table[i];
    kind.section("limits." + std::string(q.symbol), std::string(q.meaning));
    kind.number("min_" + limit_suffix(q), p.limits[i].low, {0, 1e6}, "smallest value that passes",
                Need::optional);
    kind.number("max_" + limit_suffix(q), p.limits[i].high, {0, 1e6}, "largest value that passes",
                Need::optional);
  }
  kind.section("test", "the test record on the report's first page; `powbench annotate` completes it later");
  for (const RecordField& f : record_fields)
    kind.text(std::string(f.key), p.test.*f.place, std::string(f.meaning));
  kind.texts(
      "instruments",
      Texts{&p.test.instruments,
            [](const std::string& text) {
              Instrument unused;
              return read_instrument(text, unused);
            }},
      "name, certificate and last day of each, such as [\"charge amplifier CA-7; K-2041; 2027-03-01\"]");
  kind.section("wanted", "of `powbench sim`: how accurate, or by which models");
  const char* times[] = {"touch_percent", "seat_percent", "settled_percent"};
  for (std::size_t i = 0; i < p.wanted.size(); ++i)
    kind.number(times[i], p.wanted[i], {1e-6, 50}, "largest error of this time, in percent of the touch time",
                Need::optional);
  kind.text("fields", p.fields,
            sim::names_of(sim::all_fields(), ", ") + ", or auto: climb as far as it takes");
  kind.text("mechanics", p.mechanics, sim::names_of(sim::all_mechanics(), ", ") + ", or auto");
  kind.text("channels", p.channels, "that are simulated, such as \"contact_a laser\"; left out: all");
  kind.section(
      "events",
      "how they are extracted; stored with the campaign, so that `powbench events` finds the same again");
  kind.text("filter", p.events.filter,
            "of the force: " + std::string(filter_forms) +
                "; a shot whose contacts it would eat is taken without it");
  kind.text("phase", p.events.phase, "of the filter: " + std::string(phase_forms) + "; left out: zero");
  kind.text("band", p.events.band, "where core vibration is looked for, such as 800Hz..18kHz, the default");
  return kind;
}

/// One of the names of a list, `auto`, or nothing.
template <class Kind>
void check_rung(FileReader& reader, const char* key, const std::string& word, std::span<const Kind> kinds) {
  if (word.empty() || word == "auto") return;
  std::string known = "auto";
  for (const Kind& kind : kinds) {
    if (kind.name == word) return;
    known += ", " + std::string(kind.name);
  }
  reader.fail("wanted", key, "is '" + word + "'", known);
}

/// Calls body(word) for each word between blanks and commas.
template <class Body>
void each_word(std::string_view text, const Body& body) {
  constexpr std::string_view between = " ,\t";
  for (std::size_t at = 0; (at = text.find_first_not_of(between, at)) != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(between, at), text.size());
    body(text.substr(at, end - at));
    at = end;
  }
}

const ChannelInfo* find_channel(std::string_view name) {
  for (const auto& c : channel_table)
    if (c.name == name) return &c;
  return nullptr;
}

void check_channels(FileReader& reader, const std::string& text) {
  std::string known;
  for (const auto& c : channel_table) known += (known.empty() ? "" : ", ") + std::string(c.name);
  each_word(text, [&](std::string_view word) {
    if (find_channel(word) == nullptr)
      reader.fail("wanted", "channels", "names '" + std::string(word) + "'", known);
  });
}

void check_angles(FileReader& reader, Plan& p) {
  for (double& angle : p.angles) angle = wrap_turn(angle);
  for (std::size_t i = 0; i < p.angles.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (to_centi_degrees(p.angles[i]) == to_centi_degrees(p.angles[j])) {
        reader.fail("", "angles_deg",
                    number_text(to_centi_degrees(p.angles[i]) / 100.0) +
                        " deg is listed twice (360 deg is 0 deg; steps of 0.01 deg); use repeats");
        return;
      }
}

void check(FileReader& reader, Plan& p) {
  if (reader.good("", "angles_deg")) check_angles(reader, p);
  const double shots = static_cast<double>(p.angles.size()) * p.repeats;
  if (reader.good("", "repeats") && shots > most_shots)
    reader.fail("", "repeats",
                "gives " + number_text(shots) + " shots with " + std::to_string(p.angles.size()) + " angles",
                "1..100000 shots");
  check_rung(reader, "fields", p.fields, sim::all_fields());
  check_rung(reader, "mechanics", p.mechanics, sim::all_mechanics());
  if (p.mechanics == "plant" && !p.fields.empty() && p.fields != "circuit")
    reader.fail("wanted", "mechanics", "knows no fields but the circuit's, not " + p.fields,
                "rigid, or fields = circuit");
  check_channels(reader, p.channels);
  dsp::ExtractOptions unused;
  if (const FilterMistake m = set_filter(unused, p.events); !m.key.empty())
    reader.fail("events", m.key, m.what, std::string(m.allowed));
  if (!p.test.recorded.empty() && !is_day(p.test.recorded))
    reader.fail("test", "recorded", "is no day", "a day as 2030-12-31");
  for (std::size_t i = 0; i < p.limits.size(); ++i) {
    if (!(p.limits[i].low > p.limits[i].high)) continue;
    const Quantity& q = quantity_table[i];
    reader.fail("limits." + std::string(q.symbol), "min_" + limit_suffix(q),
                "is above max_" + limit_suffix(q));
  }
}

Plan read_with(FileReader reader) {
  Plan p;
  reader.read(kind_of(p));
  check(reader, p);
  reader.finish();
  return p;
}

}  // namespace

Plan read_plan(const std::filesystem::path& path) {
  if (is_solenoid_file(path))
    throw BadInput(
        {path.string() + ": is a solenoid, which has no plan; `powbench sim` and `powbench field` take it"});
  Plan p = read_with(FileReader::open(path));
  p.folder = path.parent_path();
  return p;
}

Plan parse_plan(std::string text, std::string file) {
  return read_with(FileReader(std::move(file), std::move(text)));
}

std::string plan_template() {
  Plan p;
  for (int deg = 0; deg <= 180; deg += 30) p.angles.push_back(radians(deg));
  p.specimen = "reference.specimen.toml";
  return kind_of(p).template_text();
}

std::vector<KeyLine> keys_of(const Plan& plan) {
  Plan p = plan;
  return kind_of(p).lines();
}

std::string resolved_text(const Plan& plan) {
  Plan p = plan;
  return kind_of(p).resolved_text();
}

ChannelSet wanted_channels(const Plan& plan) {
  ChannelSet set = 0;
  each_word(plan.channels, [&](std::string_view word) {
    if (const auto* c = find_channel(word)) set |= 1U << static_cast<unsigned>(c - channel_table.data());
  });
  return set == 0 ? all_channels : set;
}

sim::Specimen load_specimen(const Plan& plan) {
  return plan.specimen.empty() ? sim::Specimen{} : read_specimen(plan.folder / plan.specimen);
}

}  // namespace powbench::host
