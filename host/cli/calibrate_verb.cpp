#include <fmt/chrono.h>
#include <fmt/format.h>

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

}  // namespace

Exit calibrate(const CalibrateArgs& args) {
  const std::string date = args.date.empty() ? utc_today() : args.date;
  const std::uint32_t from = day(date, "date"), until = day(args.expires, "expires");
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
  try {
    link.write(control, "lease", token + " 600000 calibrate");
    const Walk w = walk(link, token, ask);
    store(link, token, w, args.id, from, until);
    link.write(control, "abort",
               "1 " + token);  // a quantity at the current's input is a current without a gate
    link.write(control, "lease", token + " 0");
    write_file(
        args.output,
        fmt::format(
            "# Certificate of a calibration, written by powbench {}.\nid = \"{}\"\ndate = "
            "\"{}\"\nexpires = \"{}\"\n"
            "by = \"{}\"\nrig = \"{}, {}\"\nkind = \"{}\"\nreplaces = \"{}\"\nrows_crc32 = \"{:08x}\"\n"
            "switch_delay_us = {:.3f}\n",
            program_version, args.id, date, args.expires, args.by, info.model, info.serial, info.kind,
            info.calibration, rigs::rows_crc32(w.rows), w.switch_delay * 1e6) +
            w.report);
  } catch (const rigs::Refusal& refusal) {
    throw rigs::RigError(rigs::sentence(refusal) + ": " + link.read(control, "last_error"));
  } catch (const rigs::LinkBroken& broken) {
    throw rigs::RigError(broken.sentence);
  }
  fmt::print(stderr, "calibration {} is in force on {}; certificate: {}\n", args.id, info.serial,
             args.output);
  return Exit::pass;
}

}  // namespace powbench::host
