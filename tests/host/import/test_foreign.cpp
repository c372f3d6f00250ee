#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "bench/records/foreign_samples.h"
#include "host/config/bad_input.h"
#include "host/import/dcc.h"
#include "host/import/foreign_table.h"
#include "host/import/scope_csv.h"
#include "host/import/waveform.h"
#include "host/import/wvf.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Matchers::Contains;

namespace {

CsvTable read(const Foreign& f) {
  return f.header.empty() ? parse_table(f.bytes, f.file) : parse_wvf(f.header, f.bytes, "x.hdr", "x.wvf");
}

std::string message(const std::string& text, const std::string& file = "x.csv") {
  try {
    parse_table(text, file);
  } catch (const BadInput& e) {
    return e.what();
  }
  return "read";
}

void check(const Foreign& f, const Waves& w) {
  INFO(f.name);
  CsvTable t;
  REQUIRE_NOTHROW(t = read(f));
  REQUIRE(t.header.size() == static_cast<std::size_t>(1 + f.channels));
  REQUIRE(t.rows() == w.ch1.size());
  const double unit = t.header[0].ends_with("[ms]") ? 1e-3 : t.header[0].ends_with("[us]") ? 1e-6 : 1.0;
  double worst = 0, ch1 = 0, ch2 = 0;
  for (std::size_t i = 0; i < t.rows(); ++i) {
    worst = std::max(worst, std::abs(t.columns[0][i] * unit - (w.start + w.step * static_cast<double>(i))));
    ch1 = std::max(ch1, std::abs(t.columns[1][i] - w.ch1[i]));
    const double milli = f.channels == 2 && t.header[2].ends_with("[mV]") ? 1e-3 : 1.0;
    if (f.channels == 2) ch2 = std::max(ch2, std::abs(t.columns[2][i] * milli - w.ch2[i]));
  }
  CHECK(worst < 1e-12);
  CHECK(ch1 == 0.0);
  CHECK(ch2 < 1e-15);
}

}  // namespace

TEST_CASE("files of oscilloscopes are read as they come", "[import][foreign]") {
  const Waves w = waves(1, 600);
  for (const Foreign& f : scope_texts(w)) {
    INFO(f.name);
    CHECK(is_scope_csv(f.bytes));
    check(f, w);
  }
}

TEST_CASE("TDMS, MAT 5 and Yokogawa in their variants hold the same numbers", "[import][foreign]") {
  const Waves w = waves(2, 600);
  for (const Foreign& f : binary_files(w)) check(f, w);
}

TEST_CASE("WAV with floats and LVM hold the same numbers", "[import][foreign]") {
  Waves w = waves(3, 600);
  w.start = 0;  // where a WAV begins
  for (const Foreign& f : logger_files(w)) check(f, w);
}

TEST_CASE("a scope's file becomes a record by [columns] and gains", "[import][foreign]") {
  const Waves w = waves(3, 3000);
  for (const Foreign& f : scope_texts(w)) {
    INFO(f.name);
    const CsvTable t = read(f);
    const std::string name = t.header[1].substr(0, t.header[1].find(" ["));
    const Calibration k =
        parse_calibration("[columns]\npvdf_a = \"" + name + "\"\n[pvdf_a]\ngain_N_per_V = 2.0\n", "k.toml");
    const Imported in = import_waveform(f.bytes, "x.csv", k, "k.toml", "2026-05-04");
    REQUIRE(in.record.channels.size() == 1);
    CHECK(in.record.sample_rate == 1e5);
    CHECK(in.record.time(0) == Approx(w.start).margin(1e-9));
    double worst = 0;
    for (std::size_t i = 0; i < w.ch1.size(); ++i)
      worst = std::max(worst, std::abs(in.record.channels[0].value(i) - 2 * w.ch1[i]));
    CHECK(worst < 1e-9);
  }
  // named as the file shows it
  const Calibration shown =
      parse_calibration("[columns]\npvdf_a = \"CH1(V)\"\n[pvdf_a]\ngain_N_per_V = 2.0\n", "k.toml");
  CHECK_NOTHROW(import_waveform(scope_texts(w)[6].bytes, "x.csv", shown, "k.toml", "2026-05-04"));
}

