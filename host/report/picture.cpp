#include <cmath>

#include "host/report/number.h"
#include "host/report/plot.h"
#include "host/report/sections.h"

/// One closing as a picture of its own.

namespace powbench::host {

namespace {

AngleView first_view(const ReportInput& input) {
  for (const AngleView& view : angles_of(input))
    if (!view.shots.empty()) return view;
  return {};
}

std::string shot_title(const AngleView& view) {
  return "Shot " + (view.shots.empty() ? "" : std::to_string(view.shots.front()->index)) + ", " +
         (std::isfinite(view.angle) ? angle_text(view.angle) : "closing angle not known");
}

}  // namespace

std::string render_shot_svg(const ReportInput& input) {
  const AngleView view = first_view(input);
  // a picture leaves its folder: what it shows, and where from, goes with it
  return standing_alone(waveform_figure(input, view, time_window(input)).str() + "\n",
                        shot_title(view) + " \xC2\xB7 " + std::string(name(input.origin)) + " \xC2\xB7 " +
                            input.campaign + " \xC2\xB7 " + input.specimen);
}

std::string render_shot_html(const ReportInput& input) {
  const AngleView view = first_view(input);
  const std::string title = shot_title(view);
  Markup out;
  out.open("html", {{"lang", "en"}}).open("head").empty("meta", {{"charset", "utf-8"}});
  out.empty("meta", {{"name", "color-scheme"}, {"content", "light dark"}});
  out.empty("meta", {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}});
  out.element("title", title).embed(page_style()).close();
  out.open("body").open("main").element("h1", title);
  out.open("p", {{"class", "origin"}}).element("b", name(input.origin));
  out.text(" " + std::string(meaning(input.origin)) + " Specimen " + input.specimen + ".").close();
  out.open("figure").embed(waveform_figure(input, view, time_window(input))).close();
  out.embed(closer_section(input));
  out.close().close().close();
  return "<!DOCTYPE html>\n" + out.str();
}

}  // namespace powbench::host
