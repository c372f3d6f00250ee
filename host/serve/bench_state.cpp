#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/origin.h"
#include "core/version.h"
#include "host/serve/bench_impl.h"
#include "host/store/json.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t longest_log = 200;

/// A number of a rig's text; null for what is none.
Json number_in(const std::string& text, double factor) {
  try {
    return std::stod(text) * factor;
  } catch (const std::exception&) {
    return nullptr;
  }
}

/// Of a rig's "0" or "1"; null for what is none.
Json flag_in(const std::string& text) {
  return text == "0" || text == "1" ? Json(text == "1") : Json(nullptr);
}

Json status_json(const rigs::RigStatus& s) {
  const auto gap = s.phase_u.find(' ');
  const std::string now = s.phase_u.substr(0, gap),
                    ahead = gap == std::string::npos ? "" : s.phase_u.substr(gap + 1);
  return {{"state", s.state},
          {"live", s.live()},
          {"gate", flag_in(s.gate)},
          {"relay", flag_in(s.relay)},
          {"ready", rigs::advice(s.ready)},
          {"fault", s.fault},
          {"phase", s.phase},
          {"owner", s.owner},
          {"last_error", rigs::advice(s.last_error)},
          {"mains_hertz", number_in(s.hertz, 1)},
          {"phase_u_deg", number_in(now, 1e-3)},
          {"phase_u_ahead_deg", number_in(ahead, 1e-3)},
          {"phase_faults", s.phase_faults},
          {"angle_tolerance_deg", number_in(s.tolerance, 1e-3)}};
}

Json link_json(const Looker::Look& l) {
  return {{"answers", l.status.has_value()}, {"error", l.error},       {"answer_ms", l.answer_ms},
          {"median_ms", l.median_ms},        {"worst_ms", l.worst_ms}, {"looks", l.looks},
          {"connections", l.connections},    {"lost", l.lost}};
}

Json rig_json(const rigs::RigInfo& info, const std::string& uri, const Looker::Look& look) {
  Json channels = Json::array();
  for (const auto& c : info.channels) {
    Json counts;
    for (const auto& [channel, value] : look.now)
      if (powbench::info(channel).iio_id == c.id) counts = value;
    channels.push_back(
        {{"id", c.id}, {"label", c.label}, {"unit", c.unit}, {"per_count", c.scale}, {"counts", counts}});
  }
  return {{"uri", uri},
          {"model", info.model},
          {"serial", info.serial},
          {"firmware", info.firmware},
          {"boot_id", info.boot_id},
          {"origin", name(origin_of_kind(info.kind))},
          {"calibration", info.calibration},
          {"calibration_expires", info.calibration_expires},
          {"sample_rate_hz", info.sample_rate},
          {"programmable_source", info.programmable_source},
          {"channels", channels}};
}

}  // namespace

void Bench::Impl::log_line(const std::string& text) {
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  log.push_back(fmt::format("{:%H:%M:%S} {}", fmt::gmtime(std::chrono::system_clock::to_time_t(now)), text));
  if (log.size() > longest_log) log.pop_front();
}

void Bench::Impl::say(const std::string& text) {
  {
    const std::scoped_lock lock(mutex);
    log_line(text);
  }
  changed();
}

/// What the job does, for people; the lock is held.
std::string Bench::Impl::doing_words(const Job& j) const {
  if (waiting) return "paused";
  if (stop_flag)
    return j.stopped_late ? "all closings were already fired before STOP; " + j.doing : "stopping";
  if (j.pause_left > 0)
    return paused ? "cooling, then paused"
                  : fmt::format("cooling, next shot in {:.0f} s", std::ceil(j.pause_left));
  return paused ? "pausing after this shot" : j.doing;
}

/// From the time that firing took so far, and the plan's pauses between the shots to come.
std::optional<double> Bench::Impl::seconds_left(const Job& j) const {
  const auto total = j.shots.size();
  if (j.single || paused || j.done == total) return std::nullopt;
  const auto left = static_cast<double>(total - j.done);
  if (j.done == j.before) return estimated_seconds(j.scene.plan) * left / static_cast<double>(total);
  const double a_shot = (clock.now() - j.begun - j.pauses) / static_cast<double>(j.done - j.before);
  return left * std::max(0.0, a_shot) + (left - 1) * j.scene.plan.pause + j.pause_left;
}

std::string Bench::Impl::state() const {
  const Looker::Look look = looker->look();
  const std::scoped_lock lock(mutex);
  Json out = {{"version", program_version},
              {"rig", rig_json(look.info ? *look.info : info, uri, look)},
              {"link", link_json(look)},
              {"status", look.status ? status_json(*look.status) : Json(nullptr)},
              {"plan",
               {{"name", scene.plan.name},
                {"specimen", scene.specimen.name},
                {"supply_volts", scene.plan.supply_volts},
                {"mains_hertz", scene.plan.mains_hertz},
                {"hold_time_ms", 1e3 * scene.plan.hold_time},
                {"usual", {{"supply_volts", Plan{}.supply_volts}, {"hold_time_ms", 1e3 * Plan{}.hold_time}}},
                {"shots", scene.shots.size()}}},
              {"job", nullptr},
              {"aiming", aiming && *aiming > stopped_at.load()},
              {"ended", nullptr},
              {"newest_shot", newest_shot ? Json(newest_shot) : Json(nullptr)},
              {"newest_aim_deg", newest_aim ? Json(degrees(newest_aim->wanted)) : Json(nullptr)},
              {"newest_prediction", newest_prediction ? Json(newest_prediction) : Json(nullptr)},
              {"newest_campaign", newest_campaign ? Json(newest_campaign) : Json(nullptr)},
              {"interrupted", Json::array()},
              {"stop", nullptr},
              {"log", log}};
  if (job) {
    const auto total = job->shots.size();
    const auto left = seconds_left(*job);
    out["job"] = {{"kind", job->single ? "single" : "plan"},
                  {"name", job->scene.plan.name},
                  {"campaign", job->campaign ? Json(job->campaign) : Json(nullptr)},
                  {"doing", doing_words(*job)},
                  {"paused", paused},
                  {"ending", end_asked.load()},
                  {"done", job->done},
                  {"outside_limits", job->outside},
                  {"shots", total},
                  {"hold_time_ms", 1e3 * job->scene.plan.hold_time},
                  {"seconds_left", left ? Json(*left) : Json(nullptr)},
                  {"aim", nullptr}};
    if (job->aim)
      out["job"]["aim"] = {{"touch_deg", degrees(job->aim->wanted)},
                           {"closing_angle_deg", degrees(job->aim->closing_angle)},
                           {"touch_s", job->aim->touch_time},
                           {"gain", job->aim->gain}};
  }
  if (ended)
    out["ended"] = {{"name", ended->name},
                    {"campaign", ended->campaign},
                    {"done", ended->done},
                    {"shots", ended->shots},
                    {"why", ended->why}};
  for (const StoredShot& s : interrupted)
    out["interrupted"].push_back(
        {{"shot", s.id}, {"campaign", s.campaign}, {"angle_deg", json_of<Json>(s.angle_deg)}});
  if (last_stop) out["stop"] = {{"off", last_stop->off}, {"text", last_stop->text}, {"ms", last_stop->ms}};
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace powbench::host
