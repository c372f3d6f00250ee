#pragma once

#include <string>
#include <string_view>

/// What a bench around a port must offer, so that the scenarios of this folder can be played on it.
namespace powbench::test {

class Driver {
 public:
  virtual ~Driver() = default;

  /// Whether scenarios that begin with `needs WHAT` can be played: `reset`.
  virtual bool offers(std::string_view what) const = 0;
  /// Value of an attribute of contactor-ctl.
  virtual std::string read(const std::string& attribute) = 0;
  /// Written by the owner of the lease; negative: refused.
  virtual int write(const std::string& attribute, const std::string& value) = 0;
  /// Lets time pass, us.
  virtual void run(double us) = 0;
  /// Time since the start, us; after `write`: that of the request's last byte.
  virtual double now() const = 0;
  /// Something breaks, or is mended.
  virtual void cause(const std::string& name, bool begins) = 0;

  virtual bool gate() const = 0;
  /// us since the start of the gate's last edges; negative before the first.
  virtual double gate_on_at() const = 0;
  virtual double gate_off_at() const = 0;
  /// The safety relay's own contact.
  virtual bool relay() const = 0;
  /// Degrees of the mains at the last on edge.
  virtual double angle() const = 0;
};

}  // namespace powbench::test
