#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/host/report_samples.h"
#include "tests/host/report_xml_check.h"

/// What the page's script has to zoom into.

using namespace powbench;
using namespace powbench::host;
using test::xml_error;

TEST_CASE("closer look: what the page's script decodes is the record, to a count", "[report]") {
  ReportInput in;
  in.campaign = "zoom";
  in.shots = {some_shot(1), some_shot(2)};
  for (float& v : in.shots[0].raw[0].values) v += 0.25F;  // taken off
  in.shots[1].raw.clear();                                // not one of those to zoom into
  compare_into(in);
  const std::string html = render_html(in), begin = "id=\"closings\">";
  CHECK(xml_error(html) == "");
  const auto from = html.find(begin) + begin.size();
  const auto closings = nlohmann::json::parse(html.substr(from, html.find("</script>", from) - from));
  REQUIRE(closings.size() == 1);
  const auto& c = closings.at(0);
  CHECK(c.at("name") == "shot 1 at 30.0 deg");
  CHECK(c.at("marks").at(0).at("at") == Approx(12.0));
  std::map<std::string, std::vector<double>> decoded;
  for (const auto& series : c.at("channels").at(0).at("series")) {
    const std::string text = series.at("data");
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned held = 0, bits = 0;
    for (const char ch : text) {
      if (ch == '=') break;
      held = held << 6 | static_cast<unsigned>(letters.find(ch));
      if ((bits += 6) >= 8) bytes += static_cast<char>(held >> (bits -= 8) & 255U);
    }
    auto& values = decoded[series.at("label")];
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
      const auto low = static_cast<unsigned char>(bytes[i]), high = static_cast<unsigned char>(bytes[i + 1]);
      const auto count = static_cast<std::int16_t>(low | high << 8);
      values.push_back(count == -32768
                           ? std::nan("")
                           : series.at("middle").get<double>() + count * series.at("step").get<double>());
    }
    REQUIRE(values.size() == c.at("n").get<std::size_t>());
  }
  const Waveform& measured = in.shots[0].waveforms[0];
  double worst = 0, worst_off = 0;
  for (std::size_t i = 0; i < decoded["measured"].size(); ++i) {
    const double at = (c.at("t0").get<double>() + static_cast<double>(i) * c.at("dt").get<double>()) * 1e-3;
    const double k = (at - measured.t0) / measured.dt;
    const auto j = static_cast<std::size_t>(k);
    const double part = k - static_cast<double>(j);
    const double truth = (1 - part) * static_cast<double>(measured.values[j]) +
                         part * static_cast<double>(measured.values[j + 1]);
    worst = std::max(worst, std::fabs(decoded["measured"][i] - truth));
    worst_off = std::max(worst_off, std::fabs(decoded["raw minus measured"][i] - 0.25));
  }
  CHECK(worst < 1e-4);
  CHECK(worst_off < 1e-4);
}

TEST_CASE("closer look: a spike of one sample stays, however long the record", "[report]") {
  ReportInput in;
  in.campaign = "spike";
  in.shots = {some_shot(1)};
  auto& values = in.shots[0].waveforms[0].values;
  in.shots[0].waveforms[0].dt = 0.2e-6;  // 5 MS/s, 60 ms
  values.assign(300'000, 1.0F);
  values[131'071] = 50.0F;
  compare_into(in);
  const std::string html = render_html(in), begin = "id=\"closings\">";
  const auto from = html.find(begin) + begin.size();
  const auto closings = nlohmann::json::parse(html.substr(from, html.find("</script>", from) - from));
  for (const auto& series : closings.at(0).at("channels").at(0).at("series"))
    if (series.at("label") == "measured") CHECK(series.at("step").get<double>() * 65'000 == Approx(49.0));
}
