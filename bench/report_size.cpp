#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/cpu_time.h"
#include "core/random.h"
#include "host/gather/gather.h"
#include "host/plan/expand.h"
#include "host/run/campaign.h"
#include "rigs/simulated_record.h"

/// What a report costs: CPU time to read the store and to write the page, size of the page. Small campaigns with
/// whole records, long ones with short records (only the drawn shots' records are read).
/// Usage: bench_report_size [--json PATH]

namespace {

using namespace powbench;
using namespace powbench::host;

constexpr int angles = 36;

Plan plan_of(int shots) {
  Plan plan;
  const int count = std::min(angles, shots / 3);
  for (int i = 0; i < count; ++i) plan.angles.push_back(radians(360.0 / count * i));
  plan.repeats = (shots + count - 1) / count;
  return plan;
}

/// A store with that many measured shots, and one simulated at each angle.
void fill(const std::string& path, const Plan& plan, bool whole) {
  Store store(path);
  CampaignInfo info;
  info.name = "size";
  info.plan = resolved_text(plan);
  info.specimen = resolved_text(sim::Specimen{});
  info.rig_identity = "simulated";
  info.origin = Origin::simulated_rig;
  const std::int64_t campaign = store.create_campaign(info);
  RunOptions options;
  rigs::SimRigConfig rig;
  if (!whole) rig.record_length = 0.062;
  Random random(1);
  std::vector<std::pair<Record, Events>> made;
  for (const double angle : plan.angles) {
    Conditions c;
    c.closing_angle = angle;
    const Record record = rigs::simulate_record({}, c, rig).record;
    made.emplace_back(record, extract_checked(record, options));
  }
  for (int i = 0; i < plan.repeats * static_cast<int>(made.size()); ++i) {
    const auto& [record, events] = made[static_cast<std::size_t>(i) % made.size()];
    StoredShot shot;
    shot.campaign = campaign;
    shot.number = i;
    shot.conditions = record.conditions;
    shot.angle_deg = degrees(record.conditions.closing_angle);
    shot.outcome = Outcome::not_judged;
    shot.started = "2026-01-01T00:00:00Z";
    Events moved = events;
    moved.contact_voltage.bounce_time.value += 20e-6 * random.normal();
    const bool read = whole || i < 2 * static_cast<int>(made.size());
    Record stub = record;
    if (!read)
      for (ChannelRecord& channel : stub.channels) channel.raw.resize(64);
    store.store_shot(shot, &stub, &moved, {"p", "0"});
    if (i >= static_cast<int>(made.size())) continue;
    shot.kind = ShotKind::simulated;
    store.store_shot(shot, &record, &events, {"p", "0"});
  }
}

struct Row {
  int shots;
  double gather, render, html, junit;
};

Row measure(int shots, bool whole, const std::string& path) {
  const Plan plan = plan_of(shots);
  fill(path, plan, whole);
  const Store store(path, Store::Mode::read_only);
  const double begin = process_cpu_seconds();
  const ReportInput input = gather_report(store, store.campaign(), path);
  const double gathered = process_cpu_seconds();
  const std::string html = render_html(input), junit = render_junit(input);
  return {static_cast<int>(input.shots.size()), gathered - begin, process_cpu_seconds() - gathered,
          static_cast<double>(html.size()) * 1e-6, static_cast<double>(junit.size()) * 1e-6};
}

}  // namespace

int main(int argc, char** argv) {
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("powbench-report-size-{}", getpid());
  std::filesystem::create_directory(folder);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  fmt::print("{:>7} {:>10} {:>11} {:>8} {:>9}\n", "shots", "read, s", "written, s", "page, MB", "JUnit, MB");
  for (const auto& [shots, whole] :
       {std::pair{6, true}, {60, true}, {180, true}, {2'000, false}, {20'000, false}}) {
    const Row r = measure(shots, whole, (folder / fmt::format("{}.db", shots)).string());
    fmt::print("{:>7} {:>10.2f} {:>11.2f} {:>8.2f} {:>9.2f}\n", r.shots, r.gather, r.render, r.html, r.junit);
    list.push_back({{"shots", r.shots},
                    {"read_s", r.gather},
                    {"written_s", r.render},
                    {"page_MB", r.html},
                    {"junit_MB", r.junit}});
  }
  fmt::print(
      "CPU time. At most 60 measured closings are drawn and 400 shots listed, whatever the campaign. Wanted: "
      "60 shots in 2 s and\n"
      "6 MB; 20 000 shots in 30 s and 10 MB.\n");
  std::filesystem::remove_all(folder);
  if (argc > 2 && std::string(argv[1]) == "--json") std::ofstream(argv[2]) << list.dump(2) << "\n";
}
