#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/channels.h"
#include "core/record.h"
#include "host/gather/scene.h"

/// What the parts of the Python module share. Each part adds its names to the module `powbench._native`.

namespace pybind11 {
class module_;
}

namespace powbench::python {

void add_errors(pybind11::module_&);
void add_events(pybind11::module_&);
void add_record(pybind11::module_&);
void add_store(pybind11::module_&);
void add_simulation(pybind11::module_&);
void add_rig(pybind11::module_&);

/// One closing's conditions in the units of the plan file.
struct ClosingArgs {
  double angle_deg = 0, supply_volts = 230, mains_hertz = 50, hold_time_ms = 100, ambient_degC = 20;
  double angle_tolerance_deg = 1;
  unsigned long long seed = 1;
  std::string specimen;  ///< specimen file; "" = the built-in reference
};

/// A plan of this one closing, with the plan file's own checks. Throws BadInput with all mistakes; `caller` stands in
/// front.
host::Scene one_closing(const ClosingArgs&, const std::string& caller);

/// The channel of this name. Throws BadInput with the names there are.
Channel channel_named(const std::string& name);

/// SI values of one channel into `to` (record.samples() of them); NaN where samples were lost.
template <class Float>
void fill_values(const Record& record, const ChannelRecord& channel, Float* to);

}  // namespace powbench::python
