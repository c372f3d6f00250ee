#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "core/counted.h"
#include "host/cli/commands.h"
#include "host/config/bad_input.h"
#include "host/config/test_record.h"
#include "host/gather/gather.h"
#include "host/run/progress.h"
#include "host/store/central/central.h"
#include "host/store/maintain.h"
#include "host/store/store.h"

/// Whole stores: powbench db check, migrate, merge, split, push, pull.

namespace powbench::host {

namespace {

using Json = nlohmann::ordered_json;

struct DbArgs {
  std::string database = "powbench.db";
  bool json = false;
  std::string progress = "auto";
  bool compact = false;                       ///< migrate
  std::string output;                         ///< merge: store; split: folder
  std::vector<std::string> sources;           ///< merge
  std::int64_t campaign = 0;                  ///< split; 0: all
  std::string address;                        ///< push, pull: of the database
  std::string customer, device, name, since;  ///< pull: only these campaigns; "" = any
};

Progress::Style style(const std::string& word) {
  return word == "bar"     ? Progress::Style::bar
         : word == "lines" ? Progress::Style::lines
         : word == "none"  ? Progress::Style::none
                           : Progress::Style::automatic;
}

/// A step that shows itself only in stores large enough to take a while.
class Steps {
 public:
  Steps(std::string what, const std::string& progress) : what_(std::move(what)), style_(style(progress)) {}
  Step step() {
    return [this](std::int64_t done, std::int64_t all) {
      if (!shown_ && all >= 1000)
        shown_ = std::make_unique<Progress>(what_, static_cast<std::size_t>(all), style_);
      if (shown_) shown_->update(static_cast<std::size_t>(done));
    };
  }

 private:
  std::string what_;
  Progress::Style style_;
  std::unique_ptr<Progress> shown_;
};

/// A step that shows itself, with the time to go, once two seconds have passed.
class LateSteps {
 public:
  LateSteps(std::string what, const std::string& progress)
      : what_(std::move(what)), style_(style(progress)) {}
  Step step() {
    return [this](std::int64_t done, std::int64_t all) {
      const auto at = static_cast<std::size_t>(done);
      if (!shown_ && std::chrono::steady_clock::now() - start_ > std::chrono::seconds(2))
        shown_ = std::make_unique<Progress>(what_, static_cast<std::size_t>(all), style_, at);
      if (shown_) shown_->update(at);
    };
  }

