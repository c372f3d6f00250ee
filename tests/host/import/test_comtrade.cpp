#include "host/import/comtrade.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "core/random.h"
#include "host/config/bad_input.h"
#include "host/import/waveform.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

const std::string head =
    "Sub 1,Relay,1999\r\n3,2A,1D\r\n1,Ua,A,,V,0.5,10,100,-32767,32767,1,1,P\r\n"
    "2,Ia,A,,A,2,0,0,-32767,32767,1,1,P\r\n1,Trip,,,0\r\n50\r\n";
const std::string day = "01/02/2030,23:59:59.999000\r\n02/02/2030,00:00:00.001000\r\n";

/// Two rates: samples 1 .. 2 at 1 kHz, 3 .. 4 at 500 Hz.
std::string configuration(const std::string& format, const std::string& rates = "2\r\n1000,2\r\n500,4\r\n") {
  return head + rates + day + format + "\r\n1\r\n";
}

template <class Word>
std::string bytes(Word value) {
  std::string out;
  for (unsigned i = 0; i < sizeof value; ++i) out += static_cast<char>(value >> (8 * i) & 0xFF);
  return out;
}

std::string binary(const std::string& format) {
  std::string out;
  for (std::uint32_t n = 1; n <= 4; ++n) {
    out += bytes<std::uint32_t>(n) + bytes<std::uint32_t>(1000 * (n - 1));
    for (const int value : {static_cast<int>(10 * n), -static_cast<int>(n)}) {
      const bool lost = n == 3 && value < 0;
      if (format == "BINARY") out += bytes(static_cast<std::uint16_t>(lost ? -32768 : value));
      if (format == "BINARY32") out += bytes(lost ? 0x80000000U : static_cast<std::uint32_t>(value));
      if (format == "FLOAT32")
        out += bytes(std::bit_cast<std::uint32_t>(lost ? NAN : static_cast<float>(value)));
    }
    out += bytes<std::uint16_t>(1);
  }
  return out;
}

const std::string ascii = "1,0,10,-1,0\r\n2,1000,20,-2,0\r\n3,2000,30,99999,1\r\n4,3000,40,-4,1\r\n";

void check_values(const Comtrade& c) {
  CHECK(c.station == "Sub 1");
  CHECK(c.revision == 1999);
  CHECK(c.line_hertz == 50.0);
  REQUIRE(c.channels.size() == 2);
  CHECK(c.channels[0].name == "Ua");
  CHECK(c.channels[0].unit == "V");
  CHECK(c.channels[0].skew == Approx(1e-4));
  CHECK(c.channels[0].value == std::vector<double>{15, 20, 25, 30});
  CHECK(c.channels[1].value[3] == -8.0);
  CHECK(std::isnan(c.channels[1].value[2]));
}

std::string complaint(const std::string& configuration, const std::string& data) {
  try {
    parse_comtrade(configuration, data, "x.cfg", "x.dat");
    return "";
  } catch (const BadInput& e) {
    return e.what();
  }
}

}  // namespace

TEST_CASE("every format of COMTRADE gives the same numbers", "[import][comtrade]") {
  for (const std::string format : {"ASCII", "BINARY", "BINARY32", "FLOAT32"}) {
    INFO(format);
    const Comtrade c =
        parse_comtrade(configuration(format), format == "ASCII" ? ascii : binary(format), "x.cfg", "x.dat");
    check_values(c);
    // 2 ms before the trigger; the interval behind a sample is that of its rate
    const std::vector<double> wanted{-0.002, -0.001, 0.0, 0.002};
    REQUIRE(c.time.size() == wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) CHECK(c.time[i] == Approx(wanted[i]).margin(1e-12));
  }
}

TEST_CASE("without a rate the time stamps count", "[import][comtrade]") {
  const Comtrade c =
      parse_comtrade(configuration("BINARY", "0\r\n0,4\r\n"), binary("BINARY"), "x.cfg", "x.dat");
  for (std::size_t i = 0; i < 4; ++i)
    CHECK(c.time[i] == Approx(1e-3 * static_cast<double>(i) - 2e-3).margin(1e-12));
  CHECK_THAT(complaint(configuration("ASCII", "0\r\n0,1\r\n"), "1,,10,-1,0\r\n"),
             Contains("x.dat: row 1: has no time stamp"));
}

TEST_CASE("a single file of 2013 holds both parts", "[import][comtrade]") {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "powbench_comtrade_test.cff";
  std::ofstream(file, std::ios::binary) << "--- file type: CFG ---\r\n" + configuration("ASCII") +
                                               "--- file type: INF ---\r\n--- file type: DAT ASCII ---\r\n" +
                                               ascii;
  check_values(read_comtrade(file));
  std::ofstream(file, std::ios::binary) << "--- file type: CFG ---\r\n" + configuration("FLOAT32") +
                                               "--- file type: DAT FLOAT32: 72 ---\r\n" + binary("FLOAT32");
  check_values(read_comtrade(file));
  std::ofstream(file, std::ios::binary) << "nothing";
  CHECK_THROWS_WITH(read_comtrade(file), Contains("no part CFG"));
  std::filesystem::remove(file);
}

