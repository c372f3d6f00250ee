#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "host/cli/verbs.h"
#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/magnetics/space/space_magnet.h"
#include "sim/magnetics/table/potential_table.h"

namespace powbench::host {

/// Table and pictures of a drawn magnet: `powbench field x.magnet.toml`.
Exit show_drawing(const FieldArgs&, const std::shared_ptr<const sim::DrawnMagnet>&);

/// The same of a magnet drawn in space.
Exit show_space_drawing(const FieldArgs&, const std::shared_ptr<const sim::SpaceMagnet>&);

/// Throws BadInput for options of `field` that do not go with a drawing.
void refuse_drawing_options(const FieldArgs&);

/// What helps where the table of a drawing misses its accuracy.
inline constexpr std::string_view
    finer_drawing = "mesh the drawing finer",
    finer_drawn_table = "a smaller --accuracy has more nodes, a lower largest_flux_Wb finer cells";

}  // namespace powbench::host
