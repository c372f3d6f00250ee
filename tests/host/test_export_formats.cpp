#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "host/config/bad_input.h"
#include "host/config/csv_table.h"
#include "host/export/contact_table.h"
#include "host/export/csv.h"
#include "host/export/event_table.h"
#include "host/export/waveforms.h"
#include "host/import/comtrade.h"
#include "tests/host/store_samples.h"
#include "tests/places.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Matchers::Contains;

namespace {

/// Gaps of the record and of one channel, extreme counts, offsets that are no whole numbers.
Record gappy(std::uint64_t seed) {
  Record r = sample_record(seed, 600);
  r.fire_sample = 400;
  r.channels[1].gaps = {{20, 2}};
  r.channels[2].offset = 0;
  r.conditions.mains_hertz = 50;
  return r;
}

bool equal(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) ||
         std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

const std::vector<double>& doubles(const TableColumn& c) {
  return std::get<std::vector<double>>(c.values);
}

/// What a command prints, and its exit code.
std::pair<int, std::string> output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return {-1, ""};
  char piece[4096];
  for (std::size_t n; (n = fread(piece, 1, sizeof piece, pipe)) > 0;) text.append(piece, n);
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text};
}

Table sample_table() {
  return {{"shot", std::vector<std::int64_t>{1, -2, INT64_MAX}},
          {"outcome", std::vector<std::string>{"PASS", "", "\xC3\xA4 <&\"> \t, x"}},
          {"touch_s", std::vector<double>{1.0 / 3, std::nan(""), -0.0}},
          {"u_touch_s", std::vector<double>{5e-324, 1.7976931348623157e308, 0.1 + 0.2}}};
}

}  // namespace

TEST_CASE("CSV and COMTRADE read back are the same numbers", "[export]") {
  for (const std::uint64_t seed : {1U, 2U}) {
    Record r = gappy(seed);
    const Table table = waveform_table(r);
    const CsvTable csv = read_csv(to_csv(r), "x.csv");
    REQUIRE(csv.columns.size() == table.size());
    for (std::size_t c = 0; c < table.size(); ++c)
      for (std::size_t i = 0; i < r.samples(); ++i)
        if (!equal(csv.columns[c][i], doubles(table[c])[i])) FAIL("column " << c << " row " << i);
    // counts of -32768 are the code of BINARY for a lost sample: then it is BINARY32
    for (const bool wide : {true, false}) {
      if (!wide)
        for (ChannelRecord& ch : r.channels)
          for (std::int16_t& x : ch.raw) x = std::max<std::int16_t>(x, -32767);
      const ComtradeText text = to_comtrade(r, "a, b");
      CHECK_THAT(text.configuration, Contains(wide ? "BINARY32" : "BINARY\r\n"));
      const Comtrade back = parse_comtrade(text.configuration, text.data, "x.cfg", "x.dat");
      REQUIRE(back.channels.size() == r.channels.size());
      const Table now = waveform_table(r);
      for (std::size_t k = 0; k < back.channels.size(); ++k) {
        const ChannelRecord& ch = r.channels[k];
        CHECK(back.channels[k].name == info(ch.channel).name);
        CHECK(back.channels[k].skew == Approx(-ch.delay));
        for (std::size_t i = 0; i < r.samples(); ++i) {
          const double want = doubles(now[k + 1])[i], got = back.channels[k].value[i];
          if (std::isnan(want) != std::isnan(got)) FAIL("lost sample " << k << " " << i);
          if (std::isnan(want)) continue;
          if (!equal(got, ch.scale * ch.raw[i] + ch.offset * ch.scale)) FAIL("channel " << k << " row " << i);
          if (ch.offset == 0 && !equal(got, want)) FAIL("channel " << k << " row " << i);
        }
      }
      for (std::size_t i = 0; i < r.samples(); ++i)
        if (std::abs(back.time[i] - r.time(i)) > 1e-9) FAIL("time " << i);
    }
  }
}

TEST_CASE("the delay of each channel goes beside a table that has one column of time", "[export]") {
  Record r = gappy(4);
  r.channels[0].delay = 300e-6;
  const About delays = delays_of(r);
  REQUIRE(delays.size() == r.channels.size() + 1);
  CHECK(delays[1] == std::pair<std::string, std::string>("delay_us pvdf_a", "300"));
}

