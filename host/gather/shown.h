#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/quantities.h"
#include "host/store/json.h"
#include "host/store/store.h"

namespace powbench::host {

/// What the u of each single event is: of a simulated closing the curve is exact, and its inputs are not.
inline std::string_view u_of_events(ShotKind kind) {
  return kind == ShotKind::simulated
             ? "how well the curve can be read; what the inputs leave open is the u of the quantities"
             : "the measured event";
}

/// What a stored shot shows of a quantity. Of a simulated one u is what its inputs leave open, not how well its curve
/// could be read; NaN where that is not known.
class Shown {
 public:
  Shown(const Store& store, const StoredShot& shot)
      : events(store.load_events(shot.id)), simulated(shot.kind == ShotKind::simulated) {
    if (simulated) inputs_ = store.prediction(shot.id).u;
  }
  Measured of(const Quantity& q) const {
    Measured m = events ? q.of(*events) : Measured{};
    if (simulated) m.u = u_of(inputs_, q.symbol);
    return m;
  }
  /// Of a simulated shot, by the prediction that is stored with it.
  static double u_of(const std::map<std::string, double>& inputs, std::string_view symbol) {
    const auto it = inputs.find(std::string(symbol));
    return it == inputs.end() ? std::numeric_limits<double>::quiet_NaN() : it->second;
  }

  /// By symbol, {"value", "u"} each.
  template <class Json>
  Json json() const {
    Json out = Json::object();
    for (const Quantity& q : quantity_table) out[std::string(q.symbol)] = json_of<Json>(of(q));
    return out;
  }

  const std::optional<Events> events;
  const bool simulated;

 private:
  std::map<std::string, double> inputs_;
};

}  // namespace powbench::host
