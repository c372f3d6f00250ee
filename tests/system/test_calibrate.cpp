#include <catch2/catch.hpp>

#include <deque>

#include "host/cli/calibrate.h"
#include "host/config/bad_input.h"
#include "host/gather/begin.h"
#include "rigs/iio_rig.h"
#include "rigs/registry.h"
#include "tests/system/program.h"

/// The walk through a calibration against the simulated rig, whose inputs are off by what its file says.

using namespace powbench;
using namespace powbench::host;

namespace {

/// Answers one after the other.
Ask say(std::deque<std::string> answers) {
  auto left = std::make_shared<std::deque<std::string>>(std::move(answers));
  return [left](const std::string&) -> std::optional<std::string> {
    if (left->empty()) return std::nullopt;
    std::string next = left->front();
    left->pop_front();
    return next;
  };
}

/// Stores a certificate on the rig as `powbench calibrate` does, its rows unchanged.
void certify(const std::string& uri, const std::string& id, std::uint32_t expires) {
  rigs::IioLink link(uri, rigs::connect_limit, rigs::request_limit);
  link.write(rigs::IioLink::Device::control, "lease", "t 60000 test");
  store(link, "t", Walk{.rows = rows_of(link), .switch_delay = 0.0, .report = {}}, id, 20200101, expires);
  link.write(rigs::IioLink::Device::control, "lease", "t 0");
}

/// `powbench calibrate` with `answers` typed in; its exit code, what it said, and the certificate.
test::Finished calibrate_with(const test::Folder& folder, const std::string& uri, const std::string& id,
                              const std::string& expires, const std::string& answers,
                              const std::string& certificate) {
  const std::string said = folder.file("said.txt");
  const int status = std::system(("'" + test::program() + "' calibrate '" + uri + "' --id " + id +
                                  " --date 2026-01-01 --expires " + expires + " -o '" + certificate +
                                  "' < '" + folder.write("answers.txt", answers) + "' 2> '" + said + "'")
                                     .c_str());
  return {WEXITSTATUS(status), "", test::read_file(said)};
}

}  // namespace

TEST_CASE("two points make gain and zero, and points that cannot are refused", "[calibration]") {
  const Line line = line_through(-1.0, {-9975.0, 0.0}, 1.0, {10025.0, 0.0});
  CHECK(line.si_per_count == Approx(1e-4));
  CHECK(line.zero == Approx(25.0));
  CHECK_THROWS_AS(line_through(0.0, {0.0, 0.0}, 1.0, {1999.0, 0.0}), BadInput);
  CHECK_THROWS_AS(line_through(0.0, {5000.0, 0.0}, 1.0, {0.0, 0.0}), BadInput);
}

TEST_CASE("a calibration finds what is off, is stored, and stands in the next shot", "[calibration]") {
  rigs::SimRigConfig sim;
  const auto set = [&](Channel c, double gain, double zero) {
    sim.front_end.gain[index(c)] = gain;
    sim.front_end.zero[index(c)] = zero;
  };
  set(Channel::coil_current, 0.03, 25.0);
  set(Channel::mains_voltage, -0.02, -60.0);
  const rigs::Endpoint end = rigs::endpoint("sim:", sim, {});
  rigs::IioLink link(end.uri, rigs::connect_limit, rigs::request_limit);
  const firmware::Calibrations nominal = rows_of(link);
  link.write(rigs::IioLink::Device::control, "lease", "t 60000 test");
  // films, laser, current, coil voltage, mains, contact, aux, switch
  const Walk w = walk(link, "t", say({"", "", "", "-1.5", "1.5", "", "-300", "300", "", "", "20"}));
  const auto gain = [&](Channel c) {
    return static_cast<double>(w.rows[index(c)].scale_pico) /
           static_cast<double>(nominal[index(c)].scale_pico);
  };
  // 64 readings with 5 counts of noise on 50,000 and 30,000: 2e-5 of the gain, 0.6 counts of the zero
  CHECK(gain(Channel::coil_current) == Approx(1.0 / 1.03).margin(1e-4));
  CHECK(gain(Channel::mains_voltage) == Approx(1.0 / 0.98).margin(2e-4));
  CHECK(gain(Channel::laser) == 1.0);
  CHECK(std::abs(w.rows[index(Channel::coil_current)].zero_counts - 25) <= 3);
  CHECK(std::abs(w.rows[index(Channel::mains_voltage)].zero_counts + 60) <= 4);
  CHECK(w.switch_delay == Approx(20e-6));
  CHECK(w.report.find("[coil_current]") != std::string::npos);

  store(link, "t", w, "PB-9", 20300101, 20310101);
  CHECK(link.read(rigs::IioLink::Device::daq, "calibration_expires") == "20310101");
  CHECK(link.read(rigs::IioLink::Device::control, "fault") == "0 none");
  CHECK(firmware::rows_crc32(rows_of(link)) == firmware::rows_crc32(w.rows));
  link.write(rigs::IioLink::Device::control, "lease", "t 0");

  const auto rig = rigs::connect_iio(end.uri);
  Conditions c;
  c.hold_time = 0.05;
  const rigs::Shot shot = rig->fire(c, std::chrono::seconds(20));
  REQUIRE(shot.outcome == Outcome::pass);
  CHECK(shot.record.calibration == "PB-9");
  CHECK(shot.record.sealed.find(" calibration=PB-9 ") != std::string::npos);
  // the amplitude of the mains comes out right, though its input is off by 2 % and 60 counts
  const ChannelRecord* mains = nullptr;
  for (const ChannelRecord& r : shot.record.channels)
    if (r.channel == Channel::mains_voltage) mains = &r;
  REQUIRE(mains);
  double most = 0.0, least = 0.0;
  for (const std::int16_t n : mains->raw) {
    most = std::max(most, (n + mains->offset) * mains->scale);
    least = std::min(least, (n + mains->offset) * mains->scale);
  }
  CHECK(most == Approx(325.27).margin(1.5));
  CHECK(least == Approx(-325.27).margin(1.5));
}