TEST_CASE("what is wrong with a COMTRADE file is said once, with line or row", "[import][comtrade]") {
  CHECK_THAT(complaint("a,b\n", ""), Contains("x.cfg:2: the file ends before the number of channels"));
  CHECK_THAT(complaint("a,b,1850\n", ""), Contains("x.cfg:1: revision year = '1850'; allowed 1991 .. 2099"));
  CHECK_THAT(complaint("a,b,1999\n1,1B,0D\n", ""), Contains("x.cfg:2: '1B'"));
  CHECK_THAT(complaint(configuration("WAVE"), ""), Contains("format 'WAVE'; allowed ASCII"));
  CHECK_THAT(complaint(configuration("ASCII"), "1,0,10,-1,0\n"),
             Contains("x.dat: row 2: the file ends; the configuration promises 4 rows"));
  CHECK_THAT(complaint(configuration("ASCII"), "1,0,ten,-1,0\n"),
             Contains("row 1: channel Ua = 'ten'; allowed a number"));
  CHECK_THAT(complaint(configuration("BINARY"), "short"),
             Contains("x.dat: 5 bytes; 4 rows of 14 bytes make 56"));
}

TEST_CASE("a damaged COMTRADE file is refused, never read beyond its end", "[import][comtrade]") {
  Random random(7);
  for (const std::string format : {"ASCII", "BINARY"}) {
    for (int i = 0; i < 3000; ++i) {
      std::string text = configuration(format), data = format == "ASCII" ? ascii : binary(format);
      std::string& hit = random.below(2) == 0 ? text : data;
      hit[random.below(hit.size())] = static_cast<char>(random.below(256));
      if (random.below(4) == 0) hit.resize(random.below(hit.size()));
      try {
        const Comtrade c = parse_comtrade(text, data, "x.cfg", "x.dat");
        for (const auto& channel : c.channels) REQUIRE(channel.value.size() == c.time.size());
      } catch (const BadInput& e) {
        CHECK(e.errors().size() == 1);
      }
    }
  }
}

TEST_CASE("a relay's recording becomes a record", "[import][comtrade]") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "powbench_comtrade_import";
  std::filesystem::create_directories(folder);
  const std::filesystem::path file = folder / "fault.cfg";
  std::ofstream(file) << "S,R,1999\n1,1A,0D\n1,Ua,,,V,0.1,0,250,-32767,32767,1,1,P\n50\n1\n10000,2000\n"
                         "01/02/2030,10:00:00.000000\n01/02/2030,10:00:00.100000\nASCII\n1\n";
  std::ofstream data(folder / "fault.dat");
  for (int n = 0; n < 2000; ++n)
    data << n + 1 << "," << n * 100 << ","
         << std::lround(3250 * std::sin(2 * 3.14159265358979 * 50 * n / 10000.0)) << "\n";
  data.close();
  std::ofstream(folder / "fault.toml") << "[columns]\ntime = \"time\"\nmains_voltage = \"Ua\"\n";
  for (const char* name : {"fault.cfg", "fault.dat"}) {
    const Imported in = import_file(folder / name, std::nullopt);
    REQUIRE(in.record.channels.size() == 1);
    CHECK(in.record.sample_rate == Approx(10000.0));
    CHECK(in.record.fire_sample == 1000);
    CHECK(in.record.channels[0].channel == Channel::mains_voltage);
    CHECK(in.record.channels[0].delay == Approx(-250e-6));
  }
  // an exported file has the sensor's delay as its skew, and its calibration file names it, too
  const auto delay_with = [&](const std::string& more) {
    std::ofstream(folder / "fault.toml")
        << "[columns]\ntime = \"time\"\nmains_voltage = \"Ua\"\n[mains_voltage]\n" + more;
    const Imported in = import_file(file, std::nullopt);
    return in.record.channels[0].delay;
  };
  CHECK(delay_with("delay_us = -250\n") == Approx(-250e-6));
  CHECK(delay_with("delay_us = 40\n") == Approx(-210e-6));
  std::ofstream(folder / "fault.toml")
      << "switch_on_s = 5\n[columns]\ntime = \"time\"\nmains_voltage = \"Ua\"\n";
  CHECK_THROWS_WITH(import_file(file, std::nullopt), Catch::Contains("switch_on_s = 5: the record is from"));
  std::filesystem::remove_all(folder);
}
