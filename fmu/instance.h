#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fmu/contactor_unit.h"
#include "fmu/variables.h"

/// One instance of the unit behind the functions of FMI: the modes of the standard's state machine, the variables by
/// value reference. What is refused is thrown as std::invalid_argument and changes nothing; a failed integration is a
/// std::runtime_error and ends the instance.

namespace powbench::fmu {

class Instance {
 public:
  /// Those of FMI 3.0; FMI 2.0 calls step mode "step complete".
  enum class Mode { instantiated, initialization, event, continuous, step, terminated, failed };

  /// `folder`: of the resources. Throws std::invalid_argument where they cannot be read or `token` is that of others.
  Instance(Fmi, bool exchange, const std::string& folder, const std::string& token);

  Mode mode() const { return mode_; }
  void use_event_mode(bool used, bool early) { event_mode_used_ = used, early_ = early; }
  void reset();
  /// Throws unless the mode is one of these.
  void require_mode(std::initializer_list<Mode>) const;

  // Variables by value reference.
  double number(std::uint32_t reference);
  bool flag(std::uint32_t reference);
  void set_number(std::uint32_t reference, double);
  void set_flag(std::uint32_t reference, bool);
  /// d^order/dt^order of coil_voltage for the next step, order 1 .. 5.
  void set_input_derivative(std::uint32_t reference, int order, double);

  void prepare(double start, std::optional<double> stop);  ///< s
  void enter_initialization();
  void exit_initialization();
  void terminate() { mode_ = Mode::terminated; }

  // Co-simulation.
  struct Step {
    double reached = 0;  ///< s
    bool early = false;
    bool event = false;  ///< event mode is to be entered
  };
  Step step(double t, double h);
  void enter_event_mode();
  void enter_step_mode() { mode_ = Mode::step; }

  // Model exchange, and event mode of both.
  struct Update {
    bool again = false;
    bool values_changed = false;
  };
  Update update();
  void enter_continuous_mode() { mode_ = Mode::continuous; }
  /// The unit with the inputs in force.
  ContactorUnit& driven();

  struct Saved;
  std::shared_ptr<const Saved> save() const;
  void go_back(const Saved&);

 private:
  const Variable& variable(std::uint32_t reference, bool boolean) const;
  ContactorUnit& unit();
  UnitSettings settings() const;
  void require_settable(const Variable&) const;

  Fmi fmi_;
  bool exchange_;
  bool event_mode_used_ = false, early_ = false;
  Mode mode_ = Mode::instantiated;
  sim::Specimen specimen_;
  std::vector<Variable> table_;
  std::vector<double> values_;  ///< of parameters, by reference
  UnitInput input_;
  std::shared_ptr<ContactorUnit> unit_;
  UnitFacts shown_;  ///< discrete outputs change in event mode alone, where it is used
  double start_ = 0;
  std::optional<double> stop_;
  int rounds_ = 0;  ///< of one event
};

}  // namespace powbench::fmu