TEST_CASE("a rig whose calibration has expired: said by run, on page 1, and once", "[calibration]") {
  const rigs::Endpoint end = rigs::endpoint("sim:", {}, {});
  certify(end.uri, "PB-9", 20210101);
  const test::Folder folder;
  const std::string plan = folder.write("plan.toml", "angles_deg = [0, 90]\nrepeats = 1\n"),
                    db = folder.file("lab.db");
  for (const bool again : {false, true}) {
    std::vector<std::string> words{"run", plan, "--rig", end.uri, "--db", db, "--progress", "none"};
    if (again) words.emplace_back("--resume");
    const test::Finished run = test::run(folder, words);
    CHECK(run.status == 0);
    CHECK((run.err.find("PB-9 was valid until 2021-01-01") != std::string::npos) == !again);
  }
  REQUIRE(test::run(folder, {"report", "--db", db, "-o", folder.file("out")}).status == 0);
  const std::string page = test::read_file(folder.file("out/report.html"));
  CHECK(
      page.find("Calibration expired: simulated contactor bench SIM-0001, certificate PB-9, was valid until "
                "2021-01-01") != std::string::npos);
  CHECK(page.find("certificate PB-9, was valid") == page.rfind("certificate PB-9, was valid"));
}

TEST_CASE("a campaign that goes on under another certificate names both, and an expired one is said",
          "[calibration]") {
  const rigs::Endpoint end = rigs::endpoint("sim:", {}, {});
  const test::Folder folder;
  const std::string plan = folder.write("plan.toml", "angles_deg = [0, 90]\nrepeats = 1\n"),
                    db = folder.file("lab.db");
  certify(end.uri, "LAB-1", 20991231);
  {
    Store lab(db);
    const Scene scene = load_scene(plan);
    const auto rig = rigs::connect_iio(end.uri);
    const std::int64_t id =
        begin_campaign(lab, scene, end.uri, rig->info(), false, [](const std::string&) {});
    Progress silent("", 1, Progress::Style::none);
    run_campaign(lab, id, std::span(scene.shots).first(1), *rig, run_options(scene.plan), silent);
  }
  certify(end.uri, "LAB-2", 20210101);
  const test::Finished resumed =
      test::run(folder, {"run", plan, "--rig", end.uri, "--db", db, "--progress", "none", "--resume"});
  CHECK(resumed.status == 0);
  CHECK_THAT(resumed.err, Catch::Contains("LAB-2 was valid until 2021-01-01"));
  REQUIRE(test::run(folder, {"report", "--db", db, "-o", folder.file("out")}).status == 0);
  const std::string page = test::read_file(folder.file("out/report.html"));
  CHECK_THAT(page, Catch::Contains("<dd>LAB-1 (shot 1), LAB-2 (shot 2)</dd>") &&
                       Catch::Contains("SIM-0001, certificate LAB-1, valid until 2099-12-31") &&
                       Catch::Contains("Calibration expired: simulated contactor bench SIM-0001, certificate "
                                       "LAB-2, was valid until 2021-01-01"));
  CHECK_THAT(test::read_file(folder.file("out/junit.xml")),
             Catch::Contains("\"LAB-1 (shot 1), LAB-2 (shot 2)\"") &&
                 Catch::Contains("<skipped message=\"expired: simulated contactor bench SIM-0001, "
                                 "certificate LAB-2, was valid until 2021-01-01\""));
}

