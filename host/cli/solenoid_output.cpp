#include "host/cli/solenoid_output.h"

#include <fmt/format.h>

#include "host/report/plot.h"

namespace powbench::host {

std::string solenoid_csv(const std::vector<sim::SolenoidSample>& samples) {
  std::string out =
      "time [s],source voltage [V],coil voltage [V],current [A],flux linkage [Wb],travel [m],velocity [m/s],"
      "pull [N],stop force [N]\n";
  for (const auto& s : samples)
    out += fmt::format("{},{},{},{},{},{},{},{},{}\n", s.time, s.source_voltage, s.coil_voltage, s.current,
                       s.flux_linkage, s.travel, s.velocity, s.pull, s.stop_force);
  return out;
}

std::string solenoid_svg(const std::vector<sim::SolenoidSample>& samples, const std::vector<TimeMark>& marks,
                         const std::string& title) {
  constexpr double width = 800, left = 74, right = 14, panel = 130, apart = 30, head = 40, foot = 48;
  const std::pair<const char*, double (*)(const sim::SolenoidSample&)> panels[] = {
      {"coil voltage / V", [](const sim::SolenoidSample& s) { return s.coil_voltage; }},
      {"current / A", [](const sim::SolenoidSample& s) { return s.current; }},
      {"travel / mm", [](const sim::SolenoidSample& s) { return s.travel * 1e3; }},
      {"pull / N", [](const sim::SolenoidSample& s) { return s.pull; }}};
  const Range x{samples.front().time * 1e3, samples.back().time * 1e3};
  const Ticks xt = nice_ticks(x, 10);
  std::vector<Markup> drawn;
  double y = head;
  for (const auto& [label, value] : panels) {
    Range range;
    std::vector<XY> line;
    for (const auto& s : samples) {
      line.push_back({s.time * 1e3, value(s)});
      range.include(value(s));
    }
    range = range.padded(0.06);
    Plot plot({left, y, width - left - right, panel}, x, range);
    const Ticks yt = nice_ticks(range, 4);
    plot.grid(xt, yt);
    for (const auto& mark : marks) plot.vertical(mark.time * 1e3, {colour::ink, 0.8, 0.6, "4 3"});
    plot.line(line, {colour::simulated, 1.4});
    plot.frame();
    plot.y_labels(yt, label);
    if (drawn.empty())
      for (const auto& mark : marks) plot.note(mark.time * 1e3, mark.name, colour::ink, 0);
    if (drawn.size() + 1 == std::size(panels)) plot.x_labels(xt, "time after switch-on / ms");
    drawn.push_back(plot.finish());
    y += panel + apart;
  }
  return standing_alone(figure(width, y - apart + foot, title, drawn).str(), title);
}

}  // namespace powbench::host
