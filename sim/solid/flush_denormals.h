#pragma once

/// While it lives, this thread takes denormal numbers for zero, read or written; then what held before holds again. For
/// the loops over cells alone: on some processors each denormal operand costs a hundred cycles, and behind the front
/// of a wave there are many. No call out of this folder while it lives.

namespace powbench::sim {

class FlushDenormals {
 public:
#ifdef __SSE2__
  FlushDenormals() : before_(__builtin_ia32_stmxcsr() & both) {
    __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | both);
  }
  ~FlushDenormals() {
    __builtin_ia32_ldmxcsr((__builtin_ia32_stmxcsr() & ~both) | before_);
  }  // flags raised meanwhile stay
#else
  FlushDenormals() = default;
  ~FlushDenormals() {}
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
#ifdef __SSE2__
  static constexpr unsigned both = 0x8040;  // flush to zero, denormals are zero
  unsigned before_;
#endif
};

}  // namespace powbench::sim