TEST_CASE("a calibration in which nothing was measured is refused, and stores nothing", "[calibration]") {
  const rigs::Endpoint end = rigs::endpoint("sim:", {}, {});
  const test::Folder folder;
  certify(end.uri, "LAB-0", 20270101);
  const std::string certificate = folder.file("c.toml");
  // films, laser, current, coil voltage, mains, contact, aux; the switch alone is answered
  const test::Finished refused =
      calibrate_with(folder, end.uri, "LAB-1", "2031-01-01", "\n\n\n\n\n\n\n\n20\n", certificate);
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Catch::Contains("no channel was calibrated: nothing was stored") &&
                              !Catch::Contains("is in force"));
  CHECK_FALSE(std::filesystem::exists(certificate));
  rigs::IioLink link(end.uri, rigs::connect_limit, rigs::request_limit);
  CHECK(link.read_info(end.uri).calibration == "LAB-0");
}

TEST_CASE("channels that a calibration leaves as they are stand in its certificate with their own validity",
          "[calibration]") {
  const rigs::Endpoint end = rigs::endpoint("sim:", {}, {});
  const test::Folder folder;
  const std::string certificate = folder.file("c.toml");
  const auto in_force = [&] {
    return rigs::IioLink(end.uri, rigs::connect_limit, rigs::request_limit).read_info(end.uri);
  };
  const std::string current_alone = "\n\n\n-1.5\n1.5\n\n\n\n\n\n";
  SECTION("of a former certificate, the earlier last day counts") {
    certify(end.uri, "LAB-0", 20270101);
    const test::Finished part =
        calibrate_with(folder, end.uri, "LAB-1", "2031-01-01", current_alone, certificate);
    CHECK(part.status == 0);
    CHECK_THAT(part.err,
               Catch::Contains("calibration LAB-1 is in force") && Catch::Contains("valid until 2027-01-01"));
    const std::string text = test::read_file(certificate);
    CHECK_THAT(text, Catch::Contains("expires = \"2027-01-01\"") &&
                         Catch::Contains("[laser]\nkept = \"from LAB-0, valid until 2027-01-01\"") &&
                         Catch::Contains("expires_of_measured = \"2031-01-01\"") &&
                         !Catch::Contains("[coil_current]\nkept"));
    CHECK(in_force().calibration == "LAB-1");
    CHECK(in_force().calibration_expires == "2027-01-01");
  }
  SECTION("of none, their validity is not stated") {
    CHECK(calibrate_with(folder, end.uri, "LAB-1", "2031-01-01", current_alone, certificate).status == 0);
    CHECK_THAT(test::read_file(certificate),
               Catch::Contains("[laser]\nkept = \"from virtual-SIM-0001, validity not stated\""));
    CHECK(in_force().calibration_expires == "2031-01-01");
  }
  SECTION("that has expired before this day, it is refused") {
    certify(end.uri, "LAB-0", 20210101);
    const test::Finished late =
        calibrate_with(folder, end.uri, "LAB-1", "2031-01-01", current_alone, certificate);
    CHECK(late.status == 2);
    CHECK_THAT(late.err, Catch::Contains("was valid until 2021-01-01"));
    CHECK(in_force().calibration == "LAB-0");
  }
}

TEST_CASE(
    "a calibration that cannot be is refused with the rig's reason, and answers that are no numbers too",
    "[calibration]") {
  const rigs::Endpoint end = rigs::endpoint("sim:", {}, {});
  rigs::IioLink link(end.uri, rigs::connect_limit, rigs::request_limit);
  link.write(rigs::IioLink::Device::control, "lease", "t 60000 test");
  Walk w{.rows = rows_of(link), .switch_delay = 0.0, .report = {}};
  w.rows[index(Channel::coil_current)].scale_pico *= 2;
  CHECK_THROWS_WITH(store(link, "t", w, "PB-9", 20300101, 20310101),
                    Catch::Contains("a gain is more than 10 % off"));
  CHECK(link.read(rigs::IioLink::Device::daq, "calibration") != "PB-9");
  CHECK_THROWS_WITH(walk(link, "t", say({"much"})), Catch::Contains("not a number"));
}

TEST_CASE("days and names of certificates are checked before anything is asked", "[calibration]") {
  test::Folder folder;
  for (const auto& [id, expires, word] : {std::tuple{"a b", "2030-01-01", "without blank"},
                                          {"a", "2030-02-30", "a day from"},
                                          {"a", "1999-01-01", "a day from"},
                                          {"a", "2001-01-01", "lies before"}}) {
    const auto r = test::run(
        folder, {"calibrate", "sim:", "--id", id, "--expires", expires, "-o", folder.file("c.toml")});
    CHECK(r.status == 2);
    CHECK_THAT(r.err, Catch::Contains(word));
  }
}