TEST_CASE("other people's libraries read the same numbers", "[export][python]") {
  if (output_of("/usr/bin/python3 -c 'import numpy'").first != 0) {
    WARN("python3-numpy is not installed: nothing was read back by another program");
    return;
  }
  const Folder folder;
  Record r = gappy(3);
  r.channels[0].gaps = {};
  r.gaps = {{30, 4}};
  const About about{{"title", "powbench sample"}, {"events", std::string(20'000, 'x')}};
  if (can_write_netcdf()) write_netcdf(r, about, folder.file("record.nc"));
  const Table table = waveform_table(r);
  write_bytes(folder.file("record.xlsx"),
              to_xlsx({{"record", table}, {"about", {{"key", std::vector<std::string>{"a"}}}}}));
  write_bytes(folder.file("record.csv"), "# a line\n" + to_csv(r));
  const ComtradeText text = to_comtrade(r, "sample");
  write_bytes(folder.file("record.cfg"), text.configuration);
  write_bytes(folder.file("record.dat"), text.data);
  std::string names, bytes;
  for (const TableColumn& c : table) {
    names += c.name + "\n";
    bytes.append(reinterpret_cast<const char*>(doubles(c).data()), 8 * doubles(c).size());
  }
  write_bytes(folder.file("columns.txt"), names);
  write_bytes(folder.file("expected.bin"), bytes);
  const auto [status, printed] = output_of("/usr/bin/python3 " + powbench::test::source_dir() +
                                           "/tests/host/read_back.py " + folder.path().string());
  INFO(printed);
  CHECK(status == 0);
  CHECK_THAT(printed, Contains("comtrade numpy equal"));
  CHECK_THAT(printed, !Contains("differs"));
  for (const char* missing : {"not installed", "not built"})
    if (printed.find(missing) != std::string::npos) WARN(printed);
  // and it can fail: one bit of one number
  bytes[bytes.size() / 2 + 3] = static_cast<char>(bytes[bytes.size() / 2 + 3] ^ 1);
  write_bytes(folder.file("expected.bin"), bytes);
  CHECK(output_of("/usr/bin/python3 " + powbench::test::source_dir() + "/tests/host/read_back.py " +
                  folder.path().string())
            .first != 0);
}

TEST_CASE("each closed interval of each contact is a row with its uncertainty", "[export]") {
  Events events;
  Contact c;
  c.touch = {0.011, 2e-6}, c.release = {0.012, 3e-6}, c.flags = flag_grazing | flag_gap;
  events.contact_voltage.contacts = {c, Contact{}};
  c.peak = {45.0, 0.5}, c.probability = 0.7;
  events.pvdf_b.contacts = {c};
  const Table t = contact_table({{7, events}, {9, Events{}}});
  REQUIRE(rows(t) == 3);
  const auto column = [&](const std::string& name) {
    return std::find_if(t.begin(), t.end(), [&](const TableColumn& x) { return x.name == name; })->values;
  };
  using Texts = std::vector<std::string>;
  using Numbers = std::vector<double>;
  CHECK(std::get<std::vector<std::int64_t>>(column("shot")) == std::vector<std::int64_t>{7, 7, 7});
  CHECK(std::get<Texts>(column("channel")) == Texts{"contact_a", "contact_a", "pvdf_b"});
  CHECK(std::get<std::vector<std::int64_t>>(column("contact")) == std::vector<std::int64_t>{1, 2, 1});
  CHECK(std::get<Numbers>(column("touch_s"))[0] == 0.011);
  CHECK(std::isnan(std::get<Numbers>(column("touch_s"))[1]));
  CHECK(std::get<Numbers>(column("u_release_s"))[2] == 3e-6);
  CHECK(std::get<Numbers>(column("peak_N"))[2] == 45.0);
  CHECK(std::get<Numbers>(column("probability")) == Numbers{1.0, 1.0, 0.7});
  CHECK(std::get<Texts>(column("flags"))[1].empty());
  CHECK(std::get<Texts>(column("flags"))[0].find("grazing") != std::string::npos);
}

TEST_CASE("an Arrow file is read by apache-arrow, bit for bit", "[export][arrow]") {
  const Folder folder;
  const Table table = sample_table();
  const std::string bytes = to_arrow(table, {{"campaign", "1, demo"}});
  CHECK(bytes.starts_with(std::string("ARROW1\0\0", 8)));
  CHECK(bytes.ends_with("ARROW1"));
  CHECK(to_arrow(table, {{"campaign", "1, demo"}}) == bytes);
  write_bytes(folder.file("events.arrow"), bytes);
  const auto [status, printed] =
      output_of("node " + powbench::test::source_dir() + "/tests/host/read_back.mjs " +
                folder.file("events.arrow") + " " + powbench::test::source_dir() + "/build/npm");
  if (status == 77 || status == 127) {
    WARN(
        "apache-arrow of npm is not in build/npm (./dev test --slow puts it there): nothing was read back by "
        "another program");
    return;
  }
  INFO(printed);
  REQUIRE(status == 0);
  const auto read = nlohmann::json::parse(printed);
  CHECK(read["rows"] == 3);
  CHECK(read["metadata"]["campaign"] == "1, demo");
  REQUIRE(read["columns"].size() == table.size());
  for (std::size_t c = 0; c < table.size(); ++c) {
    const auto& column = read["columns"][c];
    CHECK(column["name"] == table[c].name);
    for (std::size_t i = 0; i < 3; ++i) {
      INFO(table[c].name << " " << i);
      const auto& got = column["values"][i];
      if (const auto* v = std::get_if<std::vector<double>>(&table[c].values)) {
        if (std::isnan((*v)[i]))
          CHECK(got.is_null());
        else
          CHECK(got == fmt::format("{:016x}", std::bit_cast<std::uint64_t>((*v)[i])));
      } else if (const auto* n = std::get_if<std::vector<std::int64_t>>(&table[c].values)) {
        CHECK(got == std::to_string((*n)[i]));
      } else {
        CHECK(got == std::get<std::vector<std::string>>(table[c].values)[i]);
      }
    }
  }
}

TEST_CASE("an empty table is a table, and too large a sheet is refused", "[export]") {
  CHECK(to_arrow({{"x", std::vector<double>{}}}).size() > 100);
  CHECK(to_xlsx({{"x", {{"x", std::vector<double>{}}}}}).size() > 100);
  CHECK_THROWS_WITH(to_xlsx({{"long", {{"x", std::vector<double>(1'048'576)}}}}),
                    Contains("Excel takes 1048575"));
}

TEST_CASE("a netCDF file that cannot be written is refused in words and leaves nothing", "[export]") {
  const Folder folder;
  CHECK_THROWS_AS(write_netcdf(gappy(1), {}, folder.file("no/such/folder.nc")), BadInput);
  CHECK(std::filesystem::is_empty(folder.path()));
}
