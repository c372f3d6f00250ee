#include "core/late_library.h"

#include <catch2/catch.hpp>

using namespace powbench;

TEST_CASE("a late library gives its functions, and says which file or name is not there") {
  const LateLibrary math("libm.so.6");
  CHECK(math.find<double (*)(double)>("floor")(2.5) == 2.0);
  CHECK_THROWS_WITH(math.find<double (*)(double)>("no_such_function"), Catch::Contains("no_such_function"));
  CHECK(math.look_for<double (*)(double)>("no_such_function") == nullptr);
  CHECK_THROWS_WITH(LateLibrary("libnosuch.so.7"), Catch::Contains("libnosuch.so.7"));
}
