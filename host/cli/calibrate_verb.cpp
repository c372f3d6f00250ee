#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>

#include "core/version.h"
#include "host/cli/calibrate.h"
#include "host/cli/verbs.h"
#include "host/config/bad_input.h"
#include "host/export/write_file.h"
#include "host/gather/scene.h"
#include "rigs/iio_rig.h"
#include "rigs/registry.h"

namespace powbench::host {
namespace {

/// 2030-12-31 as 20301231; throws BadInput.
std::uint32_t day(const std::string& text, const char* option) {
  std::string digits;
  for (const char c : text)
    if (c >= '0' && c <= '9') digits += c;
  const bool shape = text.size() == 10 && text[4] == '-' && text[7] == '-' && digits.size() == 8;
  if (!shape || !rigs::is_day(std::stol(digits)))
    throw BadInput({fmt::format("--{} '{}': a day from 2000-01-01 to 2199-12-31 is wanted, as 2030-12-31",
                                option, text)});
  return static_cast<std::uint32_t>(std::stol(digits));
}

std::optional<std::string> ask(const std::string& question) {
  fmt::print(stderr, "{}\n> ", question);
  std::string line;
  if (!std::getline(std::cin, line)) return std::nullopt;
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
  return line;
}

/// Finds out before the walk whether the certificate can be written; a walk that fails leaves nothing behind, and a
/// former certificate as it was.
struct PlaceFor {
  explicit PlaceFor(const std::string& path) : file(path) {
    if (!std::ofstream(path, std::ios::binary | std::ios::app))
      throw BadInput({fmt::format("{}: cannot be written", path)});
  }
  ~PlaceFor() {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored) && std::filesystem::file_size(file, ignored) == 0)
      std::filesystem::remove(file, ignored);
  }
  PlaceFor(const PlaceFor&) = delete;
  PlaceFor& operator=(const PlaceFor&) = delete;
  std::string file;
};

std::string make_token() {
  std::random_device entropy;
  const char* secret = std::getenv("POWBENCH_RIG_SECRET");
  return fmt::format("{}{:08x}{:08x}", secret && *secret ? std::string(secret) + "." : "", entropy(),
                     entropy());
}

/// What a walk leaves as it was: the rig holds one certificate for all channels, so its last day is the earliest.
struct Kept {
  std::string channels;  ///< "laser, coil_voltage"
  std::string tables;    ///< TOML, for the certificate
  std::string from;      ///< "from LAB-1, valid until 2030-12-31"
  std::string expires;   ///< of the whole, 2030-12-31
};

Kept kept_of(const Walk& w, const rigs::RigInfo& before, const std::string& expires) {
  Kept kept{
      .channels = {},
      .tables = {},
      .from = fmt::format("from {}, {}", before.calibration,
                          before.calibration_expires.empty() ? "validity not stated"
                                                             : "valid until " + before.calibration_expires),
      .expires = expires};
  for (std::size_t i = 0; i < channel_count; ++i) {
    if (w.measured[i] || w.rows[i].scale_pico == 0) continue;  // or there is no such channel
    kept.channels += fmt::format("{}{}", kept.channels.empty() ? "" : ", ", channel_table[i].name);
    kept.tables += fmt::format("\n[{}]\nkept = \"{}\"\n", channel_table[i].name, kept.from);
  }
  if (!kept.channels.empty() && !before.calibration_expires.empty())
    kept.expires = std::min(expires, before.calibration_expires);
  return kept;
}

/// Why the walk is not stored; empty: it is.
std::string refusal_of(const Walk& w, const Kept& kept, const std::string& date) {
  if (std::none_of(w.measured.begin(), w.measured.end(), [](bool m) { return m; }))
    return "no channel was calibrated: nothing was stored";
  if (kept.expires < date)
    return fmt::format(
        "{} would be kept from a calibration that was valid until {}: calibrate them too; nothing "
        "was stored",
        kept.channels, kept.expires);
  return {};
}

}  // namespace

Exit calibrate(const CalibrateArgs& args) {
  const std::string date = args.date.empty() ? utc_today() : args.date;
  const std::uint32_t from = day(date, "date"), until = day(args.expires, "expires");
  if (!args.date.empty() && args.date > utc_today())
    throw BadInput({fmt::format("--date {} is a day to come; allowed up to {}", args.date, utc_today())});
  if (until < from) throw BadInput({fmt::format("--expires {} lies before {}", args.expires, date)});
  if (!rigs::usable_certificate(args.id))
    throw BadInput({fmt::format("--id '{}': 1 to 32 printable characters without blank and colon", args.id)});
  refuse_existing(args.output, args.overwrite);
  const PlaceFor place(args.output);

  const RigFile rig = rig_file(args.rig);
  const rigs::Endpoint end = rigs::endpoint(args.rig, rig.config, load_specimen(rig));
  rigs::IioLink link(end.uri, rigs::connect_limit, rigs::request_limit);
  const rigs::RigInfo info = link.read_info(args.rig);
  const std::string token = make_token();
  const auto control = rigs::IioLink::Device::control;
  Kept kept;
  try {
    link.write(control, "lease", token + " 600000 calibrate");
    const Walk w = walk(link, token, ask);
    kept = kept_of(w, info, args.expires);
    const std::string refusal = refusal_of(w, kept, date);
    if (refusal.empty()) store(link, token, w, args.id, from, day(kept.expires, "expires"));
    link.write(control, "abort",
               "1 " + token);  // a quantity at the current's input is a current without a gate
    link.write(control, "lease", token + " 0");
    if (!refusal.empty()) throw BadInput({refusal});
    write_file(
        args.output,
        fmt::format(
            "# Certificate of a calibration, written by powbench {}.\nid = \"{}\"\ndate = "
            "\"{}\"\nexpires = \"{}\"\n{}"
            "by = \"{}\"\nrig = \"{}, {}\"\nkind = \"{}\"\nreplaces = \"{}\"\nrows_crc32 = \"{:08x}\"\n"
            "switch_delay_us = {:.3f}\n",
            program_version, args.id, date, kept.expires,
            kept.expires == args.expires ? "" : fmt::format("expires_of_measured = \"{}\"\n", args.expires),
            args.by, info.model, info.serial, info.kind, info.calibration, rigs::rows_crc32(w.rows),
            w.switch_delay * 1e6) +
            w.report + kept.tables);
  } catch (const rigs::Refusal& refusal) {
    throw rigs::RigError(rigs::sentence(refusal) + ": " + link.read(control, "last_error"));
  } catch (const rigs::LinkBroken& broken) {
    throw rigs::RigError(broken.sentence);
  }
  fmt::print(stderr, "calibration {} is in force on {}, valid until {}; certificate: {}\n", args.id,
             info.serial, kept.expires, args.output);
  if (!kept.channels.empty()) fmt::print(stderr, "kept as they were, {}: {}\n", kept.from, kept.channels);
  return Exit::pass;
}

}  // namespace powbench::host
