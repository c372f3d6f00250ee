#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/random.h"
#include "host/config/bad_input.h"
#include "host/import/lvm.h"
#include "host/import/wav.h"
#include "host/import/waveform.h"

/// WAV and LVM.

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

template <class Word>
void put(std::string& out, Word value, std::size_t bytes = sizeof(Word)) {
  for (std::size_t i = 0; i < bytes; ++i)
    out.push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF));
}

/// Two channels: full scale down and a quarter, half and nothing; twice over.
std::string wav(unsigned code, unsigned bits, bool extensible = false) {
  std::string data;
  for (int i = 0; i < 2; ++i)
    for (const double v : {-1.0, 0.25, 0.5, 0.0}) {
      const double full = std::ldexp(1.0, static_cast<int>(bits) - 1);
      if (code == 3 && bits == 32) put(data, std::bit_cast<std::uint32_t>(static_cast<float>(v)));
      if (code == 3 && bits == 64) put(data, std::bit_cast<std::uint64_t>(v));
      if (code == 1) put(data, static_cast<std::int64_t>(v * full) + (bits == 8 ? 128 : 0), bits / 8);
    }
  std::string format;
  put<std::uint16_t>(format, static_cast<std::uint16_t>(extensible ? 0xFFFE : code));
  put<std::uint16_t>(format, 2);
  put<std::uint32_t>(format, 400);
  put<std::uint32_t>(format, 400 * 2 * bits / 8);
  put<std::uint16_t>(format, static_cast<std::uint16_t>(2 * bits / 8));
  put<std::uint16_t>(format, static_cast<std::uint16_t>(bits));
  if (extensible) {
    put<std::uint16_t>(format, 22);
    put<std::uint16_t>(format, static_cast<std::uint16_t>(bits));
    put<std::uint32_t>(format, 3);
    put<std::uint16_t>(format, static_cast<std::uint16_t>(code));
    format += std::string(14, 'g');
  }
  std::string body = "WAVELIST";
  put<std::uint32_t>(body, 3);
  body += "odd ";  // three bytes and one that fills
  body += "fmt ";
  put(body, static_cast<std::uint32_t>(format.size()));
  body += format + "data";
  put(body, static_cast<std::uint32_t>(data.size()));
  body += data;
  std::string out = "RIFF";
  put(out, static_cast<std::uint32_t>(body.size()));
  return out + body;
}

template <class Parse>
std::string complaint(Parse parse, const std::string& bytes) {
  try {
    parse(bytes, "x");
  } catch (const BadInput& e) {
    CHECK(e.errors().size() == 1);
    return e.errors().front();
  }
  return "accepted";
}

const std::string lvm =
    "LabVIEW "
    "Measurement\t\r\nWriter_Version\t2\r\nSeparator\tTab\r\nDecimal_Separator\t,\r\nX_Columns\tOne\r\n"
    "***End_of_Header***\t\r\n\t\r\nChannels\t2\t\t\r\nSamples\t3\t3\t\r\nY_Unit_Label\tNewtons\tVolts\t\r\n"
    "X0\t0,0\t0,0\t\r\nDelta_X\t0,001\t0,001\t\r\n***End_of_Header***\t\t\t\r\nX_Value\tForce\t\tComment\r\n"
    "0,000\t1,5\t-2\tfirst blow\r\n0,001\t2,5E+1\t\r\n0,002\t3\t-4\r\n";

}  // namespace

TEST_CASE("WAV of every kind gives the same numbers", "[import][wav]") {
  for (const auto& [code, bits] :
       {std::pair{1U, 8U}, {1U, 16U}, {1U, 24U}, {1U, 32U}, {3U, 32U}, {3U, 64U}}) {
    for (const bool extensible : {false, true}) {
      INFO("format " << code << ", " << bits << " bits, extensible " << extensible);
      const CsvTable t = parse_wav(wav(code, bits, extensible), "x");
      REQUIRE(t.header == std::vector<std::string>{"time [s]", "ch1 [V]", "ch2 [V]"});
      REQUIRE(t.rows() == 4);
      CHECK(t.columns[0][3] == Approx(3.0 / 400));
      CHECK(t.columns[1] == std::vector<double>{-1.0, 0.5, -1.0, 0.5});
      CHECK(t.columns[2] == std::vector<double>{0.25, 0.0, 0.25, 0.0});
    }
  }
}

TEST_CASE("what is wrong with a WAV file is said in a sentence", "[import][wav]") {
  const std::string good = wav(1, 16);
  CHECK_THAT(complaint(parse_wav, "time,pvdf_a\n"), Contains("x: is no WAV file"));
  CHECK_THAT(complaint(parse_wav, wav(6, 16)), Contains("format 6 with 16 bits; PCM (1)"));
  CHECK_THAT(complaint(parse_wav, good.substr(0, good.size() - 4)),
             Contains("ends 4 bytes before its data do"));
  CHECK_THAT(complaint(parse_wav, good.substr(0, 30)), Contains("it is cut or damaged"));
  Random random(3);
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes = wav(random.below(2) ? 1 : 3, 32, random.below(2) != 0);
    bytes[random.below(bytes.size())] = static_cast<char>(random.below(256));
    if (random.below(3) == 0) bytes.resize(random.below(bytes.size()));
    try {
      const CsvTable t = parse_wav(bytes, "x");
      for (const auto& column : t.columns) REQUIRE(column.size() == t.rows());
    } catch (const BadInput& e) {
      REQUIRE(e.errors().size() == 1);
    }
  }
}

