#include "host/gather/summary_json.h"

#include <nlohmann/json.hpp>

#include "host/compare/compare.h"
#include "host/report/best_angle.h"
#include "host/store/json.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

Json best_json(const ReportInput& input) {
  const BestAngle b = best_angle(input.comparison);
  if (b.angles < 2) return nullptr;  // one angle is no choice
  return {{"closing_angle_deg", json_of<Json>(stored_degrees(b.angle))},
          {"bounce_s", json_of<Json>(b.bounce.value)},
          {"U_s", json_of<Json>(b.coverage * b.bounce.u)},
          {"confidence", json_of<Json>(b.confidence)},
          {"next_deg", json_of<Json>(stored_degrees(b.runner_up))},
          {"gain_s", json_of<Json>(b.gain.value)},
          {"gain_U_s", json_of<Json>(b.gain_coverage * b.gain.u)}};
}

Json agreement_json(const ReportInput& input) {
  const auto rows = ranked(input.comparison);
  if (rows.empty()) return nullptr;
  std::size_t differ = 0;
  Json one = Json::array();
  for (const ComparisonRow& r : input.comparison.rows)
    if (r.seen_in_one)
      one.push_back({{"quantity", r.quantity},
                     {"closing_angle_deg", json_of<Json>(stored_degrees(r.closing_angle))},
                     {"seen_in", r.measured.known() ? "measurement" : "simulation"}});
  for (const ComparisonRow* r : rows) differ += r->difference_over_U() > 1 ? 1U : 0U;
  const ComparisonRow& worst = *rows.front();
  return {{"compared", rows.size()},
          {"differ", differ},
          {"seen_in_one", one},
          {"largest",
           {{"quantity", worst.quantity},
            {"unit", worst.unit},
            {"closing_angle_deg", json_of<Json>(stored_degrees(worst.closing_angle))},
            {"measured", json_of<Json>(worst.measured.value)},
            {"simulated", json_of<Json>(worst.simulated)},
            {"difference_over_U", json_of<Json>(worst.difference_over_U())}}}};
}

}  // namespace

std::string summary_json(const ReportInput& input) {
  const Counts n = count(input);
  Json expired = Json::array(), course = Json::array();
  for (const Instrument& i : expired_then(input))
    expired.push_back(
        {{"instrument", i.name}, {"certificate", i.certificate}, {"valid_until", i.valid_until}});
  for (const CourseEntry& e : input.course) course.push_back({{"when", e.when}, {"what", e.what}});
  return Json{{"campaign", input.campaign},
              {"origin", name(input.origin)},
              {"verdict", name(verdict(input))},
              {"reason", verdict_reason(input)},
              {"shots",
               {{"planned", n.planned},
                {"measured", n.done},
                {"passed", n.passed},
                {"failed", n.failed},
                {"not_observed", n.not_observed},
                {"not_judged", n.not_judged},
                {"errors", n.errors},
                {"missing", n.missing}}},
              {"best_angle", best_json(input)},
              {"agreement", agreement_json(input)},
              {"expired", expired},
              {"course", course}}
      .dump();
}

}  // namespace powbench::host
