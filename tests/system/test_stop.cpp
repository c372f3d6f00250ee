#include <catch2/catch.hpp>
#include <cstdlib>

#include "rigs/iiod_server.h"
#include "rigs/rig_watch.h"
#include "tests/system/program.h"
#include "tests/waiting.h"

using namespace powbench;
using namespace powbench::test;
using Catch::Contains;

TEST_CASE("powbench stop switches an armed rig off that somebody else owns", "[system]") {
  const rigs::LocalRig rig({}, {});
  const std::string uri = "ip:" + rig.address();
  const Folder folder;
  const auto attr = [&](const std::string& words) {
    return std::system(
        ("timeout 20 iio_attr -u " + uri + " -d contactor-ctl " + words + " > " + folder.file("said"))
            .c_str());
  };
  REQUIRE(attr("lease 'k7 60000 anna'") == 0);
  REQUIRE(attr("arm '1 k7'") == 0);
  rigs::RigWatch watch(uri, std::chrono::seconds(5));
  REQUIRE(watch.status().state == "armed");

  const Finished stopped = run(folder, {"stop", uri});
  INFO(stopped.out << stopped.err);
  CHECK(stopped.status == 0);
  CHECK_THAT(stopped.out, Contains("coil off, confirmed by the rig (its state: idle)"));
  CHECK_THAT(stopped.err, Contains("anna") && Contains("owns the rig"));
  CHECK(watch.status().state == "idle");

  const Finished again = run(folder, {"stop", uri, "--json"});
  CHECK(again.status == 0);
  CHECK_THAT(again.out, Contains("\"off\": true") && Contains("\"owner\": \"anna"));
}

TEST_CASE("only a state in which the coil is off confirms a stop") {
  for (const char* state : {"idle", "captured", "fault"}) CHECK(rigs::coil_off(state));
  for (const char* state : {"armed", "firing", "", "unknown", "Idle"}) CHECK_FALSE(rigs::coil_off(state));
}

TEST_CASE("powbench stop says loudly when nothing has confirmed", "[system]") {
  const Folder folder;
  const Finished nobody = run(folder, {"stop", "ip:127.0.0.254"});
  CHECK(nobody.status == 3);
  CHECK(nobody.out.empty());
  CHECK_THAT(nobody.err, Contains("NOT CONFIRMED, THE COIL MAY BE ON") && Contains("off by hand"));
  const Finished inside = run(folder, {"stop", "sim:"});
  CHECK(inside.status == 2);
  CHECK_THAT(inside.err, Contains("inside the program that uses it"));
}
