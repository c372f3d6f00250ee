#include <sys/wait.h>

#include <cstdio>

#include "tests/rigs/bridge_desk.h"

using namespace powbench::test;

/// Debian's own libiio tools, which have no serial backend, on a board behind a serial line.

namespace {

std::string run(const std::string& command) {
  std::string output;
  FILE* pipe = popen(("( timeout 20 " + command + " ) 2>&1").c_str(), "r");
  REQUIRE(pipe);
  char bytes[4096];
  while (const std::size_t n = std::fread(bytes, 1, sizeof bytes, pipe)) output.append(bytes, n);
  pclose(pipe);
  return output;
}

}  // namespace

TEST_CASE("iio_info, iio_attr and iio_readdev work through the bridge", "[bridge][tools]") {
  Desk desk;
  const std::string uri = " -u ip:" + desk.bridge.address() + " ";
  const std::string info = run("iio_info" + uri);
  for (const char* bad : {"WARN", "ERROR", "invalid", "Unable", "UNKNOWN"}) {
    INFO(bad << "\n" << info);
    CHECK(info.find(bad) == std::string::npos);
  }
  CHECK(info.find("contactor-daq (label: record) (buffer capable)") != std::string::npos);
  CHECK(info.find("boot_id: boot-1") != std::string::npos);
  CHECK(run("iio_attr" + uri + "-d contactor-ctl fire 1").find("(16)") != std::string::npos);
  run("iio_attr" + uri + "-d contactor-ctl lease 't 30000 anna'");
  CHECK(run("iio_attr" + uri + "-d contactor-ctl fire '1 t'").find("(11)") != std::string::npos);
  run("iio_attr" + uri + "-c contactor-ctl phase0 raw '9000 t'");
  CHECK(run("iio_attr" + uri + "-c contactor-ctl phase0 raw") == "9000\n");
  // no record yet: answered in time, not a broken pipe
  CHECK(run("iio_readdev" + uri + "-T 1000 -b 16 -s 16 contactor-daq voltage0 | wc -c").find("(110)") !=
        std::string::npos);
  desk.shoot();
  CHECK(run("iio_readdev" + uri + "-b 256 -s 512 contactor-daq voltage0 voltage1 | wc -c") == "2048\n");
  const std::string all = "iio_readdev" + uri + "-b 4000 -s 4000 contactor-daq";
  CHECK(run(all + " | wc -c") == "96000\n");
  // while one tool reads, another asks
  const std::string both = "sh -c '" + all + " | wc -c & iio_attr" + uri + "-d contactor-ctl state; wait'";
  const std::string answers = run(both);
  CHECK(answers.find("captured\n") != std::string::npos);
  CHECK(answers.find("96000\n") != std::string::npos);
}

TEST_CASE("an iio_readdev that is killed sets the device free", "[bridge][tools]") {
  Desk desk;
  desk.shoot();
  const std::string uri = " -u ip:" + desk.bridge.address() + " ";
  // stopped hard in the middle of the record, as by kill -9
  run("sh -c 'timeout -s KILL 0.15 iio_readdev" + uri + "-b 4000 -s 4000 contactor-daq >/dev/null'");
  CHECK(run("iio_readdev" + uri + "-b 100 -s 100 contactor-daq voltage0 | wc -c") == "200\n");
}
