#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "core/version.h"
#include "host/cli/picture.h"
#include "host/cli/program.h"
#include "host/cli/shard.h"
#include "host/cli/study.h"
#include "host/cli/threads.h"
#include "host/gather/scene.h"
#include "host/run/stop.h"
#include "host/store/hash.h"
#include "host/store/sweep_store.h"
#include "host/study/study_svg.h"
#include "host/study/sweep_text.h"
#include "sim/specimen/validate.h"

namespace powbench::host {
namespace {

std::vector<double> numbers(std::string_view text, const std::string& whole) {
  std::vector<double> list;
  while (true) {
    const auto colon = text.find(':');
    const std::string_view part = text.substr(0, colon);
    double value = 0;
    const auto read = std::from_chars(part.data(), part.data() + part.size(), value);
    if (part.empty() || read.ec != std::errc() || read.ptr != part.data() + part.size())
      throw BadInput({"--vary " + whole + ": '" + std::string(part) +
                      "' is not a number; allowed NAME=LOW:HIGH[:STEPS] or NAME~MEAN:DEVIATION"});
    list.push_back(value);
    if (colon == std::string_view::npos) return list;
    text.remove_prefix(colon + 1);
  }
}

sim::Axis axis(const std::string& text) {
  const auto mark = text.find_first_of("=~");
  if (mark == std::string::npos)
    throw BadInput({"--vary " + text + ": allowed NAME=LOW:HIGH[:STEPS] or NAME~MEAN:DEVIATION"});
  const auto list = numbers(std::string_view(text).substr(mark + 1), text);
  const bool normal = text[mark] == '~';
  if (list.size() < 2 || list.size() > (normal ? 2U : 3U))
    throw BadInput({"--vary " + text + ": allowed NAME=LOW:HIGH[:STEPS] or NAME~MEAN:DEVIATION"});
  try {
    const std::string name = text.substr(0, mark);
    if (normal) return sim::normal_axis(name, list[0], list[1]);
    if (list.size() > 2 && !(list[2] == std::floor(list[2])))
      throw BadInput({fmt::format("--vary {}: {:g} steps: allowed a whole number", text, list[2])});
    return sim::uniform_axis(name, list[0], list[1], list.size() > 2 ? static_cast<int>(list[2]) : 5);
  } catch (const std::invalid_argument& e) {
    throw BadInput({std::string("--vary ") + e.what()});
  }
}

/// What scatters from shot to shot and from device to device where the user names nothing.
std::vector<std::string> usual_tolerances(const SweepArgs& args, const sim::Specimen& s) {
  return {fmt::format("supply_volts~{}:{}", args.supply_volts, 0.01 * args.supply_volts),
          fmt::format("ambient_degC~{}:5", args.ambient_degC),
          fmt::format("core.friction_N~{:.6g}:{:.6g}", s.core.friction, 0.1 * s.core.friction),
          fmt::format("bridges.gap_mm~{:.6g}:0.02", s.bridges.gap * 1e3)};
}

struct Study {
  sim::Case base;
  std::vector<sim::Axis> axes;
  sim::MetricOptions options;
  const sim::MetricInfo* metric = nullptr;
};

Study prepare(const SweepArgs& args) {
  Study s;
  s.base.specimen = args.specimen_file.empty() ? sim::Specimen{} : read_specimen(args.specimen_file);
  s.base.conditions.closing_angle = radians(args.angle_deg);
  s.base.conditions.supply_volts = args.supply_volts;
  s.base.conditions.ambient = args.ambient_degC + zero_celsius;
  s.metric = sim::find_metric(args.metric);
  if (s.metric == nullptr) throw BadInput({"--metric " + args.metric + ": allowed " + metric_columns()});
  auto vary = args.vary;
  if (vary.empty() && args.best_angle) vary = usual_tolerances(args, s.base.specimen);
  if (vary.empty() && !args.sensitivity)
    throw BadInput({"--vary: name at least one variable, such as angle_deg=0:180:37"});
  for (const auto& text : vary) {
    s.axes.push_back(axis(text));
    const auto same = [&](const sim::Axis& a) { return a.variable.name == s.axes.back().variable.name; };
    if (std::count_if(s.axes.begin(), s.axes.end(), same) > 1)
      throw BadInput(
          {fmt::format("--vary {}: {} is varied twice; keep one", text, s.axes.back().variable.name)});
  }
  const bool needs_forces = args.metric == "first_peak" || args.metric == "impulse";
  if (args.forces || needs_forces) s.options.sample_dt = 5e-6;
  return s;
}

std::string design_text(const SweepArgs& args, const Study& s) {
  nlohmann::ordered_json j{{"specimen", resolved_text(s.base.specimen)},
                           {"angle_deg", args.angle_deg},
                           {"supply_volts", args.supply_volts},
                           {"ambient_degC", args.ambient_degC},
                           {"vary", args.vary},
                           {"sampling", args.sampling},
                           {"points", args.points},
                           {"seed", args.seed},
                           {"forces", s.options.sample_dt > 0},
                           {"program", program_identity()}};
  return j.dump();
}

constexpr std::int64_t block = 500;  ///< points

/// What a kill loses: closings of this time, s, and of the blocks that are not whole; a stop only the latter.
constexpr double between_puts = 0.25;

/// Stores the blocks of a sweep as they become whole.
class BlockWriter {
 public:
  /// `firsts`: number of the first point of each block.
  BlockWriter(SweepStore& store, std::int64_t sweep, std::span<const std::int64_t> firsts,
              std::int64_t points)
      : store_(store), sweep_(sweep), left_(firsts.size()) {
    for (std::size_t k = 0; k < firsts.size(); ++k) {
      const std::int64_t count = std::min(block, points - firsts[k]);
      blocks_.push_back({firsts[k], count, {}});
      left_[k] = count;
      for (std::int64_t i = 0; i < count; ++i) numbers_.push_back(firsts[k] + i), places_.push_back(k);
    }
  }
  std::span<const std::int64_t> numbers() const { return numbers_; }

