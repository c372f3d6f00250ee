#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "host/store/hash.h"
#include "host/store/json.h"
#include "tests/host/store_samples.h"

using namespace powbench;
using namespace powbench::host;

TEST_CASE("events survive JSON bit for bit, unknown values and flags included", "[store]") {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Events e = sample_events(seed);
    REQUIRE(same(events_from_json(to_json(e)), e));
    REQUIRE(same(events_from_json(to_json(e, 2)), e));
  }
  CHECK(same(events_from_json(to_json(Events{})), Events{}));
  CHECK_FALSE(same(sample_events(1), sample_events(2)));
}

TEST_CASE("the pole by force and the two trains stand in the events' JSON", "[store]") {
  Events e = sample_events(3);
  e.pole.by_force.first_train = {.openings = 2, .from = {12e-3, 1e-6}, .to = {14e-3, 2e-6}};
  e.pole.by_force.second_train = {.openings = 3, .from = {17e-3, 1e-6}, .to = {}};
  e.pole.disagreement = {80e-6, 4e-6};
  e.pole.longest_disagreement = {50e-6, 3e-6};
  auto j = nlohmann::json::parse(to_json(e));
  const auto& by_force = j["pole"]["by_force"];
  CHECK(by_force["contacts"].size() == 3);
  CHECK(by_force["first_train"]["openings"] == 2);
  CHECK(by_force["first_train"]["to_s"]["value"] == 14e-3);
  CHECK(by_force["second_train"]["openings"] == 3);
  CHECK(by_force["second_train"]["from_s"]["u"] == 1e-6);
  CHECK(by_force["second_train"]["to_s"]["value"].is_null());
  CHECK(j["pole"]["disagreement_s"]["value"] == 80e-6);
  CHECK(j["pole"]["longest_disagreement_s"]["u"] == 3e-6);
  for (const char* train : {"pvdf_a", "pvdf_b", "contact_voltage"})
    CHECK((j[train].contains("first_train") && j[train].contains("second_train")));
  // a text of an older store has none of it
  j.erase("pole");
  for (const char* train : {"pvdf_a", "pvdf_b", "contact_voltage"})
    j[train].erase("first_train"), j[train].erase("second_train");
  const Events old = events_from_json(j.dump());
  CHECK_FALSE(old.pole.by_force.present);
  CHECK_FALSE(old.pole.disagreement.known());
  CHECK(old.pvdf_a.first_train.openings == 0);
  CHECK(same(old.pvdf_a.settled, e.pvdf_a.settled));
}

TEST_CASE("every flag has a name and comes back", "[store]") {
  for (std::uint32_t bit = 0; bit < 11; ++bit) {
    Events e;
    e.core.flags = 1U << bit;
    CHECK(events_from_json(to_json(e)).core.flags == 1U << bit);
    CHECK_FALSE(flag_names(1U << bit).empty());
  }
  CHECK(flag_names(flag_clipped | flag_poor_fit) == "clipped, poor_fit");
  CHECK(flag_names(flag_none).empty());
}

TEST_CASE("conditions survive JSON bit for bit", "[store]") {
  Random random(8);
  for (int i = 0; i < 200; ++i) {
    Conditions c;
    c.supply_volts = random.normal() * 230;
    c.closing_angle = random.uniform() * 2 * pi;
    c.polarity = i % 2 == 0 ? 1 : -1;
    c.ambient = 273.15 + random.uniform() * 100;
    c.specimen = "K\"1\\ \n \xC3\xA4";
    c.seed = random.next();
    REQUIRE(same(conditions_from_json(to_json(c)), c));
  }
}

TEST_CASE("text that is no such object is refused in words", "[store]") {
  for (const char* text : {"", "{", "[]", "null", "{}", "{\"supply_volts\": \"x\"}", "\xFF"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(events_from_json(text), std::invalid_argument);
    CHECK_THROWS_AS(conditions_from_json(text), std::invalid_argument);
  }
}

TEST_CASE("the hash is SHA-256", "[store]") {
  CHECK(sha256_hex(std::string_view("")) ==
        "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256_hex(std::string_view("abc")) ==
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}
