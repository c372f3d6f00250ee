#pragma once

#include <memory>
#include <string>

#include "rigs/fault_line.h"
#include "rigs/sim_rig_config.h"
#include "sim/specimen/specimen.h"

/// The simulated rig as a board on a serial line: the native firmware with its plant behind a pseudo-terminal
/// whose bytes take the time they take on a wire (10 bits a byte). One connection, and READBUF answers at
/// once, as on a UART.

namespace powbench::bench {

using rigs::LineFault;

class UartBoard {
 public:
  UartBoard(const rigs::SimRigConfig&, const sim::Specimen&, double baud);
  ~UartBoard();
  UartBoard(const UartBoard&) = delete;
  UartBoard& operator=(const UartBoard&) = delete;

  const std::string& port() const;  ///< path to give to whoever opens the line
  std::string heard() const;        ///< every byte received so far

  /// Power off and on: whatever was on the line is cut short, nothing is open or armed, and `boot_id` is
  /// another one.
  void reset();
  /// Flips one bit of the byte at `offset` in the next answer that begins with `prefix`.
  void corrupt_answer(std::string prefix, std::size_t offset);
  /// Flips one bit of the byte at `offset` behind the next occurrence of `text` among the received bytes.
  void corrupt_request(std::string text, std::size_t offset);
  /// One fault at one byte of the line, counted from now on; close and half_open mean nothing here.
  void set(const LineFault&);
  bool struck() const;
  std::uint64_t passed(bool to_rig) const;  ///< bytes since set()
  /// Times the coil was energised since the last reset.
  int operations() const;
  /// The record of the last shot armed is complete.
  bool holds_a_record() const;
  /// Goes on receiving, says nothing.
  void mute(bool silent);
  /// The cable is out: the port is an error from now on.
  void unplug();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::bench
