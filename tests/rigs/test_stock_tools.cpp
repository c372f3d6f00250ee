#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <string>

#include "rigs/iiod_server.h"

using namespace powbench::rigs;

/// Debian's own libiio tools against the simulated rig: they must work, and must not complain.

namespace {

struct Result {
  int status = -1;
  std::string output;  ///< stdout and stderr together
};

Result run(const std::string& command) {
  Result r;
  FILE* pipe = popen(("( " + command + " ) 2>&1").c_str(), "r");
  REQUIRE(pipe);
  char bytes[4096];
  while (const std::size_t n = std::fread(bytes, 1, sizeof bytes, pipe)) r.output.append(bytes, n);
  const int status = pclose(pipe);
  r.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return r;
}

struct Fixture {
  LocalRig rig{{}, {}};
  std::string uri = " -u ip:" + rig.address() + " ";

  Result attr(const std::string& arguments) const { return run("timeout 20 iio_attr" + uri + arguments); }
  void shoot(int centi_degrees) const {
    REQUIRE(attr("-d contactor-ctl lease 'k7 30000 anna'").status == 0);
    REQUIRE(attr("-c contactor-ctl phase0 raw '" + std::to_string(centi_degrees) + " k7'").status == 0);
    REQUIRE(attr("-d contactor-ctl arm '1 k7'").status == 0);
    REQUIRE(attr("-d contactor-ctl fire '1 k7'").status == 0);
    for (int i = 0; i < 200 && attr("-d contactor-ctl state").output != "captured\n"; ++i) {
    }
    REQUIRE(attr("-d contactor-ctl state").output == "captured\n");
  }
};

}  // namespace

TEST_CASE("iio_info lists the rig without a warning", "[tools]") {
  Fixture f;
  const Result r = run("timeout 20 iio_info" + f.uri);
  CHECK(r.status == 0);
  for (const char* bad : {"WARN", "ERROR", "invalid", "Unable", "UNKNOWN"}) {
    INFO(bad << "\n" << r.output);
    CHECK(r.output.find(bad) == std::string::npos);
  }
  CHECK(r.output.find("contactor-daq (label: record) (buffer capable)") != std::string::npos);
  CHECK(r.output.find("attr  4: label value: pvdf_a") != std::string::npos);
  CHECK(r.output.find("No trigger on this device") != std::string::npos);
}

TEST_CASE("iio_attr drives a shot and iio_readdev reads it", "[tools]") {
  Fixture f;
  f.shoot(9000);
  CHECK(run("timeout 20 iio_readdev" + f.uri + "-b 256 -s 512 contactor-daq voltage0 voltage1 | wc -c")
            .output == "2048\n");
  CHECK(run("timeout 20 iio_readdev" + f.uri + "-b 1000 -s 14000 contactor-daq | wc -c").output ==
        "336000\n");
  const std::string one =
      "timeout 20 iio_readdev" + f.uri + "-b 700 -s 14000 contactor-daq voltage0 | md5sum";
  CHECK(run(one).output == run(one).output);
  CHECK(run("timeout 20 iio_readdev" + f.uri +
            "-t fire -b 256 -s 256 contactor-daq voltage0 2>/dev/null | wc -c")
            .output == "512\n");
}

TEST_CASE("errors reach the tools as Linux error numbers", "[tools]") {
  Fixture f;
  const Result stranger = f.attr("-d contactor-ctl fire 1");
  CHECK(stranger.output.find("(16)") != std::string::npos);
  CHECK(f.attr("-d contactor-ctl last_error").output.find("claim the bench first") != std::string::npos);
  REQUIRE(f.attr("-d contactor-ctl lease 'k7 30000 anna'").status == 0);
  const Result early = f.attr("-d contactor-ctl fire '1 k7'");
  CHECK(early.output.find("(11)") != std::string::npos);
  const Result range = f.attr("-c contactor-ctl phase0 raw '36000 k7'");
  CHECK(range.output.find("(34)") != std::string::npos);
  CHECK(f.attr("-d contactor-ctl last_error").output.find("0 .. 35999") != std::string::npos);
  // no record yet: answered in time, not a broken pipe
  const Result none =
      run("timeout 20 iio_readdev" + f.uri + "-T 400 -b 16 -s 16 contactor-daq voltage0 | wc -c");
  CHECK(none.output.find("(110)") != std::string::npos);
}

TEST_CASE("python3-libiio reads what the tools read", "[tools]") {
  Fixture f;
  f.shoot(0);
  const std::string script =
      "import iio\\n"
      "c = iio.Context('ip:" +
      f.rig.address() +
      "')\\n"
      "d = c.find_device('contactor-daq')\\n"
      "v = d.find_channel('voltage0'); v.enabled = True\\n"
      "b = iio.Buffer(d, 14000); b.refill()\\n"
      "x = memoryview(b.read()).cast('h')\\n"
      "print(len(x), max(abs(k) for k in x[:3990]) < 100, max(x) > 15000)\\n"
      "print(c.find_device('contactor-ctl').attrs['state'].value, len(c.devices))\\n";
  const Result r = run("printf \"" + script + "\" | timeout 30 /usr/bin/python3 -W error -");
  CHECK(r.output == "14000 True True\ncaptured 4\n");
}
