#include <fmt/format.h>

#include "host/export/base64.h"
#include "host/report/closer_assets.h"
#include "host/report/closing_json.h"
#include "host/report/sections.h"

/// Single closings to zoom into: raw films, what was taken off them, and the rest of the channels, by a charting
/// library that is part of the page.

namespace powbench::host {
namespace {

void script(Markup& out, std::string_view code) {
  out.element("script", "", {{"src", "data:text/javascript;base64," + base64(std::string(code))}});
}

/// Dimensions in mm, as host/report/device.js takes them.
std::string device_json(const DeviceShape& d) {
  return fmt::format(
      "{{\"centre\":{:.4g},\"outer\":{:.4g},\"window\":{:.4g},\"fixed_window\":{:.4g},\"moving_window\":{:."
      "4g},"
      "\"yoke\":{:.4g},\"stack\":{:.4g},\"coil\":{:.4g},\"travel\":{:.4g},\"gap\":{:.4g},\"half_length\":{:."
      "4g},"
      "\"poles\":{}}}",
      d.centre * 1e3, d.outer * 1e3, d.window * 1e3, d.fixed_window * 1e3, d.moving_window * 1e3,
      d.yoke * 1e3, d.stack * 1e3, d.coil * 1e3, d.travel * 1e3, d.gap * 1e3, d.half_length * 1e3, d.poles);
}

void device_view(Markup& out) {
  out.open("div", {{"id", "device-box"}, {"hidden", "hidden"}});
  out.element("h3", "The closing in three dimensions");
  out.element("canvas", "",
              {{"id", "device-view"},
               {"role", "img"},
               {"tabindex", "0"},
               {"aria-label", "the device; arrow keys turn it"}});
  out.open("p", {{"class", "controls"}});
  out.open("label")
      .text("time ")
      .empty("input",
             {{"type", "range"}, {"id", "device-time"}, {"min", "0"}, {"max", "30"}, {"step", "0.01"}})
      .close();
  out.element("button", "play, 300 times slower", {{"type", "button"}, {"id", "device-play"}});
  out.element("span", "", {{"id", "device-says"}});
  out.close();
  out.element("p",
              "Core, travel and contact gap to the scale of the specimen file; the travel is the laser's, "
              "open and closed are the "
              "contact voltage's. How far the contacts open in a bounce is not measured and not to scale. "
              "Drag or arrow keys turn "
              "the device; moving over the curves moves the time.",
              {{"class", "fine"}});
  out.close();
}

}  // namespace

const ChartAssets& chart_assets() {
  static constexpr ChartAssets assets{chart_library, chart_links, chart_style, panels_script};
  return assets;
}

Markup closer_section(const ReportInput& input) {
  const std::string data = closings_json(input);
  Markup out;
  if (data.empty()) return out;
  if (chart_library.empty()) {
    out.element("p",
                "The figures are fixed: this program was built without the charting library (Debian's "
                "libjs-dygraphs).",
                {{"class", "fine screen"}});
    return out;
  }
  out.open("section", {{"id", "closer"}, {"hidden", "hidden"}, {"class", "screen"}});
  out.element("h2", "A closer look");
  out.open("p", {{"class", "controls"}});
  out.open("label").text("closing ").open("select", {{"id", "closer-shot"}}).text("").close().close();
  for (const auto& [what, text] : {std::pair{"whole", "whole closing"},
                                   {"bounce", "bounce"},
                                   {"in", "zoom in"},
                                   {"out", "zoom out"},
                                   {"left", "earlier"},
                                   {"right", "later"}})
    out.element("button", text, {{"type", "button"}, {"data-do", what}});
  out.open("label")
      .empty("input", {{"type", "checkbox"}, {"id", "closer-stripped"}})
      .text(" raw, and raw minus measured: offset, hum, droop, and all above the display's low-pass")
      .close();
  out.close();
  out.element("div", "", {{"id", "closer-panels"}});
  if (input.device) device_view(out);
  out.element("p",
              "Drag to zoom, double-click for the whole closing, shift and drag to move; the channels move "
              "together. Lines: touches, "
              "releases and seat, measured solid, simulated dashed.",
              {{"class", "fine"}});
  out.close();
  out.verbatim("script", data, {{"type", "application/json"}, {"id", "closings"}});
  if (input.device)
    out.verbatim("script", device_json(*input.device), {{"type", "application/json"}, {"id", "device"}});
  out.verbatim("style", chart_style);
  script(out, chart_library);
  script(out, chart_links);
  script(out, panels_script);
  if (input.device) script(out, device_script);
  script(out, closer_script);
  return out;
}

}  // namespace powbench::host
