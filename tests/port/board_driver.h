#pragma once

#include <memory>

#include "bench/fault_world.h"
#include "rigs/board.h"
#include "tests/port/driver.h"

namespace powbench::test {

/// A native or emulated board in the ideal world that can break. Neither has a watchdog or a reset.
class BoardDriver : public Driver {
 public:
  explicit BoardDriver(const rigs::BoardOptions&);

  bool offers(std::string_view) const override { return false; }
  std::string read(const std::string& attribute) override;
  int write(const std::string& attribute, const std::string& value) override;
  void run(double us) override;
  double now() const override { return us(world_.next); }
  void cause(const std::string& name, bool begins) override;
  bool gate() const override { return world_.pin; }
  double gate_on_at() const override { return world_.ons > 0 ? us(world_.pin_on_since) : -1.0; }
  double gate_off_at() const override { return us(world_.pin_off_since); }
  bool relay() const override { return world_.relay_in; }
  double angle() const override;

 private:
  static double us(std::int64_t sample) {
    return 1e6 * static_cast<double>(sample) / bench::FaultWorld::rate;
  }
  std::string ask(const std::string& request);
  void step();

  bench::FaultWorld world_;
  std::unique_ptr<rigs::Board> board_;
  std::vector<std::int16_t> scans_, previous_;
  std::vector<firmware::GateEdge> edges_;
  firmware::Tick on_edge_{};
};

}  // namespace powbench::test
