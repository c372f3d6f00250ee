#include "host/store/json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

namespace powbench::host {

namespace {

using nlohmann::json;
using Ordered = nlohmann::ordered_json;

constexpr std::array<std::pair<std::uint32_t, const char*>, 16> flag_table{
    {{flag_clipped, "clipped"},
     {flag_gap, "gap"},
     {flag_edge, "edge"},
     {flag_poor_fit, "poor_fit"},
     {flag_no_hum_fit, "no_hum_fit"},
     {flag_polarity, "polarity"},
     {flag_contradiction, "contradiction"},
     {flag_ring_overlap, "ring_overlap"},
     {flag_no_calibration, "no_calibration"},
     {flag_angle_off, "angle_off"},
     {flag_gain, "gain"},
     {flag_grazing, "grazing"},
     {flag_resolution, "resolution"},
     {flag_switch_on, "switch_on"},
     {flag_chatter, "chatter"},
     {flag_beyond_fields, "beyond_fields"}}};

Ordered flags_json(std::uint32_t flags) {
  Ordered list = Ordered::array();
  for (const auto& [bit, text] : flag_table)
    if ((flags & bit) != 0) list.push_back(text);
  return list;
}

std::uint32_t flags_from(const json& list) {
  std::uint32_t flags = 0;
  for (const json& item : list)
    for (const auto& [bit, text] : flag_table)
      if (item.get<std::string>() == text) flags |= bit;
  return flags;
}

double number_from(const json& j) {
  return j.is_null() ? std::nan("") : j.get<double>();
}

Measured measured_from(const json& j) {
  return {number_from(j.at("value")), number_from(j.at("u"))};
}

Ordered part_json(const BounceTrain& b) {
  return {{"openings", b.openings}, {"from_s", json_of<Ordered>(b.from)}, {"to_s", json_of<Ordered>(b.to)}};
}
BounceTrain part_from(const json& j) {
  return {.openings = j.at("openings").get<int>(),
          .from = measured_from(j.at("from_s")),
          .to = measured_from(j.at("to_s"))};
}

Ordered train_json(const ContactTrain& t) {
  Ordered contacts = Ordered::array();
  for (const Contact& c : t.contacts)
    contacts.push_back({{"touch_s", json_of<Ordered>(c.touch)},
                        {"release_s", json_of<Ordered>(c.release)},
                        {"peak", json_of<Ordered>(c.peak)},
                        {"impulse", json_of<Ordered>(c.impulse)},
                        {"flags", flags_json(c.flags)},
                        {"probability", json_of<Ordered>(c.probability)}});
  return {{"present", t.present},
          {"shows", name(t.shows)},
          {"reason", t.reason},
          {"contacts", contacts},
          {"settled_s", json_of<Ordered>(t.settled)},
          {"settled_force", json_of<Ordered>(t.settled_force)},
          {"bounce_time_s", json_of<Ordered>(t.bounce_time)},
          {"bounce_count", t.bounce_count},
          {"first_train", part_json(t.first_train)},
          {"second_train", part_json(t.second_train)},
          {"resolution_s", json_of<Ordered>(t.resolution)},
          {"noise", json_of<Ordered>(t.noise)},
          {"flags", flags_json(t.flags)}};
}

ContactTrain train_from(const json& j) {
  ContactTrain t;
  t.present = j.at("present").get<bool>();
  if (j.contains("shows")) {  // older texts have none
    const auto shows = std::ranges::find(shows_names, j["shows"].get<std::string>());
    if (shows == shows_names.end())
      throw std::invalid_argument("shows: '" + j["shows"].get<std::string>() + "' is unknown");
    t.shows = static_cast<Shows>(shows - shows_names.begin());
    t.reason = j.value("reason", "");
  }
  for (const json& c : j.at("contacts"))
    t.contacts.push_back(
        {.touch = measured_from(c.at("touch_s")),
         .release = measured_from(c.at("release_s")),
         .peak = measured_from(c.at("peak")),
         .impulse = measured_from(c.at("impulse")),
         .flags = flags_from(c.at("flags")),
         .probability = c.contains("probability") ? number_from(c["probability"]) : 1.0});  // older: none
  t.settled = measured_from(j.at("settled_s"));
  t.settled_force = measured_from(j.at("settled_force"));
  t.bounce_time = measured_from(j.at("bounce_time_s"));
  t.bounce_count = j.at("bounce_count").get<int>();
  if (j.contains("first_train")) t.first_train = part_from(j["first_train"]);  // older texts have none
  if (j.contains("second_train")) t.second_train = part_from(j["second_train"]);
  t.resolution = number_from(j.at("resolution_s"));
  t.noise = number_from(j.at("noise"));
  t.flags = flags_from(j.at("flags"));
  return t;
}

Ordered pole_json(const PoleEvents& p) {
  return {{"by_force", train_json(p.by_force)},
          {"disagreement_s", json_of<Ordered>(p.disagreement)},
          {"longest_disagreement_s", json_of<Ordered>(p.longest_disagreement)}};
}

PoleEvents pole_from(const json& j) {
  return {.by_force = train_from(j.at("by_force")),
          .disagreement = measured_from(j.at("disagreement_s")),
          .longest_disagreement = measured_from(j.at("longest_disagreement_s"))};
}

Ordered core_json(const CoreEvents& c) {
  return {{"present", c.present},
          {"seat_s", json_of<Ordered>(c.seat)},
          {"settled_s", json_of<Ordered>(c.settled)},
          {"bounce_time_s", json_of<Ordered>(c.bounce_time)},
          {"impact_velocity", json_of<Ordered>(c.impact_velocity)},
          {"travel_m", json_of<Ordered>(c.travel)},
          {"flags", flags_json(c.flags)}};
}

CoreEvents core_from(const json& j) {
  return {.present = j.at("present").get<bool>(),
          .seat = measured_from(j.at("seat_s")),
          .settled = measured_from(j.at("settled_s")),
          .bounce_time = measured_from(j.at("bounce_time_s")),
          .impact_velocity = measured_from(j.at("impact_velocity")),
          .travel = measured_from(j.at("travel_m")),
          .flags = flags_from(j.at("flags"))};
}

Ordered coil_json(const CoilEvents& c) {
  return {{"closing_angle_rad", json_of<Ordered>(c.closing_angle)},
          {"no_angle", c.no_angle},
          {"switch_on_s", json_of<Ordered>(c.switch_on)},
          {"mains_hertz", json_of<Ordered>(c.mains_hertz)},
          {"supply_volts", json_of<Ordered>(c.supply_volts)},
          {"peak_current", json_of<Ordered>(c.peak_current)},
          {"flags", flags_json(c.flags)}};
}

CoilEvents coil_from(const json& j) {
  return {.closing_angle = measured_from(j.at("closing_angle_rad")),
          .no_angle = j.value("no_angle", ""),
          .switch_on = measured_from(j.at("switch_on_s")),
          .mains_hertz = measured_from(j.at("mains_hertz")),
          .supply_volts = measured_from(j.at("supply_volts")),
          .peak_current = measured_from(j.at("peak_current")),
          .flags = flags_from(j.at("flags"))};
}

template <class F>
auto parsed(std::string_view text, F&& build) {
  try {
    return build(json::parse(text));
  } catch (const json::exception& e) {
    throw std::invalid_argument(std::string("stored text is not what it should be: ") + e.what());
  }
}

}  // namespace

std::string flag_names(std::uint32_t flags) {
  std::string text;
  for (const auto& [bit, name] : flag_table)
    if ((flags & bit) != 0) text += (text.empty() ? "" : ", ") + std::string(name);
  return text;
}

std::string to_json(const Events& e, int indent) {
  const Ordered j = {{"pvdf_a", train_json(e.pvdf_a)},
                     {"pvdf_b", train_json(e.pvdf_b)},
                     {"contact_voltage", train_json(e.contact_voltage)},
                     {"pole", pole_json(e.pole)},
                     {"core", core_json(e.core)},
                     {"coil", coil_json(e.coil)},
                     {"method", e.method},
                     {"parameters_hash", e.parameters_hash},
                     {"flags", flags_json(e.flags)}};
  return j.dump(indent);
}

std::string to_json(const Conditions& c, int indent) {
  const Ordered j = {{"supply_volts", json_of<Ordered>(c.supply_volts)},
                     {"mains_hertz", json_of<Ordered>(c.mains_hertz)},
                     {"closing_angle", json_of<Ordered>(c.closing_angle)},
                     {"polarity", c.polarity},
                     {"hold_time", json_of<Ordered>(c.hold_time)},
                     {"ambient", json_of<Ordered>(c.ambient)},
                     {"specimen", c.specimen},
                     {"seed", c.seed}};
  return j.dump(indent);
}

namespace {

/// A band is drawn of it: more would be noise in the file.
double four_digits(double v) {
  if (!std::isfinite(v) || v == 0) return v;
  const double scale = std::pow(10.0, 3 - std::floor(std::log10(std::fabs(v))));
  return std::round(v * scale) / scale;
}

}  // namespace

std::string to_json(const InputSpread& p) {
  Ordered j = Ordered::object();
  for (const auto& [symbol, u] : p.u) j[symbol] = json_of<Ordered>(u);
  for (const CurveSpread& c : p.curves) {
    Ordered values = Ordered::array();
    for (const double u : c.u) values.push_back(json_of<Ordered>(four_digits(u)));
    j["curves"][c.channel] = {{"t0", c.t0}, {"dt", c.dt}, {"u", std::move(values)}};
  }
  for (const auto& [number, quantities] : p.moved)
    for (const auto& [symbol, by] : quantities)
      j["moved"][std::to_string(number)][symbol] = json_of<Ordered>(four_digits(by));
  return j.dump();
}

InputSpread spread_from_json(std::string_view text) {
  return parsed(text, [](const json& j) {
    InputSpread p;
    for (const auto& [key, value] : j.items()) {
      if (key == "moved") {
        for (const auto& [number, quantities] : value.items())
          for (const auto& [symbol, by] : quantities.items())
            p.moved[std::stoi(number)][symbol] = number_from(by);
        continue;
      }
      if (key != "curves") {
        p.u[key] = number_from(value);
        continue;
      }
      for (const auto& [channel, curve] : value.items()) {
        CurveSpread c{channel, curve.at("t0").get<double>(), curve.at("dt").get<double>(), {}};
        for (const auto& u : curve.at("u")) c.u.push_back(static_cast<float>(number_from(u)));
        p.curves.push_back(std::move(c));
      }
    }
    return p;
  });
}

Events events_from_json(std::string_view text) {
  return parsed(text, [](const json& j) {
    Events e;
    e.pvdf_a = train_from(j.at("pvdf_a"));
    e.pvdf_b = train_from(j.at("pvdf_b"));
    e.contact_voltage = train_from(j.at("contact_voltage"));
    if (j.contains("pole")) e.pole = pole_from(j["pole"]);  // older texts have none
    e.core = core_from(j.at("core"));
    e.coil = coil_from(j.at("coil"));
    e.method = j.at("method").get<std::string>();
    e.parameters_hash = j.at("parameters_hash").get<std::string>();
    e.flags = flags_from(j.at("flags"));
    return e;
  });
}

Conditions conditions_from_json(std::string_view text) {
  return parsed(text, [](const json& j) {
    Conditions c;
    c.supply_volts = number_from(j.at("supply_volts"));
    c.mains_hertz = number_from(j.at("mains_hertz"));
    c.closing_angle = number_from(j.at("closing_angle"));
    c.polarity = j.at("polarity").get<int>();
    c.hold_time = number_from(j.at("hold_time"));
    c.ambient = number_from(j.at("ambient"));
    c.specimen = j.at("specimen").get<std::string>();
    c.seed = j.at("seed").get<std::uint64_t>();
    return c;
  });
}

}  // namespace powbench::host
