#include "tests/fuzz/responder_case.h"

/// libFuzzer's entry: `responder_fuzzer -runs=10000000 tests/fuzz/corpus`.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static powbench::fuzz::ResponderCase fuzz;
  fuzz.run({data, size});
  return 0;
}
