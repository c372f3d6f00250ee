#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "core/units.h"
#include "dsp/extract.h"
#include "host/compare/compare.h"
#include "host/run/simulate.h"

using namespace powbench;
using namespace powbench::host;

namespace {

Events seen(double degrees_off, double volts, double hertz) {
  Events e;
  e.coil.closing_angle = {radians(60 + degrees_off), radians(0.02)};
  e.coil.supply_volts = {volts, 0.01};
  e.coil.mains_hertz = {hertz, 1e-4};
  return e;
}

}  // namespace

TEST_CASE("simulated under the conditions that the closings had, not those that were asked for",
          "[simulate]") {
  Conditions asked;
  asked.closing_angle = radians(60);
  RunOptions options;
  const std::vector<Events> measured{seen(0.4, 221, 49.9), seen(0.6, 223, 50.1)};
  const ClosingInputs in = inputs_of(asked, measured, options);
  CHECK(degrees(in.conditions.closing_angle) == Approx(60.5));
  CHECK(in.conditions.supply_volts == Approx(222));
  CHECK(in.conditions.mains_hertz == Approx(50.0));
  CHECK(in.u_volts ==
        Approx(std::hypot(1.0, 0.005 * 222)).epsilon(1e-3));  // scatter 1.41 / sqrt(2), and the scale
  CHECK(in.u_ambient == 2.0);

  asked.polarity = -1;  // commanded to 240 deg
  std::vector<Events> other{seen(180.3, 230, 50)};
  CHECK(degrees(inputs_of(asked, other, options).conditions.closing_angle) == Approx(60.3));
  other[0].coil.closing_angle = {};  // the record does not show it
  CHECK(degrees(inputs_of(asked, other, options).conditions.closing_angle) == Approx(60));
  const ClosingInputs none = inputs_of(asked, {}, options);
  CHECK(none.u_volts == 0);
  CHECK(none.conditions.supply_volts == asked.supply_volts);
}

TEST_CASE("the inputs' uncertainty covers what other inputs do", "[simulate]") {
  // the rig is at 1 % more volts and 4 K more than the plan says: 2 u each; touch and seat have to move by some u
  const RunOptions options;
  ClosingInputs in;
  in.conditions.closing_angle = radians(90);
  in.u_volts = 1.15;
  in.u_ambient = 2;
  const auto u = input_uncertainty(in, {}, {}, options);
  CHECK(u.at("t_ct1") > 20e-6);
  CHECK(u.at("t_xt1") > 5e-6);
  const auto at = [&](double volts, double kelvin) {
    Conditions c = in.conditions;
    c.supply_volts += volts, c.ambient += kelvin;
    return extract_checked(rigs::simulate_record({}, c, {}).record, options);
  };
  const double touch = find_quantity("t_ct1")->of(at(0, 0)).value;
  CHECK(std::fabs(find_quantity("t_ct1")->of(at(1.15, 0)).value - touch) < 2 * u.at("t_ct1"));
  CHECK(std::fabs(find_quantity("t_ct1")->of(at(0, 2)).value - touch) < 2 * u.at("t_ct1"));
  ClosingInputs exact;
  exact.conditions = in.conditions;
  CHECK(input_uncertainty(exact, {}, {}, options).at("t_ct1") == 0);
}

TEST_CASE("of devices whose inputs scatter as stated, 95 % of the differences lie within U", "[.slow]") {
  const RunOptions options;
  Random random(11);
  int within = 0, all = 0;
  for (const double degree : {20.0, 50.0, 90.0, 130.0}) {
    ClosingInputs in;
    in.conditions.closing_angle = radians(degree);
    in.u_angle = radians(0.05), in.u_volts = 1.15, in.u_hertz = 0.005, in.u_ambient = 2;
    const auto u = input_uncertainty(in, {}, {}, options);
    const Events nominal = extract_checked(rigs::simulate_record({}, in.conditions, {}).record, options);
    for (int i = 0; i < 25; ++i) {
      Conditions c = in.conditions;
      c.closing_angle += in.u_angle * random.normal();
      c.supply_volts += in.u_volts * random.normal();
      c.mains_hertz += in.u_hertz * random.normal();
      c.ambient += in.u_ambient * random.normal();
      const Events e = extract_checked(rigs::simulate_record({}, c, {}).record, options);
      for (const char* symbol : {"t_ct1", "t_xt1", "t_ct2"}) {
        const Quantity& q = *find_quantity(symbol);
        ++all;
        within += std::fabs(q.of(e).value - q.of(nominal).value) <= 1.96 * u.at(symbol) + 6e-6;  // a sample
      }
    }
  }
  CAPTURE(within, all);
  CHECK(within > 0.88 * all);
  CHECK(within < all);
}