  void add(std::size_t place, const std::vector<double>& row) {
    SweepBlock& b = blocks_[places_[place]];
    b.numbers.resize(static_cast<std::size_t>(b.count) * row.size());
    std::copy(row.begin(), row.end(),
              b.numbers.begin() + (numbers_[place] - b.first) * static_cast<std::ptrdiff_t>(row.size()));
    if (--left_[places_[place]] > 0) return;
    whole_.push_back(std::move(b));
    if (std::chrono::steady_clock::now() - put_ > std::chrono::duration<double>(between_puts)) put();
  }
  void put() {
    if (!whole_.empty()) store_.put(sweep_, whole_);
    whole_.clear();
    put_ = std::chrono::steady_clock::now();
  }

 private:
  SweepStore& store_;
  std::int64_t sweep_;
  std::vector<SweepBlock> blocks_, whole_;
  std::vector<std::int64_t> left_, numbers_;
  std::vector<std::size_t> places_;
  std::chrono::steady_clock::time_point put_ = std::chrono::steady_clock::now();
};

sim::Design design_of(const SweepArgs& args, const Study& s) {
  const std::map<std::string, sim::Sampling> samplings{{"grid", sim::Sampling::grid},
                                                       {"latin", sim::Sampling::latin},
                                                       {"monte-carlo", sim::Sampling::monte_carlo}};
  return {s.axes, samplings.at(args.sampling), args.points, args.seed};
}

Exit run_sweep(const SweepArgs& args, const Study& s, sim::Team& team) {
  const sim::Design design = design_of(args, s);
  for (const double end : {0.0, 1.0}) {  // corners: an impossible specimen is refused before anything runs
    std::vector<double> corner;
    for (const auto& a : s.axes) corner.push_back(a.at(end));
    const auto wrong = sim::validate(design.apply(s.base, corner).specimen);
    if (!wrong.empty())
      throw BadInput(
          {"--vary reaches " + wrong[0].key + " = " + wrong[0].value + ": allowed " + wrong[0].range});
  }
  const Shard shard = read_shard(args.shards.shard);
  SweepStore store(args.database);
  SweepInfo info;
  info.design = design_text(args, s);
  info.design_hash = sha256_hex(info.design);
  info.points = design.size();
  info.columns = metric_columns();
  info.program_version = program_version;
  const std::int64_t id = store.open_sweep(info);

  const std::size_t width = sim::metric_table.size();
  const bool whole = shard.of == 1;  // a shard prints nothing: it keeps no rows
  std::vector<std::vector<double>> rows(whole ? static_cast<std::size_t>(design.size()) : 0);
  std::vector<bool> known(static_cast<std::size_t>(design.size()), false);
  for (const auto& b : store.blocks(id))
    for (std::int64_t k = 0; k < b.count; ++k) {
      const auto from = b.numbers.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(k) * width);
      if (whole)
        rows[static_cast<std::size_t>(b.first + k)].assign(from, from + static_cast<std::ptrdiff_t>(width));
      known[static_cast<std::size_t>(b.first + k)] = true;
    }
  const auto count_of = [&](std::int64_t first) { return std::min(block, design.size() - first); };
  std::int64_t blocks = 0, own = 0, points = 0, done = 0;
  std::vector<std::int64_t> wanted;  // first points of the blocks to be simulated
  for (std::int64_t first = 0; first < design.size(); first += block, ++blocks) {
    if (!shard.has(blocks)) continue;
    ++own, points += count_of(first);
    if (known[static_cast<std::size_t>(first)])
      done += count_of(first);
    else
      wanted.push_back(first);
  }
  Progress progress("sweep", static_cast<std::size_t>(points), progress_style(args.progress),
                    static_cast<std::size_t>(done));
  BlockWriter writer(store, id, wanted, design.size());
  const auto numbers = writer.numbers();
  sim::stream_points(
      design, s.base, numbers, s.options, team,
      [&](std::size_t place, const sim::ClosingMetrics& m) {
        std::vector<double> row = metric_values(m);
        writer.add(place, row);
        if (whole) rows[static_cast<std::size_t>(numbers[place])] = std::move(row);
        progress.update(static_cast<std::size_t>(++done));
      },
      [] { return !StopOnSignal::asked(); });
  writer.put();
  if (done < points) {
    fmt::print(stderr, "stopped; the same command goes on with sweep {} in {}\n", id, args.database);
    return Exit::interrupted;
  }
  progress.finish();
  fmt::print(stderr, "sweep {} in {}\n", id, args.database);
  if (shard.of > 1) {
    fmt::print(
        stderr,
        "shard {}/{}: {} of {} blocks of {} points; powbench db merge -o ALL.db PART.db... puts the shards "
        "together, this command with --db ALL.db and without --shard prints the result\n",
        shard.index, shard.of, own, blocks, block);
    return Exit::pass;
  }
  fmt::print("{}", args.json ? sweep_json(design, rows, true) : sweep_text(rows));
  if (!args.picture.empty()) write_picture(args.picture, sweep_svg(design, rows));
  return Exit::pass;
}

Exit run_sensitivity(const SweepArgs& args, const Study& s, sim::Team& team) {
  std::vector<double> angles;
  for (int k = 0; k < args.angles; ++k) angles.push_back(pi * k / args.angles);
  const auto steps = sim::usual_steps();
  const auto rows = sim::sensitivities(s.base, angles, steps, *s.metric, s.options, team);
  fmt::print("{}", args.json ? sensitivity_json(rows, *s.metric) : sensitivity_text(rows, *s.metric));
  if (!args.picture.empty()) write_picture(args.picture, sensitivity_svg(rows, *s.metric));
  return Exit::pass;
}

Exit run_best_angle(const SweepArgs& args, const Study& s, sim::Team& team) {
  sim::BestAngleOptions options;
  options.angles = args.angles;
  options.draws = args.draws;
  options.seed = args.seed;
  const auto total = static_cast<std::size_t>(args.angles) * static_cast<std::size_t>(args.draws);
  Progress progress("best angle", total, progress_style(args.progress));
  const auto best = sim::best_angle(s.base, s.axes, *s.metric, s.options, options, team,
                                    [&](std::int64_t done, std::int64_t) {
                                      progress.update(static_cast<std::size_t>(done));
                                      return !StopOnSignal::asked();
                                    });
  progress.finish();
  if (best.mean.empty()) return Exit::interrupted;
  fmt::print("{}", args.json ? best_angle_json(best, *s.metric) : best_angle_text(best, *s.metric));
  if (best.closed[best.best] == 0) return Exit::outside_limits;
  if (!args.picture.empty()) write_picture(args.picture, best_angle_svg(best, *s.metric));
  return Exit::pass;
}

}  // namespace

Exit sweep(const SweepArgs& args) {
  if (args.sensitivity && args.best_angle) throw BadInput({"--sensitivity and --best-angle: one of them"});
  if ((args.shards.slurm > 0 || !args.shards.shard.empty()) && (args.sensitivity || args.best_angle))
    throw BadInput({"--shard and --slurm are of sweeps, not of --sensitivity and --best-angle"});
  const Study s = prepare(args);
  if (args.shards.slurm > 0) {
    if (const std::int64_t most = (design_of(args, s).size() + block - 1) / block; args.shards.slurm > most)
      throw BadInput({fmt::format("--slurm {}: allowed 1 .. {}: a shard takes whole blocks of {} points",
                                  args.shards.slurm, most, block)});
    fmt::print("{}", slurm_script(args.shards, args.database));
    return Exit::pass;
  }
  sim::Team team(worker_count(args.threads));
  const StopOnSignal stop;
  try {
    if (args.sensitivity) return run_sensitivity(args, s, team);
    if (args.best_angle) return run_best_angle(args, s, team);
    return run_sweep(args, s, team);
  } catch (const std::invalid_argument& e) {
    throw BadInput({std::string("sweep: ") + e.what()});
  }
}

}  // namespace powbench::host