 private:
  std::string what_;
  Progress::Style style_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::unique_ptr<Progress> shown_;
};

double megabytes(const std::string& file) {
  std::error_code ignored;
  const auto size = std::filesystem::file_size(file, ignored);
  return ignored ? 0.0 : static_cast<double>(size) / 1e6;
}

Exit check(const DbArgs& args) {
  Steps steps("check", args.progress);
  const StoreContent c = check_store(args.database, steps.step());
  if (args.json) {
    fmt::print("{}\n", Json{{"campaigns", c.campaigns},
                            {"shots", c.shots},
                            {"records", c.records},
                            {"events", c.events},
                            {"sweeps", c.sweeps},
                            {"points", c.points},
                            {"bare_records", c.bare},
                            {"undigested", c.undigested},
                            {"hash", c.hash},
                            {"damage", c.damage}}
                           .dump(2));
  } else {
    fmt::print("{}: {}, {}, {}, {}, {}, {}, {:.1f} MB\n", args.database, counted(c.campaigns, "campaign"),
               counted(c.shots, "shot"), counted(c.records, "record"), counted(c.events, "extraction"),
               counted(c.sweeps, "sweep"), counted(c.points, "point"), megabytes(args.database));
    for (const std::string& d : c.damage) fmt::print("damaged: {}\n", d);
    if (c.damage.empty()) fmt::print("whole; content {}\n", c.hash);
    if (c.bare + c.undigested > 0)
      fmt::print(
          "{} records are not packed, {} shots have no short row for lists: powbench db migrate --db {}\n",
          c.bare, c.undigested, args.database);
  }
  return c.damage.empty() ? Exit::pass : Exit::data_damaged;
}

Exit migrate(const DbArgs& args) {
  const double before = megabytes(args.database);
  if (before == 0.0)
    throw WrongStore(args.database + ": no such store; check its name, or make it by run, sim or import");
  Steps steps("migrate", args.progress);
  const Migrated m = migrate_store(args.database, args.compact, steps.step());
  if (args.json)
    fmt::print(
        "{}\n",
        Json{{"packed", m.packed}, {"digested", m.digested}, {"schema", Store::schema_version}}.dump(2));
  else
    fmt::print(
        "{}: schema {}, {} records packed, {} short rows for lists written; {:.1f} MB, before {:.1f} MB{}\n",
        args.database, Store::schema_version, m.packed, m.digested, megabytes(args.database), before,
        args.compact || m.packed == 0 ? "" : "; --compact gives the freed pages back");
  return Exit::pass;
}

Exit merge(const DbArgs& args) {
  const Merged m = merge_stores(args.output, args.sources);
  if (args.json)
    fmt::print("{}\n", Json{{"campaigns", m.campaigns},
                            {"shots", m.shots},
                            {"events", m.events},
                            {"sweep_blocks", m.sweep_blocks},
                            {"points", m.points}}
                           .dump(2));
  else
    fmt::print("{}: {}, {}, {}, {} of sweeps, {} added\n", args.output, counted(m.campaigns, "campaign"),
               counted(m.shots, "shot"), counted(m.events, "extraction"), counted(m.sweep_blocks, "block"),
               counted(m.points, "point"));
  return Exit::pass;
}

Exit split(const DbArgs& args) {
  for (const std::string& file : split_store(args.database, args.output, args.campaign))
    fmt::print("{}\n", file);
  return Exit::pass;
}

/// What is refused by the server or lost on the way to it is said here; everything else as by the other verbs.
template <class F>
Exit with_server(F&& act) {
  try {
    act();
    return Exit::pass;
  } catch (const ServerError& e) {
    fmt::print(stderr, "powbench: {}\n", e.what());
    return Exit::rig_fault;
  }
}

Exit push(const DbArgs& args) {
  return with_server([&] {
    LateSteps steps("push", args.progress);
    const Pushed p = push_store(args.database, args.address, steps.step());
    if (args.json)
      fmt::print("{}\n", Json{{"campaigns", p.campaigns},
                              {"shots", p.shots},
                              {"events", p.events},
                              {"annotations", p.annotations},
                              {"sweep_blocks", p.sweep_blocks},
                              {"points", p.points},
                              {"bytes", p.bytes}}
                             .dump(2));
    else
      fmt::print("{}: {}, {}, {}, {}, {} of sweeps, {} added, {:.1f} MB\n", args.address,
                 counted(p.campaigns, "campaign"), counted(p.shots, "shot"), counted(p.events, "extraction"),
                 counted(p.annotations, "annotation"), counted(p.sweep_blocks, "block"),
                 counted(p.points, "point"), static_cast<double>(p.bytes) / 1e6);
  });
}

/// What a campaign of the database must be to be fetched, and what there would have been.
struct Wanted {
  explicit Wanted(const DbArgs& a) : args(a) {}
  bool operator()(const CampaignInfo& c, const std::vector<Annotation>& annotations) {
    TestRecord record;
    try {
      record = stored_plan(c).test;
    } catch (const StoreError&) {  // a plan of another version of the program: its annotations count
    }
    for (const Annotation& a : annotations)
      if (a.key != course_key) complete(record, a.key, a.text);
    customers.insert(record.customer), devices.insert(record.device), names.insert(c.name);
    const auto is = [](const std::string& wanted, const std::string& found) {
      return wanted.empty() || wanted == found;
    };
    if (!is(args.customer, record.customer) || !is(args.device, record.device) || !is(args.name, c.name))
      return false;
    newest = std::max(newest, c.created);
    return c.created >= args.since;
  }
  /// Why none was wanted, and what might have been meant.
  std::string why_none() const {
    if (customers.empty()) return "the database has no campaign yet";
    if (!newest.empty())
      return fmt::format("no {}campaign was begun on {} or later; the newest {}was begun on {} (UTC)",
                         words() ? "such " : "", args.since, words() ? "such one " : "",
                         newest.substr(0, 10));
    const auto list = [](const std::set<std::string>& words) {
      std::string text;
      for (const std::string& w : words)
        if (!w.empty()) text += (text.empty() ? "'" : ", '") + w + "'";
      return text.empty() ? std::string("none") : text;
    };
    return "no such campaign; customers there: " + list(customers) + "; devices: " + list(devices) +
           "; names: " + list(names);
  }

  bool words() const { return !(args.customer + args.device + args.name).empty(); }

