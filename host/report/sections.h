#pragma once

#include "host/report/markup.h"
#include "host/report/report.h"
#include "host/report/view.h"

/// The parts of the page, in its order. Each is a finished piece of HTML.

namespace powbench::host {

/// The style sheet, a constant.
const Markup& page_style();

/// Classes of the style sheet for an outcome.
std::string_view badge_class(Outcome);

Markup header_section(const ReportInput&);
Markup summary_section(const ReportInput&);
Markup chart_section(const ReportInput&);
Markup angle_section(const ReportInput&, const AngleView&, const Range& window_ms);
Markup vibration_section(const VibrationView&);
Markup shot_section(const ReportInput&);
Markup definitions_section(const ReportInput&);

/// Measured over simulated signals of one angle on one time axis.
Markup waveform_figure(const ReportInput&, const AngleView&, const Range& window_ms);

}  // namespace powbench::host
