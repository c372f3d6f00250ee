#include <fmt/format.h>

#include "host/export/base64.h"
#include "host/report/closer_assets.h"
#include "host/report/closing_json.h"
#include "host/report/sections.h"

/// Single closings to zoom into: raw films, what was stripped of them, and the rest of the channels, by a charting library that
/// is part of the page.

namespace powbench::host {
namespace {

void script(Markup& out, std::string_view code) {
  out.element("script", "", {{"src", "data:text/javascript;base64," + base64(std::string(code))}});
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
      .text(" raw, and what was stripped off")
      .close();
  out.close();
  out.element("div", "", {{"id", "closer-panels"}});
  out.element("p",
              "Drag to zoom, double-click for the whole closing, shift and drag to move; the channels move "
              "together. Lines: touches, "
              "releases and seat, measured solid, simulated dashed.",
              {{"class", "fine"}});
  out.close();
  out.verbatim("script", data, {{"type", "application/json"}, {"id", "closings"}});
  out.verbatim("style", chart_style);
  script(out, chart_library);
  script(out, chart_links);
  script(out, panels_script);
  script(out, closer_script);
  return out;
}

}  // namespace powbench::host