  const DbArgs& args;
  std::set<std::string> customers, devices, names;
  std::string newest;  ///< when the newest of these words was begun
};

Exit pull(const DbArgs& args) {
  return with_server([&] {
    if (!args.since.empty() && !is_day(args.since))
      throw BadInput({fmt::format(
          "--since '{}': not a day; allowed is year-month-day in digits, such as 2030-12-31", args.since)});
    LateSteps steps("pull", args.progress);
    Wanted wanted(args);
    CampaignChoice choice;
    if (!(args.customer + args.device + args.name + args.since).empty()) choice = std::ref(wanted);
    const Merged m = pull_store(
        args.address, args.database, choice, [&] { return wanted.why_none(); }, steps.step());
    if (args.json)
      fmt::print("{}\n", Json{{"campaigns", m.campaigns},
                              {"shots", m.shots},
                              {"events", m.events},
                              {"sweep_blocks", m.sweep_blocks},
                              {"points", m.points}}
                             .dump(2));
    else
      fmt::print("{}: {}, {}, {}, {} of sweeps, {} added\n", args.database, counted(m.campaigns, "campaign"),
                 counted(m.shots, "shot"), counted(m.events, "extraction"), counted(m.sweep_blocks, "block"),
                 counted(m.points, "point"));
  });
}

void add_common(CLI::App* app, DbArgs& args) {
  app->add_option("--db", args.database, "store")->capture_default_str();
  app->add_flag("--json", args.json, "JSON to stdout");
  app->add_option("--progress", args.progress, "auto, bar, lines or none")
      ->check(CLI::IsMember({"auto", "bar", "lines", "none"}))
      ->capture_default_str();
}

}  // namespace

void add_db_verbs(CLI::App& app) {
  CLI::App* db =
      app.add_subcommand("db", "Check, migrate, merge and split stores; exchange with a central database");
  db->require_subcommand(1);
  auto checked = std::make_shared<DbArgs>();
  add_common(verb(*db, "check", "Verify structure, seals and samples of a store and list any damage", checked,
                  check),
             *checked);
  auto migrated = std::make_shared<DbArgs>();
  CLI::App* up =
      verb(*db, "migrate", "Update an older store to the current schema; compress records without loss",
           migrated, migrate);
  add_common(up, *migrated);
  up->add_flag("--compact", migrated->compact, "return freed pages to the system; needs space for a copy");
  auto merged = std::make_shared<DbArgs>();
  CLI::App* together =
      verb(*db, "merge", "Merge stores into one, in any order; a store may be given twice", merged, merge);
  together->add_option("sources", merged->sources, "stores to read; they stay as they are")->required();
  together->add_option("-o,--output", merged->output, "store to add them to; made if missing")->required();
  together->add_flag("--json", merged->json, "JSON to stdout");
  together->footer(
      "Equal campaigns and equal shots are stored once. If two stores differ in a shot, its extraction, a "
      "block of a sweep\nor a point of a study, the difference is printed and nothing is merged. `powbench "
      "db check` "
      "prints a hash of the content that "
      "does not "
      "depend on the order.");
  auto parts = std::make_shared<DbArgs>();
  CLI::App* apart = verb(*db, "split", "Write each campaign to a store of its own", parts, split);
  apart->add_option("--db", parts->database, "store")->capture_default_str();
  apart->add_option("-o,--output", parts->output, "folder to write into; made if missing")->required();
  apart->add_option("--campaign", parts->campaign, "only this one")->check(CLI::Range(1, 1'000'000'000));
  auto pushed = std::make_shared<DbArgs>();
  CLI::App* up_to =
      verb(*db, "push", "Add a store to a PostgreSQL database that many benches share", pushed, push);
  up_to->add_option("database", pushed->address, "postgresql://USER@HOST:PORT/DATABASE")->required();
  add_common(up_to, *pushed);
  up_to->footer(
      "Content that the database has is not sent again. An interrupted push continues with the same command. "
      "If store\n"
      "and database differ in a shot, its extraction or a block of a sweep, this is printed and nothing is "
      "pushed.\n"
      "The password comes from PGPASSWORD, ~/.pgpass or a service file (?service=NAME), never from the "
      "address.");
  auto pulled = std::make_shared<DbArgs>();
  CLI::App* down =
      verb(*db, "pull", "Fetch campaigns from a shared PostgreSQL database into a store", pulled, pull);
  down->add_option("database", pulled->address, "postgresql://USER@HOST:PORT/DATABASE")->required();
  add_common(down, *pulled);
  down->add_option("--customer", pulled->customer, "only campaigns whose test record names this customer");
  down->add_option("--device", pulled->device, "only campaigns of this device");
  down->add_option("--name", pulled->name, "only campaigns of this name");
  down->add_option("--since", pulled->since,
                   "only campaigns begun on this day or later: year-month-day (UTC), such as 2030-12-31");
  down->footer(
      "Without these options all campaigns and sweeps are fetched. An existing store gets what it lacks, "
      "as by\n"
      "`db merge`. If no campaign matches, a message lists what exists, the exit code is 2, and no "
      "file is\n"
      "written.");
}

}  // namespace powbench::host
