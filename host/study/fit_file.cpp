#include "host/study/fit_file.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "host/config/bad_input.h"
#include "host/config/specimen_file.h"
#include "sim/study/parameter.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

/// What is not known is null: what a NaN is written as.
double number_from(const Json& j, const char* key, double least) {
  if (j.at(key).is_null()) return sim::BounceCalibration::nan;
  const double value = j.at(key).get<double>();
  if (!(value >= least))
    throw std::invalid_argument(std::string(key) + " of a bounce is below what is possible");
  return value;
}

Json json_of(const sim::BounceCalibration& c) {
  Json j = {{"factors", c.factors},
            {"deviation", c.deviation},
            {"median_s", c.median},
            {"median_deviation", c.median_deviation}};
  if (c.line.empty()) return j;
  for (const auto& a : c.line) j["line"].push_back({{"angle_rad", a.angle}, {"bounce_s", a.bounce}});
  j["line_deviation"] = c.line_deviation;
  return j;
}

sim::BounceCalibration calibration_of(const Json& j) {
  constexpr double shortest = 1e-6;  // s; a logarithm is taken
  sim::BounceCalibration c{j.at("factors").get<std::vector<double>>(), number_from(j, "deviation", 0),
                           number_from(j, "median_s", shortest), number_from(j, "median_deviation", 0)};
  for (const double f : c.factors)
    if (!(f > 0)) throw std::invalid_argument("a bounce factor is not above 0");
  if (!j.contains("line")) return c;
  for (const Json& a : j.at("line")) {
    c.line.push_back({number_from(a, "angle_rad", 0), number_from(a, "bounce_s", shortest)});
    if (!std::isfinite(c.line.back().angle) || !std::isfinite(c.line.back().bounce))
      throw std::invalid_argument("a bounce of the line is not known");
  }
  if (c.line.size() < 2) throw std::invalid_argument("the line of bounces has fewer than two angles");
  c.line_deviation = number_from(j, "line_deviation", 0);
  return c;
}

Json json_of(const FitFold& f) {
  Json j;
  j["held_out_deg"] = f.held_out ? Json(*f.held_out) : Json(nullptr);
  j["misfit"] = rounded(f.misfit);
  j["members"] = f.members;
  if (f.bounce) j["bounce"] = json_of(*f.bounce);
  return j;
}

FitFold fold_of(const Json& j) {
  FitFold f;
  if (!j.at("held_out_deg").is_null()) f.held_out = j.at("held_out_deg").get<double>();
  f.misfit = j.at("misfit").get<double>();
  f.members = j.at("members").get<std::vector<std::vector<double>>>();
  if (j.contains("bounce")) f.bounce = calibration_of(j.at("bounce"));
  if (f.bounce && f.bounce->factors.size() != f.members.size())
    throw std::invalid_argument("a fold has another number of bounce factors than of members");
  return f;
}

Json json_of(const sim::Evolution::State& s) {
  Json j;
  j["generation"] = s.generation;
  j["used"] = s.used;
  j["memory_scale"] = s.memory_scale;
  j["memory_crossing"] = s.memory_crossing;
  j["memory_next"] = s.memory_next;
  j["archive"] = s.archive;
  j["population"] = Json::array();
  for (const auto& c : s.population) j["population"].push_back({{"value", c.value}, {"point", c.point}});
  return j;
}

sim::Evolution::State evolution_of(const Json& j) {
  sim::Evolution::State s;
  s.generation = j.at("generation").get<std::uint64_t>();
  s.used = j.at("used").get<long>();
  s.memory_scale = j.at("memory_scale").get<std::vector<double>>();
  s.memory_crossing = j.at("memory_crossing").get<std::vector<double>>();
  s.memory_next = j.at("memory_next").get<std::size_t>();
  s.archive = j.at("archive").get<std::vector<std::vector<double>>>();
  for (const auto& c : j.at("population"))
    s.population.push_back({c.at("point").get<std::vector<double>>(), c.at("value").get<double>()});
  return s;
}

