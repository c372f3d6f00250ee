#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/counted.h"
#include "core/quantities.h"
#include "core/units.h"
#include "core/version.h"
#include "host/cli/verbs.h"
#include "host/config/bad_input.h"
#include "host/export/contact_table.h"
#include "host/export/csv.h"
#include "host/export/event_table.h"
#include "host/export/waveforms.h"
#include "host/export/write_file.h"
#include "host/gather/shown.h"
#include "host/import/calibration.h"
#include "host/store/json.h"
#include "host/store/store.h"

/// powbench export: waveforms of a shot, events of a campaign.

namespace powbench::host {

namespace {

std::string origin_of(const CampaignInfo& campaign, const StoredShot& shot) {
  return std::string(shot.kind == ShotKind::measured ? name(campaign.origin) : "SIMULATION ONLY");
}

About about(const Store& store, const CampaignInfo& campaign, const StoredShot& shot, const Record& record) {
  About list{{"Conventions", "CF-1.8"},
             {"title", fmt::format("powbench {} shot {} of campaign {} ({})", name(shot.kind), shot.id,
                                   campaign.id, campaign.name)},
             {"source", fmt::format("{}: {}", origin_of(campaign, shot), record.rig)},
             {"started", shot.started},
             {"conditions", to_json(shot.conditions)},
             {"calibration", record.calibration},
             {"sample_hash", shot.record_hash},
             {"program", fmt::format("powbench {}", program_version)}};
  const Shown shown(store, shot);
  if (!shown.events) return list;
  list.emplace_back("events", to_json(*shown.events));
  list.emplace_back("quantities", shown.json<nlohmann::ordered_json>().dump());
  if (shown.simulated)
    list.emplace_back("uncertainty",
                      "u of quantities: what the inputs of the simulation leave open, null where "
                      "not known; u of events: how well the curve can be read");
  return list;
}

/// The format that was asked for: by its name, else by the extension of the file.
std::string format_of(const ExportArgs& args) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> formats{{{".csv", "csv"},
                                                                                  {".nc", "nc"},
                                                                                  {".cfg", "comtrade"},
                                                                                  {".dat", "comtrade"},
                                                                                  {".xlsx", "xlsx"},
                                                                                  {".arrow", "arrow"},
                                                                                  {".feather", "arrow"}}};
  const std::string extension = std::filesystem::path(args.file).extension().string();
  for (const auto& [end, format] : formats) {
    if (extension != end) continue;
    if (args.to.empty() || args.to == format) return std::string(format);
    throw BadInput(
        {fmt::format("export --to {} -o {}: a file of that name is {}; leave --to out, or name another file",
                     args.to, args.file, format)});
  }
  if (!args.to.empty()) return args.to;
  if (!args.file.empty() && !extension.empty())
    throw BadInput(
        {fmt::format("export -o {}: no format has files of that name; known: .csv, .nc, .cfg, .xlsx, .arrow, "
                     ".feather; another name needs --to",
                     args.file)});
  return "csv";
}

struct Numbers {
  std::vector<double> value, u;
};

/// One row a shot: what was asked, what came out; NaN where it is not known. `seen` gets the events behind it.
Table campaign_events(const Store& store, std::int64_t campaign,
                      std::vector<std::pair<std::int64_t, Events>>& seen) {
  std::vector<std::int64_t> id, number, repeat;
  std::vector<std::string> kind, outcome, reason, started;
  std::vector<double> asked;
  Numbers reached;
  std::vector<Numbers> quantities(quantity_table.size());
  for (const StoredShot& s : store.shots(campaign)) {
    id.push_back(s.id), number.push_back(s.number), repeat.push_back(s.repeat);
    kind.emplace_back(name(s.kind)), outcome.emplace_back(name(s.outcome));
    reason.push_back(s.reason), started.push_back(s.started);
    asked.push_back(s.angle_deg);
    const Shown shown(store, s);
    const auto& events = shown.events;
    const Measured angle = events ? events->coil.closing_angle : Measured{};
    reached.value.push_back(degrees(angle.value)), reached.u.push_back(degrees(angle.u));
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      const Measured m = shown.of(quantity_table[q]);
      quantities[q].value.push_back(m.value), quantities[q].u.push_back(m.u);
    }
    if (events) seen.emplace_back(s.id, *events);
  }
  Table t{{"shot", id}, {"kind", kind}, {"number", number}, {"repeat", repeat}, {"angle_deg", asked}};
  t.push_back({"reached_deg", reached.value}), t.push_back({"u_reached_deg", reached.u});
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    std::string unit(quantity_table[q].unit);
    if (unit == "m/s") unit = "m_per_s";
    const std::string label = fmt::format("{}_{}", quantity_table[q].symbol, unit);
    t.push_back({label, quantities[q].value}), t.push_back({"u_" + label, quantities[q].u});
  }
  t.push_back({"outcome", outcome}), t.push_back({"reason", reason}), t.push_back({"started", started});
  return t;
}