TEST_CASE("a clock beside the names may have decimal commas where the numbers have them",
          "[import][foreign]") {
  const Calibration k = parse_calibration("[columns]\npvdf_a = \"CH1 [N]\"\n", "k.toml");
  for (const char* clock : {"-3,999415e-02;1,000000e-05", "-0,03999415;0,00001", "-0.03999415;1e-05"}) {
    std::string text = std::string("X;CH1;CH2;Start;Increment\nSequence;Volt;Volt;") + clock + "\n";
    for (int i = 0; i < 20; ++i) text += fmt::format("{};{},5;1\n", i, i % 7);
    const Imported in = import_waveform(text, "x.csv", k, "k.toml", "2026-05-04");
    CHECK(in.record.sample_rate == Approx(1e5));
    CHECK(in.record.time(0) == Approx(-0.03999415).margin(1e-9));
  }
}

TEST_CASE("one column for two channels is told so", "[import][foreign]") {
  const std::string toml = "[columns]\npvdf_a = \"CH1 [N]\"\npvdf_b = \"CH1 [N]\"\n";
  std::string text = "time [s],CH1 [N]\n";
  for (int i = 0; i < 20; ++i) text += fmt::format("{}e-5,{}\n", i, i % 7);
  try {
    import_waveform(text, "x.csv", parse_calibration(toml, "k.toml"), "k.toml", "2026-05-04");
    FAIL("imported");
  } catch (const BadInput& e) {
    CHECK_THAT(e.what(),
               Contains("[columns] pvdf_b = \"CH1 [N]\": that column is pvdf_a already; allowed once"));
  }
}

TEST_CASE("a preamble that cannot be read is named as such", "[import][foreign]") {
  const std::string numbers = "0,1,2\n1e-5,1,2\n2e-5,1,2\n3e-5,1,2\n";
  CHECK_THAT(message("Model,X\nFirmware,1\n\n" + numbers),
             Contains("x.csv:1-2: the preamble is not understood: line 2 has 2 names for 3 columns"));
  CHECK_THAT(message("Model,X\nA,B,C\nD,E,F\n" + numbers), Contains("no column is the time"));
  CHECK_THAT(message("Model,X\n1,2,3x\nTIME,CH1\n" + numbers), Contains("the preamble is not understood"));
  CHECK_THAT(message("X,CH1,CH2\nSequence,Volt,Volt\n" + numbers), Contains("no Start and Increment"));
  CHECK_THAT(message("Model,X\nTIME,,CH2\n" + numbers), Contains("the name of column 2 is empty"));
  CHECK_THAT(message("LECROYX,1,Waveform\nSegments,3,SegmentSize,4\nTime,Ampl\n0,1\n1e-5,2\n2e-5,3\n"),
             Contains("3 segments; allowed one"));
  CHECK_THAT(message("LECROYX,1,Waveform\nSegments,1,SegmentSize,4000\nTime,Ampl\n0,1\n1e-5,2\n2e-5,3\n"),
             Contains("states 4000 samples, the file has 3: it is cut"));
  CHECK_THAT(message("Model,X\nTIME,CH1,CH2\n" + numbers + "4e-5,1\n"),
             Contains("x.csv:7: the line has 2 cells; allowed 3"));
  CHECK_THAT(message("Model,X\nTIME,CH1,CH2\n" + numbers + "4e-5,1,bad\n"),
             Contains("x.csv:7: column 'CH2' = 'bad': is no number"));
  CHECK_THAT(message("Model,X\nonly\nwords\n"), Contains("no three lines in a row"));
}

