#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "host/store/sweep_store.h"
#include "tests/host/store_samples.h"

/// Stores that share a part of their content.

namespace powbench::host {

inline const ExtractionInfo& sample_extraction() {
  static const ExtractionInfo info{"cutoff = 1\n", "0.1.0"};
  return info;
}

inline void put_shot(Store& store, std::int64_t campaign, int number, std::uint64_t seed,
                     Outcome outcome = Outcome::pass) {
  StoredShot shot = sample_shot(campaign, number);
  shot.outcome = outcome;
  shot.started = "2026-05-04T10:00:00Z";
  if (!measured(outcome)) {
    store.store_shot(shot, nullptr, nullptr, sample_extraction());
    return;
  }
  const Record record = sample_record(seed);
  const Events events = sample_events(seed);
  const auto id = store.store_shot(shot, &record, &events, sample_extraction());
  store.store_prediction(id, {{{"t_ct1", 1e-6 * static_cast<double>(seed)}}, {}});
}

/// Three stores that overlap: copies of one campaign that went on apart, each with one of its own and a share of a
/// sweep.
struct Three {
  Folder folder;
  std::vector<std::string> files{folder.file("a.db"), folder.file("b.db"), folder.file("c.db")};

  Three() {
    {
      Store store(files[0]);
      const auto c = store.create_campaign(sample_campaign("common"));
      put_shot(store, c, 0, 10);
      put_shot(store, c, 1, 11, Outcome::error);
    }
    write_bytes(files[1], bytes_of(files[0]));
    write_bytes(files[2], bytes_of(files[0]));
    for (int i = 0; i < 3; ++i) {
      Store store(files[static_cast<std::size_t>(i)]);
      put_shot(store, 1, 2 + i, static_cast<std::uint64_t>(20 + i));
      store.annotate(1, "operator", std::string(1, static_cast<char>('A' + i)));
      const auto own = store.create_campaign(sample_campaign("own" + std::to_string(i)));
      put_shot(store, own, 0, static_cast<std::uint64_t>(30 + i));
      if (i == 1) store.set_finished(1, true);
      SweepStore sweeps(files[static_cast<std::size_t>(i)]);
      SweepInfo info;
      info.design = "{}", info.design_hash = "h", info.points = 30, info.columns = "x",
      info.program_version = "1";
      const auto sweep = sweeps.open_sweep(info);
      const std::vector<double> numbers(10, std::nan(""));
      sweeps.put(sweep, std::vector{SweepBlock{10 * i, 10, numbers}});
      if (i == 2) sweeps.put(sweep, std::vector{SweepBlock{0, 10, numbers}});  // once more
    }
  }
};

}  // namespace powbench::host