/// A line for each member: short enough to be read, and compared, by eye.
std::string by_member(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    out += text[i];
    const bool between = text[i] == ',' && i > 0 && (text[i - 1] == ']' || text[i - 1] == '}');
    if (between) out += '\n';
  }
  return out;
}

/// Reads with `read`; whatever is wrong becomes one sentence.
template <class Read>
auto read_json(const std::string& text, const std::string& file, const char* kind, Read read) {
  try {
    const Json j = Json::parse(text);
    if (j.at("kind").get<std::string>() != kind) throw std::invalid_argument("another kind of file");
    return read(j);
  } catch (const std::exception& e) {
    throw BadInput({file + ": not a " + kind + " file of powbench: " + e.what()});
  }
}

}  // namespace

double rounded(double value) {
  if (value == 0 || !std::isfinite(value)) return value;
  const double scale = std::pow(10.0, 7 - std::floor(std::log10(std::fabs(value))));
  return std::round(value * scale) / scale;
}

sim::BounceCalibration rounded(sim::BounceCalibration c) {
  for (double& f : c.factors) f = rounded(f);
  for (auto& a : c.line) a = {rounded(a.angle), rounded(a.bounce)};
  for (double* d : {&c.deviation, &c.median, &c.median_deviation, &c.line_deviation}) *d = rounded(*d);
  return c;
}

std::vector<sim::Specimen> specimens(const FitFile& file, const FitFold& fold) {
  const sim::Specimen base = parse_specimen(file.base, "base of the fit");
  std::vector<sim::Specimen> list;
  for (const auto& values : fold.members) {
    sim::Specimen s = base;
    for (std::size_t i = 0; i < file.names.size() && i < values.size(); ++i) {
      const auto& field = sim::specimen_field(file.names[i]);
      field.set(s, values[i] * field.si_per_unit);
    }
    list.push_back(std::move(s));
  }
  return list;
}

std::string to_json(const FitFile& f) {
  Json j;
  j["kind"] = "fit";
  j["base"] = f.base;
  j["names"] = f.names;
  j["folds"] = Json::array();
  for (const auto& fold : f.folds) j["folds"].push_back(json_of(fold));
  return by_member(j.dump()) + "\n";
}

FitFile parse_fit_file(const std::string& text, const std::string& file) {
  return read_json(text, file, "fit", [](const Json& j) {
    FitFile f;
    f.base = j.at("base").get<std::string>();
    f.names = j.at("names").get<std::vector<std::string>>();
    for (const auto& name : f.names) sim::specimen_field(name);
    for (const auto& fold : j.at("folds")) f.folds.push_back(fold_of(fold));
    for (const auto& fold : f.folds)
      for (const auto& values : fold.members)
        if (values.size() != f.names.size())
          throw std::invalid_argument("a member has too few or too many numbers");
    return f;
  });
}

FitFile load_fit_file(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw BadInput({file + ": cannot be read"});
  return parse_fit_file({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()}, file);
}

std::string to_json(const FitState& s) {
  Json j;
  j["kind"] = "fit-state";
  j["problem"] = s.problem;
  j["done"] = Json::array();
  for (const auto& fold : s.done) j["done"].push_back(json_of(fold));
  j["running"] = s.running ? json_of(*s.running) : Json(nullptr);
  return j.dump() + "\n";
}

FitState parse_fit_state(const std::string& text, const std::string& file) {
  return read_json(text, file, "fit-state", [](const Json& j) {
    FitState s;
    s.problem = j.at("problem").get<std::string>();
    for (const auto& fold : j.at("done")) s.done.push_back(fold_of(fold));
    if (!j.at("running").is_null()) s.running = evolution_of(j.at("running"));
    return s;
  });
}

}  // namespace powbench::host
