#include <catch2/catch.hpp>

#include "host/config/edit_text.h"
#include "host/config/plan_file.h"
#include "host/config/rig_file.h"
#include "host/config/specimen_file.h"

using namespace powbench;
using host::with_value;

TEST_CASE("edit: the key's own line changes, comments and order stay", "[config]") {
  const std::string text =
      "# ours\nname = \"a # b\"  # the name\nrepeats = 2\n\n[limits.t_ct1]\nmax_ms = 20 # from the "
      "standard\n";
  CHECK(with_value(text, "", "name", "\"c\"") ==
        "# ours\nname = \"c\"  # the name\nrepeats = 2\n\n[limits.t_ct1]\nmax_ms = 20 # from the standard\n");
  CHECK(with_value(text, "limits.t_ct1", "max_ms", "19") ==
        "# ours\nname = \"a # b\"  # the name\nrepeats = 2\n\n[limits.t_ct1]\nmax_ms = 19 # from the "
        "standard\n");
  CHECK(with_value(text, "", "repeats", "") ==
        "# ours\nname = \"a # b\"  # the name\n\n[limits.t_ct1]\nmax_ms = 20 # from the standard\n");
}

TEST_CASE("edit: a new key stands in its section, a new section at the end", "[config]") {
  CHECK(with_value("a = 1\n\n# of the core\n[core]\nb = 2\n", "", "seed", "3") ==
        "a = 1\nseed = 3\n\n# of the core\n[core]\nb = 2\n");
  CHECK(with_value("a = 1\n", "core", "b", "2") == "a = 1\n\n[core]\nb = 2\n");
  CHECK(with_value("", "core", "b", "2") == "[core]\nb = 2\n");
  CHECK(with_value("[core]\n[other]\nb = 1\n", "core", "b", "2") == "[core]\nb = 2\n[other]\nb = 1\n");
  CHECK(with_value("a = 1\n", "core", "b", "") == "a = 1\n");
  CHECK(with_value("ab = 1\n", "", "a", "2") == "ab = 1\na = 2\n");
}

TEST_CASE("edit: a template's line is taken, a list over several lines becomes one", "[config]") {
  CHECK(with_value("# how many\n#repeats = 3\n", "", "repeats", "5") == "# how many\nrepeats = 5\n");
  CHECK(with_value("angles_deg = [ # few\n  0,\n  90 ] # deg\nrepeats = 1\n", "", "angles_deg", "[1]") ==
        "angles_deg = [1] # deg\nrepeats = 1\n");
  // what looks like a heading inside a list is none
  CHECK(with_value("a = [\n[1],\n[core]\n]\nb = 1\n", "", "b", "2") == "a = [\n[1],\n[core]\n]\nb = 2\n");
}

namespace {

/// Each key of a kind, in the commented template and in an empty file: the default written out means what it meant,
/// and stands where it is found again.
template <class Keys>
void every_key(const std::string& commented, const std::string& least, const Keys& keys_of_text) {
  const auto before = keys_of_text(least);
  REQUIRE(before.size() > 15);
  for (const std::string& text : {commented, least})
    for (std::size_t i = 0; i < before.size(); ++i) {
      const host::KeyLine& k = before[i];
      if (k.value.empty()) continue;
      CAPTURE(k.section, k.key, k.value);
      const std::string changed = with_value(text, k.section, k.key, k.value);
      REQUIRE(keys_of_text(changed)[i].value == k.value);
      REQUIRE(with_value(changed, k.section, k.key, k.value) == changed);
    }
}

}  // namespace

TEST_CASE("edit: every key of every file, in its template and in a short file", "[config]") {
  every_key(host::plan_template(), "angles_deg = [0, 90]\nrepeats = 3\n",
            [](const std::string& t) { return host::keys_of(host::parse_plan(t, "t")); });
  every_key(host::specimen_template(), "name = \"x\"\n",
            [](const std::string& t) { return host::keys_of(host::parse_specimen(t, "t")); });
  every_key(host::rig_template(), "\n",
            [](const std::string& t) { return host::keys_of(host::parse_rig(t, "t")); });
}

TEST_CASE("edit: a plan by hand is the plan with another order, and reads back", "[config]") {
  const std::string text = "angles_deg = [60]\nrepeats = 2  # each\n\n[limits.t_ct1]\nmax_ms = 20\n";
  const std::string hand = host::by_hand_plan(text);
  CHECK(host::parse_plan(hand, "p").order == host::Order::by_hand);
  CHECK(hand.find("repeats = 2  # each") != std::string::npos);
  CHECK(host::by_hand_plan(hand) == hand);
}
