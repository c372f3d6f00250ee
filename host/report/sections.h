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

/// 2030-12-31T10:20:30Z as people read it; what is no such time as it is.
std::string time_text(const std::string& iso);

Markup header_section(const ReportInput&);
/// Verdict, best angle, agreement and the times themselves.
Markup answers_section(const ReportInput&);
Markup limits_section(const ReportInput&);
/// One closing as an example: the one nearest to the middle of the campaign's bounce times. Empty without waveforms.
Markup typical_section(const ReportInput&);
/// Customer, device, instruments; an expired calibration first.
Markup record_section(const ReportInput&);
/// Closings to zoom into, with the scripts that draw them; empty without raw waveforms.
Markup closer_section(const ReportInput&);
Markup provenance_section(const ReportInput&);
Markup chart_section(const ReportInput&);
Markup angle_section(const ReportInput&, const AngleView&, const Range& window_ms);
Markup vibration_section(const VibrationView&);
Markup shot_section(const ReportInput&);
Markup definitions_section(const ReportInput&);

/// Measured over simulated signals of one angle on one time axis. `short_form`: the panels of the first pages,
/// without the zoom.
Markup waveform_figure(const ReportInput&, const AngleView&, const Range& window_ms, bool short_form = false);

/// The simulated value of a row in the unit people read, to the digits of its own uncertainty, else of the measured
/// one.
std::string simulated_text(const ComparisonRow&);

}  // namespace powbench::host
