#include <catch2/catch.hpp>
#include <cmath>

#include "core/units.h"
#include "host/export/xml_text.h"
#include "host/paper/published.h"
#include "host/report/markup.h"
#include "host/report/number.h"
#include "tests/host/report_xml_check.h"

using namespace powbench;
using namespace powbench::host;
using test::xml_error;

TEST_CASE("a style sheet keeps its quotes, and nothing can break out of it", "[report]") {
  Markup m;
  m.verbatim("style", "p { font-family: \"Source Sans 3\"; }");
  CHECK(m.str() == "<style>p { font-family: \"Source Sans 3\"; }</style>\n");
  CHECK_THROWS_AS(m.verbatim("style", "</style>"), std::invalid_argument);
}

TEST_CASE("the checker itself finds what is broken", "[report]") {
  CHECK(xml_error("<!DOCTYPE html>\n<a b=\"1\"><c/>x &lt; y</a>").empty());
  CHECK_FALSE(xml_error("<a><b></a></b>").empty());
  CHECK_FALSE(xml_error("<a>").empty());
  CHECK_FALSE(xml_error("<a>x & y</a>").empty());
  CHECK_FALSE(xml_error("<a>x < y</a>").empty());
  CHECK_FALSE(xml_error("<a b=\"<\"></a>").empty());
  CHECK_FALSE(xml_error("<a b=1></a>").empty());
}

TEST_CASE("text and attributes are escaped", "[report]") {
  CHECK(escaped("<script>alert('x') && \"y\"</script>") ==
        "&lt;script&gt;alert(&#39;x&#39;) &amp;&amp; &quot;y&quot;&lt;/script&gt;");
  CHECK(escaped("&lt;") == "&amp;lt;");
  Markup m;
  m.open("p", {{"title", "\"><script>"}}).text("</p><b>").close();
  CHECK(m.str() == "<p title=\"&quot;&gt;&lt;script&gt;\">&lt;/p&gt;&lt;b&gt;</p>\n");
  CHECK(xml_error(m.str()).empty());
}

TEST_CASE("what XML forbids becomes the replacement character", "[report]") {
  const std::string mark = "\xEF\xBF\xBD";
  CHECK(escaped(std::string_view("a\0b", 3)) == "a" + mark + "b");
  CHECK(escaped("\x1b[31m") == mark + "[31m");
  CHECK(escaped("\t\n\r") == "\t\n\r");
  CHECK(escaped("\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x94\x8C") == "\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x94\x8C");
  CHECK(escaped("\xFF") == mark);
  CHECK(escaped("\xC3") == mark);             // cut off
  CHECK(escaped("\xC0\xAF") == mark + mark);  // over-long form of /
  CHECK(escaped("\xED\xA0\x80") == mark);     // half of a surrogate pair
  CHECK(escaped("\xEF\xBF\xBF") == mark);     // not a character
}

TEST_CASE("elements nest and close in order", "[report]") {
  Markup inner;
  inner.empty("br");
  Markup m;
  m.open("div").element("span", "x").embed(inner);
  CHECK_FALSE(m.finished());
  m.close();
  CHECK(m.finished());
  CHECK(m.str() == "<div><span>x</span><br/></div>\n");
}

TEST_CASE("numbers: dash for unknown, true minus, no negative zero", "[report]") {
  const std::string dash(no_value), minus = "\xE2\x88\x92";
  CHECK(fixed(unknown, 2) == dash);
  CHECK(fixed(HUGE_VAL, 2) == dash);
  CHECK(fixed(-1.005, 2) == minus + "1.00");  // 1.005 lies just below in binary
  CHECK(fixed(-0.004, 2) == "0.00");
  CHECK(signed_fixed(0.25, 1) == "+0.2");
  CHECK(signed_fixed(0.001, 1) == "0.0");
  CHECK(signed_fixed(unknown, 1) == dash);
}

TEST_CASE("a value is rounded to two digits of its uncertainty", "[report]") {
  const std::string pm = " \xC2\xB1 ";
  CHECK(with_uncertainty({11.8423e-3, 6.1e-6}, 2, 1e3, 2) == "11.842" + pm + "0.012");
  CHECK(with_uncertainty({81.6, 1.95}, 2, 1, 1) == "81.6" + pm + "3.9");
  CHECK(with_uncertainty({1120, 40}, 2, 1, 1) == "1120" + pm + "80");
  CHECK(with_uncertainty({11.8423e-3, unknown}, 2, 1e3, 2) == "11.84");
  CHECK(with_uncertainty({unknown, 1}, 2, 1e3, 2) == std::string(no_value));
  CHECK(decimals_for(1e-9, 2) == 4);
  CHECK(decimals_for(0, 2) == 2);
}

TEST_CASE("angles and flags in words", "[report]") {
  CHECK(angle_text(radians(30)) == "30\xC2\xB0");
  CHECK(angle_text(radians(72.5)) == "72.5\xC2\xB0");
  CHECK(angle_text(radians(0)) == "0\xC2\xB0");
  CHECK(angle_text(radians(100)) == "100\xC2\xB0");
  CHECK(angle_text(unknown) == std::string(no_value));
  CHECK(flags_text(flag_none).empty());
  CHECK(flags_text(flag_clipped | flag_angle_off) == "clipped, angle off");
}
