// Errors of the finite elements: closed solutions first.
#include <cstdio>

#include "bench/fields/analytic.h"

int main() {
  setvbuf(stdout, nullptr, _IONBF, 0);
  for (const auto& list : {powbench::bench::static_cases(), powbench::bench::alternating_cases()})
    for (const auto& r : list)
      std::printf("%-46s %-22s %14.8g %14.8g %+9.4f %% %7d\n", r.name.c_str(), r.quantity.c_str(), r.exact,
                  r.found, 100 * r.error(), r.unknowns);
}
