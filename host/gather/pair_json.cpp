#include "host/gather/pair_json.h"

#include <nlohmann/json.hpp>

#include "host/compare/compare.h"
#include "host/store/json.h"

namespace powbench::host {

std::string pair_json(std::span<const PairRow> all, int indent) {
  using Json = nlohmann::ordered_json;
  const auto mean = [](const Measured& m, double k) {
    Json j = json_of<Json>(m);
    j["U"] = json_of<Json>(k * m.u);
    return j;
  };
  Json rows = Json::array();
  for (const PairRow& r : all)
    rows.push_back({{"quantity", r.quantity},
                    {"unit", r.unit},
                    {"closing_angle_deg", json_of<Json>(stored_degrees(r.closing_angle))},
                    {"n", {r.n[0], r.n[1]}},
                    {"first", mean(r.first, r.k[0])},
                    {"second", mean(r.second, r.k[1])},
                    {"difference", json_of<Json>(r.difference)},
                    {"U", json_of<Json>(r.U)},
                    {"over_U", json_of<Json>(r.over_U())},
                    {"agreement", agreement(r.over_U())}});
  return rows.dump(indent);
}

}  // namespace powbench::host