TEST_CASE("a plain CSV is not taken for a scope's", "[import][foreign]") {
  CHECK_FALSE(is_scope_csv("time [s],pvdf_a [N]\n0,1\n"));
  CHECK_FALSE(is_scope_csv("TIME,CH1\n0,1\n1,2\n2,3\n"));
  CHECK_FALSE(is_scope_csv("time,pvdf_a\nx,y\n0,1\n1,2\n2,3\n"));
  CHECK_FALSE(is_scope_csv(""));
  CHECK_FALSE(is_scope_csv("0,1\n1,2\n2,3\n3,4\n"));
}

namespace {
std::string dcc(const std::string& value, const std::string& unit, const std::string& more = "") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<dcc:digitalCalibrationCertificate "
         "xmlns:dcc=\"https://ptb.de/dcc\" "
         "xmlns:si=\"https://ptb.de/si\"><dcc:administrativeData><dcc:coreData><dcc:uniqueIdentifier>K "
         "17-26</dcc:uniqueIdentifier>"
         "<dcc:endPerformanceDate>2026-03-02</dcc:endPerformanceDate></dcc:coreData></"
         "dcc:administrativeData><dcc:measurementResults>"
         "<dcc:measurementResult><dcc:results><dcc:result><dcc:data><dcc:quantity><dcc:name><dcc:content "
         "lang=\"en\">gain</dcc:content></dcc:name>"
         "<si:real><si:value>" +
         value + "</si:value><si:unit>" + unit + "</si:unit>" + more +
         "</si:real></dcc:quantity></dcc:data></dcc:result>"
         "</dcc:results></dcc:measurementResult></dcc:measurementResults></"
         "dcc:digitalCalibrationCertificate>";
}
CertifiedGain gain(const std::string& xml, std::string_view unit = "N") {
  return gain_of(parse_dcc(xml, "k.xml"), unit, "k.xml");
}
}  // namespace

TEST_CASE("a calibration certificate gives identifier, gain and uncertainty", "[import][dcc]") {
  const Certificate c = parse_dcc(dcc("10.02", "\\newton\\per\\volt"), "k.xml");
  CHECK(c.id == "K 17-26");
  CHECK(c.performed == "2026-03-02");
  REQUIRE(c.quantities.size() == 1);
  CHECK(c.quantities[0].name == "gain");
  CHECK(gain(dcc("10.02", "\\newton\\per\\volt")).gain == 10.02);
  const std::string v2 =
      "<si:expandedUnc><si:uncertainty>0.5</si:uncertainty><si:coverageFactor>2</si:coverageFactor></"
      "si:expandedUnc>";
  const std::string v3 =
      "<si:measurementUncertaintyUnivariate><si:expandedMU><si:valueExpandedMU>0.5</si:valueExpandedMU>"
      "<si:coverageFactor>2</si:coverageFactor></si:expandedMU></si:measurementUncertaintyUnivariate>";
  for (const std::string& u : {v2, v3}) {
    const CertifiedGain g = gain(dcc("50", "\\milli\\volt\\per\\newton", u));
    CHECK(g.gain == Approx(20.0));  // 1 / 0.05 V/N
    CHECK(g.expanded == Approx(0.5e-3 / (0.05 * 0.05)));
    CHECK(g.coverage == 2);
  }
  CHECK(gain(dcc("2", "\\milli\\metre\\per\\volt"), "m").gain == Approx(2e-3));
  CHECK_THROWS_WITH(gain(dcc("1", "\\pico\\coulomb\\per\\newton")),
                    Contains("has no quantity in N per volt"));
  CHECK_THROWS_WITH(gain(dcc("0", "\\newton\\per\\volt")), Contains("has no quantity"));
  CHECK_THROWS_WITH(parse_dcc("<a>", "k.xml"), Contains("k.xml: is no XML"));
  CHECK_THROWS_WITH(parse_dcc("<a/>", "k.xml"), Contains("is no digital calibration certificate"));
  std::string two = dcc("1", "\\newton\\per\\volt");
  const std::size_t at = two.find("<si:real>"), end = two.find("</si:real>") + 10;
  two.insert(end, two.substr(at, end - at));
  CHECK_THROWS_WITH(gain(two), Contains("has 2 quantities"));
}
