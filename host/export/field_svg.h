#pragma once

#include <string>

#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/magnetics/plane/magnet_field.h"
#include "sim/magnetics/plane/solenoid_field.h"
#include "sim/magnetics/table/potential_table.h"

/// Pictures of fields and of tables, as SVG.

namespace powbench::host {

/// The whole core from the side: |B| as colour, 24 lines of equal flux, the outlines of iron, winding and ring. The
/// gap is the one last set on the field. The picture shows the core and a margin around it.
std::string field_svg(const sim::MagnetField&, const sim::FieldPoint&, const std::string& title);

/// The same of a drawn magnet: mirrored where its mesh ends at x = 0; around an axis the lines are those of equal r A.
std::string field_svg(const sim::DrawnField&, const sim::FieldPoint&, const std::string& title);
/// The same of a solenoid, both halves of its section; lines of equal r A.
std::string field_svg(const sim::SolenoidField&, const sim::FieldPoint&, const std::string& title);

/// Energy, coil current and pull over flux linkage and gap, three surfaces side by side. With a ring, its flux grows
/// in step with the coil's.
std::string table_svg(const sim::TablePotential&, const std::string& title);

}  // namespace powbench::host
