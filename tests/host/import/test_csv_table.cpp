#include "host/config/csv_table.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "host/config/bad_input.h"
#include "host/import/column.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

/// What is said about a text that is refused; "" when it is taken.
std::string complaint(const std::string& text) {
  try {
    const CsvTable t = read_csv(text, "x.csv");
    read_header(t.header, "x.csv", t.header_line);
    return "";
  } catch (const BadInput& e) {
    return e.what();
  }
}

void check_plain(const std::string& text) {
  INFO(text);
  const CsvTable t = read_csv(text, "x.csv");
  REQUIRE(t.header == std::vector<std::string>{"time [s]", "pvdf_a [N]"});
  REQUIRE(t.rows() == 2);
  CHECK(t.columns[0] == std::vector<double>{-0.5, 0.25});
  CHECK(t.columns[1] == std::vector<double>{1e-3, -12.5});
}

}  // namespace

TEST_CASE("the dialects of instruments and spreadsheets are one table") {
  check_plain("time [s],pvdf_a [N]\n-0.5,1e-3\n0.25,-12.5\n");
  check_plain("time [s],pvdf_a [N]\r\n-0.5,1e-3\r\n0.25,-12.5");
  check_plain("time [s],pvdf_a [N]\r-0.5,1e-3\r0.25,-12.5\r");
  check_plain("\xEF\xBB\xBFtime [s],pvdf_a [N]\n-0.5,1e-3\n0.25,-12.5\n");
  check_plain("time [s];pvdf_a [N]\n-0,5;1e-3\n+0,25;-12,5\n");
  check_plain("time [s];pvdf_a [N];\n-.5;1E-03;\n.25;-12.5;\n");
  check_plain("time [s]\tpvdf_a [N]\n-0.5\t0,001\n0.25\t-12,5\n");
  check_plain("# scope\n\n time [s] , pvdf_a [N] \n# more\n -0.5 , 1e-3 \n\n0.25,-12.5\n");
  check_plain("\"time [s]\",\"pvdf_a [N]\"\n\"-0.5\",\"1e-3\"\n\"0.25\",\"-12.5\"\n");
}

TEST_CASE("cells without a number are lost samples, never numbers") {
  const CsvTable t = read_csv(
      "time [s],aux [V]\n0,\n1,nan\n2,NaN\n3,N/A\n4,-\n5,inf\n6,-9.91E+37\n7,1e999\n8,1e-999\n", "x");
  REQUIRE(t.rows() == 9);
  for (std::size_t i = 0; i < 8; ++i) CHECK(std::isnan(t.columns[1][i]));
  CHECK(t.columns[1][8] == 0.0);
  CHECK(t.over_range == 3);
  CHECK(t.line[0] == 2);
}

TEST_CASE("texts that cannot be meant are refused with file, line, value and what is allowed") {
  CHECK_THAT(complaint(""), Contains("x.csv:1") && Contains("empty") && Contains("time [s],pvdf_a [N]"));
  CHECK_THAT(complaint("\r\n\n# no\n"), Contains("empty"));
  CHECK_THAT(complaint("\xFF\xFEt\0i"), Contains("UTF-16"));
  CHECK_THAT(complaint(std::string("PK\3\4\0\0", 6)),
             Contains("binary") && Contains("save the sheet as CSV"));
  CHECK_THAT(complaint(std::string("a\0b", 3)), Contains("binary") && Contains("TDMS (.tdms)"));
  CHECK_THAT(complaint("time [s],aux [V]\n0,1\n\n1,x2\n"),
             Contains("x.csv:4") && Contains("'x2'") && Contains("aux [V]"));
  CHECK_THAT(complaint("time [s],aux [V]\n0,0,1,2\n"),
             Contains("x.csv:2") && Contains("4 cells") && Contains("semicolons"));
  CHECK_THAT(complaint("time [s];aux [V]\n0,0;1.234,5\n"), Contains("'1.234,5'"));
  CHECK_THAT(complaint("time [s],aux [V],laser [m]\n0,1\n"), Contains("2 cells; allowed 3"));
  CHECK_THAT(complaint("time [s],aux [V]\n0,0x10\n"), Contains("'0x10'"));
  CHECK_THAT(complaint("time [s],aux [V]\n0,\"1\n"), Contains("quote"));
  std::string many = "time [s],aux [V]\n";
  for (int i = 0; i < 1000; ++i) many += "a,b\n";
  const std::string said = complaint(many);
  CHECK(std::count(said.begin(), said.end(), '\n') < 10);  // enough to see the pattern
}

TEST_CASE("columns are known by name in any case, with their units") {
  const auto c = read_header(
      {"TIME [us]", "Pvdf_A [mN]", "laser [\xC2\xB5m]", "coil_current[mA]", "PVDF_B [mV]"}, "x", 1);
  CHECK_FALSE(c[0].channel);
  CHECK(c[0].factor == 1e-6);
  CHECK(c[1].channel == Channel::pvdf_a);
  CHECK(c[1].factor == 1e-3);
  CHECK(c[2].factor == 1e-6);
  CHECK(c[3].channel == Channel::coil_current);
  CHECK(c[4].kind == Kind::volts);
  CHECK_FALSE(c[4].calibrated);
}

TEST_CASE("unknown names and units that do not fit are refused with the nearest known ones") {
  CHECK_THAT(complaint("time [s],pvdv_a [N]\n"),
             Contains("'pvdv_a [N]'") && Contains("did you mean 'pvdf_a'?"));
  CHECK_THAT(complaint("time [s],CH1 [V]\n"), Contains("'CH1 [V]'") && Contains("mains_voltage"));
  CHECK_THAT(complaint("time,pvdf_a [N]\n"), Contains("`time [s]`") && Contains("s, ms, us"));
  CHECK_THAT(complaint("time [s],pvdf_a [MN]\n"), Contains("'MN'") && Contains("N, mN, V, mV"));
  CHECK_THAT(complaint("time [V],laser [A]\n"), Contains("'V'") && Contains("'A'") && Contains("mm"));
  CHECK_THAT(complaint("time [s],aux [V],AUX [mV]\n"), Contains("twice"));
  CHECK_THAT(complaint("time [s],time [ms],aux [V]\n"), Contains("2 time columns"));
  CHECK_THAT(complaint("aux [V],laser [m]\n"),
             Contains("0 time columns") && Contains("[columns] time = \"NAME [s]\""));
  CHECK_THAT(complaint("time [s]\n"), Contains("no channel"));
}
