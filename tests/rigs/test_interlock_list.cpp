#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "firmware/faults.h"
#include "rigs/interlock_list.h"
#include "tests/places.h"

using namespace powbench;

TEST_CASE("the page of the faults says what the table says", "[fault]") {
  std::ifstream file(test::source_dir() + "/docs/reference/faults.md");
  std::stringstream text;
  text << file.rdbuf();
  const auto list = rigs::interlock_list();
  REQUIRE(list.size() == firmware::fault_table.size());
  for (const auto& f : list) {
    std::ostringstream row;
    row << "| " << f.number << " | `" << f.name << "` | " << f.watched << " | " << f.reaction << " | "
        << f.limit << " | " << f.when << " | " << f.cleared << " |\n";
    INFO("docs/reference/faults.md needs the line\n" << row.str());
    CHECK(text.str().find(row.str()) != std::string::npos);
    const auto reason = firmware::reason(static_cast<firmware::Fault>(f.number));
    INFO("docs/reference/faults.md needs the line\n- `" << f.name << "`: " << reason);
    CHECK(text.str().find("- `" + f.name + "`: " + std::string(reason) + "\n") != std::string::npos);
    CHECK(f.advice.find("abort") == std::string::npos);  // the word of the attribute, not of a person
  }
}

TEST_CASE("only what says nothing of the coil's circuit may be tried again", "[fault]") {
  using firmware::Fault;
  int again = 0;
  for (const auto& f : firmware::fault_table) again += rigs::may_try_again(static_cast<int>(f.fault)) ? 1 : 0;
  CHECK(again == 6);
  for (const Fault f : {Fault::coil_overcurrent, Fault::coil_stuck_on, Fault::contact_welded,
                        Fault::emergency_stop, Fault::relay_welded, Fault::on_time_exceeded})
    CHECK_FALSE(rigs::may_try_again(static_cast<int>(f)));
  CHECK_FALSE(rigs::may_try_again(0));  // what is not known is none of them
}