Sheet about_sheet(const About& list) {
  std::vector<std::string> keys, texts;
  for (const auto& [key, text] : list)
    if (key != "events") keys.push_back(key), texts.push_back(text);
  keys.emplace_back("u_..."),
      texts.emplace_back(
          "standard uncertainty of the column of that name, k = 1; of a simulated shot in the sheet events "
          "what its "
          "inputs leave open, empty where not known, in the sheet contacts how well its curve can be read");
  return {"about", {{"key", keys}, {"text", texts}}};
}

Exit export_campaign(const ExportArgs& args, const std::string& to) {
  if (to != "arrow" && to != "xlsx")
    throw BadInput(
        {"export --to " + to + ": name a shot; without one the events of a campaign go to arrow or xlsx"});
  const Store store(args.database, Store::Mode::read_only);
  const CampaignInfo campaign = store.campaign(args.campaign);
  std::vector<std::pair<std::int64_t, Events>> seen;
  const Table table = campaign_events(store, campaign.id, seen);
  const About list{{"campaign", fmt::format("{}, {}", campaign.id, campaign.name)},
                   {"origin", std::string(name(campaign.origin))},
                   {"created", campaign.created},
                   {"program", fmt::format("powbench {}", program_version)}};
  write_file(args.file,
             to == "arrow"
                 ? to_arrow(table, list)
                 : to_xlsx({{"events", table}, {"contacts", contact_table(seen)}, about_sheet(list)}));
  fmt::print(stderr, "{}: {} of campaign {}\n", args.file, counted(rows(table), "shot"), campaign.id);
  return Exit::pass;
}

/// CSV and its calibration file, which read back make the same record.
Exit export_csv(const ExportArgs& args, const CampaignInfo& campaign, const StoredShot& shot,
                const Record& record) {
  const std::string text = fmt::format("# {}, campaign {}, {} shot {}\n{}", origin_of(campaign, shot),
                                       campaign.id, name(shot.kind), shot.id, to_csv(record));
  if (args.file.empty()) {
    fmt::print("{}", text);
    return Exit::pass;
  }
  const auto beside = calibration_path(args.file);
  write_file(args.file, text);
  write_file(beside,
             calibration_of(record, fmt::format("{}, {} shot {} of campaign {}", origin_of(campaign, shot),
                                                name(shot.kind), shot.id, campaign.id)));
  fmt::print(stderr, "{} and {}: read back with powbench import\n", args.file, beside.string());
  return Exit::pass;
}

}  // namespace

Exit export_shot(const ExportArgs& args) {
  const std::string to = format_of(args);
  if (to == "vtu" || to == "gltf") {
    if (args.shot == 0) throw BadInput({"export --to " + to + ": name a shot, as `powbench shots` lists it"});
    return export_closing(args);
  }
  if (args.file.empty() && to != "csv")
    throw BadInput({"export --to " + to + ": name the file to write with -o"});
  if (args.shot == 0) return export_campaign(args, to);
  const Store store(args.database, Store::Mode::read_only);
  const Record record = store.load_record(args.shot);
  const StoredShot shot = store.shot(args.shot);
  const CampaignInfo campaign = store.campaign(shot.campaign);
  if (to == "csv") return export_csv(args, campaign, shot, record);
  if (to == "arrow")
    throw BadInput({"export --to arrow: writes the events of a campaign; leave the shot out"});
  About list = about(store, campaign, shot, record);
  std::filesystem::path file = args.file;
  if (to == "nc") {
    write_netcdf(record, list, args.file);
  } else if (to == "xlsx") {
    std::vector<Sheet> sheets{{"record", waveform_table(record)}};
    if (const auto events = store.load_events(args.shot))
      sheets.push_back({"contacts", contact_table({{args.shot, *events}})});
    for (const auto& delay : delays_of(record)) list.push_back(delay);
    sheets.push_back(about_sheet(list));
    write_file(file, to_xlsx(sheets));
  } else {
    const ComtradeText text = to_comtrade(record, list[1].second);
    write_file(file.replace_extension(".cfg"), text.configuration);
    write_file(file.replace_extension(".dat"), text.data);
    file.replace_extension(".cfg");
  }
  fmt::print(stderr, "{}: {} samples of {} channels\n", file.string(), record.samples(),
             record.channels.size());
  return Exit::pass;
}

}  // namespace powbench::host
