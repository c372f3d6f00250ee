#include <catch2/catch.hpp>

#include "rigs/bridge/layout.h"
#include "rigs/bridge/reply.h"
#include "rigs/rig.h"
#include "rigs/serial_rig.h"

using namespace powbench::rigs;
using namespace powbench::rigs::bridge;
using Shape = Expected::Shape;

namespace {

/// The outcome for an answer that arrives in pieces of `step` bytes: "bad", "open" (more is owed), or status
/// and body.
std::string outcome(const Expected& expected, const std::string& answer, std::size_t step = 1) {
  ReplyReader reader(expected);
  std::size_t used = 0;
  for (std::size_t at = 0; at < answer.size() && !reader.done() && !reader.bad(); at += step)
    used += reader.feed(std::string_view(answer).substr(at, step));
  if (reader.bad()) return "bad";
  if (!reader.done()) return "open";
  return std::to_string(reader.reply().status) + " [" + reader.reply().body + "]" +
         (reader.reply().ended ? " ended" : "") + (used < answer.size() ? " and more" : "");
}

}  // namespace

TEST_CASE("answers end where they end, however they are cut", "[bridge]") {
  for (const std::size_t step : {1U, 2U, 3U, 100U}) {
    CHECK(outcome({Shape::number, 0, 0}, "0\n", step) == "0 []");
    CHECK(outcome({Shape::number, 4, 0}, "4\n", step) == "4 []");
    CHECK(outcome({Shape::number, 4, 0}, "-16\n", step) == "-16 []");
    CHECK(outcome({Shape::text, 0, 0}, "5\nid\nle\n", step) == "5 [id\nle]");
    CHECK(outcome({Shape::text, 0, 0}, "0\n\n", step) == "0 []");
    CHECK(outcome({Shape::optional_text, 0, 0}, "0\n", step) == "0 []");
    CHECK(outcome({Shape::optional_text, 0, 0}, "4\nfire\n", step) == "4 [fire]");
    CHECK(outcome({Shape::line, 0, 0}, "0.24.v0.24  \n", step) == "0 [0.24.v0.24  ]");
    CHECK(outcome({Shape::samples, 6, 3}, "6\n00000003\nabcdef", step) == "6 [abcdef]");
    CHECK(outcome({Shape::samples, 6, 3}, "4\n00000003\nabcd2\nef", step) == "2 [abcdef]");
    CHECK(outcome({Shape::samples, 6, 3}, "4\n00000003\nabcd0\n", step) == "0 [abcd] ended");
    CHECK(outcome({Shape::samples, 6, 3}, "4\n00000003\nabcd-11\n", step) == "-11 [abcd]");
    CHECK(outcome({Shape::samples, 6, 3}, "-11\n", step) == "-11 []");
    CHECK(outcome({Shape::samples, 6, 3}, "4\n00000003\nabcd", step) == "open");
  }
  CHECK(outcome({Shape::number, 0, 0}, "0\n0\n", 100) == "0 [] and more");
}

TEST_CASE("answers that cannot be are refused", "[bridge]") {
  CHECK(outcome({Shape::number, 0, 0}, "1\n") == "bad");
  CHECK(outcome({Shape::number, 4, 0}, "5\n") == "bad");
  CHECK(outcome({Shape::number, 0, 0}, "-1q\n") == "bad");
  CHECK(outcome({Shape::number, 0, 0}, "\n") == "bad");
  CHECK(outcome({Shape::number, 0, 0}, "-5000\n") == "bad");
  CHECK(outcome({Shape::text, 0, 0}, "3\nidle\n") == "bad");
  CHECK(outcome({Shape::text, 0, 0}, "99999999\n") == "bad");
  CHECK(outcome({Shape::samples, 6, 3}, "7\n") == "bad");
  CHECK(outcome({Shape::samples, 6, 3}, "6\n00000001\n") == "bad");
  CHECK(outcome({Shape::samples, 6, 3}, "4\n00000003\nabcd3\n") == "bad");
  CHECK(outcome({Shape::line, 0, 0}, std::string(100, 'x')) == "bad");
}

TEST_CASE("devices and scan sizes are read from a description", "[bridge]") {
  const std::string xml =
      "<!DOCTYPE context [<!ELEMENT device (channel)*><!ATTLIST device id CDATA #REQUIRED>]>"
      "<context name=\"a\"><context-attribute name=\"boot_id\" value=\"b 7\" />"
      "<device id=\"iio:device0\" name=\"daq\"><channel id=\"timestamp\" type=\"input\">"
      "<scan-element index=\"3\" format=\"le:S64/64&gt;&gt;0\" /></channel>"
      "<channel id=\"a\" type=\"input\"><scan-element index=\"0\" format=\"le:s12/16&gt;&gt;4\" /></channel>"
      "<channel id=\"b\" type=\"input\"><scan-element index=\"1\" format=\"le:S16/16X2>>0\" "
      "/></channel></device>"
      "<device id=\"iio:device1\" name=\"ctl\"><attribute name=\"state\" /></device>"
      "<device id=\"trigger0\" name=\"fire\" /></context>";
  const auto devices = read_devices(xml);
  REQUIRE(devices.size() == 3);
  CHECK(devices[0].id == "iio:device0");
  CHECK(devices[0].name == "daq");
  CHECK(devices[0].widths == std::vector<std::size_t>{2, 4, 8});
  CHECK(devices[0].scan_bytes(1) == 2);
  CHECK(devices[0].scan_bytes(3) == 8);  // the second starts at a multiple of its size
  CHECK(devices[0].scan_bytes(5) == 16);
  CHECK(devices[0].scan_bytes(0) == 0);
  CHECK(devices[0].scan_bytes(8) == 0);
  CHECK_FALSE(devices[1].buffered());
  CHECK(devices[2].name == "fire");
  CHECK(context_attribute(xml, "boot_id") == "b 7");
  CHECK(context_attribute(xml, "hw_model").empty());
}

TEST_CASE("a serial URI is a port and perhaps a rate", "[bridge]") {
  CHECK(serial_options("serial:/dev/ttyACM0,921600").port == "/dev/ttyACM0");
  CHECK(serial_options("serial:/dev/ttyACM0,921600").baud == 921600);
  CHECK(serial_options("serial:/dev/ttyACM0").baud == 2'000'000);
  for (const char* bad : {"serial:", "serial:,9600", "serial:/dev/x,", "serial:/dev/x,fast",
                          "serial:/dev/x,9600,8n1", "serial:/dev/x,300"})
    CHECK_THROWS_AS(serial_options(bad), RigError);
  CHECK_THROWS_WITH(connect_serial("serial:/dev/no-such-port,115200"),
                    Catch::Contains("cannot open serial port"));
}