TEST_CASE("LVM with its headers: labels, units, decimal commas, comments", "[import][lvm]") {
  const CsvTable t = parse_lvm(lvm, "x");
  CHECK(t.header == std::vector<std::string>{"time [s]", "Force [N]", "ch2 [V]"});
  REQUIRE(t.rows() == 3);
  CHECK(t.columns[0] == std::vector<double>{0.0, 0.001, 0.002});
  CHECK(t.columns[1] == std::vector<double>{1.5, 25.0, 3.0});
  CHECK(t.columns[2][0] == -2.0);
  CHECK(std::isnan(t.columns[2][1]));
  CHECK(t.line[0] == 15);
}

TEST_CASE("LVM without headers, and without times", "[import][lvm]") {
  const CsvTable bare = parse_lvm("0.000000\t-1.5\t2\n5E-6\t-1.25\t3\n", "x");
  CHECK(bare.header == std::vector<std::string>{"time [s]", "ch1 [V]", "ch2 [V]"});
  CHECK(bare.columns[0][1] == 5e-6);
  CHECK(bare.columns[2] == std::vector<double>{2, 3});
  const CsvTable no_times = parse_lvm(
      "LabVIEW "
      "Measurement\nX_Columns\tNo\n***End_of_Header***\nChannels\t1\nX0\t2\nDelta_X\t0.5\n***End_of_Header***"
      "\n"
      "X_Value\tA\n\t1\n\t2\n\t3\n",
      "x");
  CHECK(no_times.columns[0] == std::vector<double>{2, 2.5, 3});
  CHECK(no_times.columns[1] == std::vector<double>{1, 2, 3});
}

TEST_CASE("what is wrong with an LVM file is said with its line", "[import][lvm]") {
  CHECK_THAT(complaint(parse_lvm, "0\t1\n1\tx\n"), Contains("x:2: 'x' is no number"));
  CHECK_THAT(complaint(parse_lvm, "0\t1\n"), Contains("fewer than two rows"));
  CHECK_THAT(complaint(parse_lvm, lvm + "Channels\t1\n"), Contains("x:18: a second segment begins"));
  CHECK_THAT(complaint(parse_lvm, "LabVIEW Measurement\nX_Columns\tMulti\n"),
             Contains("x:2: X_Columns Multi"));
  CHECK_THAT(complaint(parse_lvm, "LabVIEW Measurement\nDelta_X\t0\n"),
             Contains("x:2: Delta_X 0; above 0 s"));
  CHECK_THAT(complaint(parse_lvm, "LabVIEW Measurement\nChannels\t1e300\n"), Contains("x:2: 1e300 channels"));
  Random random(5);
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes = lvm;
    bytes[random.below(bytes.size())] = static_cast<char>(random.below(256));
    if (random.below(3) == 0) bytes.resize(random.below(bytes.size()));
    try {
      const CsvTable t = parse_lvm(bytes, "x");
      for (const auto& column : t.columns) REQUIRE(column.size() == t.rows());
    } catch (const BadInput& e) {
      REQUIRE(e.errors().size() == 1);
    }
  }
}

TEST_CASE("a sound card's recording of the mains becomes a record", "[import][wav]") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "powbench_wav_import";
  std::filesystem::create_directories(folder);
  std::string body = "WAVEfmt ";
  put<std::uint32_t>(body, 16);
  for (const unsigned v : {1U, 1U}) put<std::uint16_t>(body, static_cast<std::uint16_t>(v));
  put<std::uint32_t>(body, 8000);
  put<std::uint32_t>(body, 16000);
  for (const unsigned v : {2U, 16U}) put<std::uint16_t>(body, static_cast<std::uint16_t>(v));
  body += "data";
  put<std::uint32_t>(body, 2 * 4000);
  for (int n = 0; n < 4000; ++n)
    put<std::uint16_t>(body, static_cast<std::uint16_t>(
                                 std::lround(16000 * std::sin(2 * 3.14159265358979 * 50 * n / 8000.0))));
  std::string out = "RIFF";
  put<std::uint32_t>(out, static_cast<std::uint32_t>(body.size()));
  std::ofstream(folder / "mains.wav", std::ios::binary) << out << body;
  std::ofstream(folder / "mains.toml") << "[columns]\ntime = \"time\"\nmains_voltage = \"ch1\"\n";
  const Imported in = import_file(folder / "mains.wav", std::nullopt);
  REQUIRE(in.record.channels.size() == 1);
  CHECK(in.record.sample_rate == Approx(8000.0));
  CHECK(in.record.channels[0].channel == Channel::mains_voltage);
  std::filesystem::remove_all(folder);
}
