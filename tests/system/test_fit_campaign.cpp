#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/system/program.h"

using namespace powbench::test;

TEST_CASE("a campaign of the simulated rig is fitted on ten angles, and two others are predicted",
          "[system][.slow]") {
  Folder folder;
  // a device out of tolerance, with scatter from shot to shot, measured through noisy sensors
  folder.write("bench.toml",
               "[device]\ncoil_resistance_percent = 3\nreturn_rate_percent = -4\nfriction_percent = 20\n"
               "[scatter]\nsupply_percent = 0.2\nfriction_percent = 3\n");
  const std::string plan = folder.write(
      "p.plan.toml", "angles_deg = [0, 15, 30, 45, 60, 90, 105, 120, 135, 150, 165, 40]\nrepeats = 2\n");
  const std::string db = folder.file("lab.db");
  const int measured = run(folder, {"run", plan, "--rig", "sim:" + folder.file("bench.toml"), "--db", db,
                                    "--progress", "none"})
                           .status;
  REQUIRE(measured == 0);
  const auto r = run(folder, {"fit", "--db", db, "--hold-out", "40", "--hold-out", "120", "--evaluations",
                              "800", "--searches", "1", "--ensemble", "2", "--json", "--progress", "none"});
  REQUIRE(r.status == 0);
  double touch = 0, seat = 0, bounce = 0, others = 0;
  int held_out = 0;
  const auto fit = nlohmann::json::parse(r.out);
  for (const auto& cell : fit["cells"]) {
    if (cell["held_out_error_percent"].is_null()) continue;
    const double theta = cell["theta_deg"], error = cell["held_out_error_percent"];
    CHECK((theta == Approx(40) || theta == Approx(120)));
    if (cell["quantity"] == "t_ct1") touch = std::max(touch, error), ++held_out;
    if (cell["quantity"] == "t_xt1") seat = std::max(seat, error);
    if (cell["quantity"] == "t_ct1")
      others = std::max(others, double(cell["median_of_others_error_percent"]));
    if (cell["quantity"] == "t_ct_bon") bounce = std::max(bounce, error);
  }
  std::printf(
      "held out angles of a campaign: touch within %.2f %%, seat within %.2f %%, bounce within %.2f %%; "
      "touch by the median of the others %.1f %%\n",
      touch, seat, bounce, others);
  CHECK(held_out == 2);
  CHECK(touch < 2);  // the goal for published closings is 4
  CHECK(seat < 2);
  CHECK(touch < others / 4);
  CHECK(bounce < 2);
}
