#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/phase.h"
#include "core/random.h"
#include "core/units.h"
#include "dsp/events/extract.h"
#include "dsp/signal/signal.h"
#include "host/compare/compare.h"
#include "host/run/simulate.h"
#include "tests/host/store_samples.h"

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

TEST_CASE("of a closing simulated as asked for, what it really had differently is part of u", "[simulate]") {
  Conditions asked;
  asked.closing_angle = radians(60);
  asked.supply_volts = 230;
  const RunOptions options;
  const std::vector<Events> one{seen(0.4, 227, 49.9)};
  const ClosingInputs real = inputs_of(asked, one, options), in = inputs_as_asked(asked, one, options);
  CHECK(in.conditions.closing_angle == asked.closing_angle);
  CHECK(in.conditions.supply_volts == 230);
  CHECK(in.conditions.mains_hertz == asked.mains_hertz);
  CHECK(degrees(in.u_angle) == Approx(std::hypot(0.4, 0.02)));
  CHECK(in.u_volts == Approx(std::hypot(3.0, real.u_volts)));
  CHECK(in.u_hertz == Approx(std::hypot(0.1, 1e-4)));
  CHECK(in.u_ambient == real.u_ambient);
  asked.polarity = -1;  // commanded to 240 deg
  CHECK(degrees(inputs_as_asked(asked, std::vector<Events>{seen(180.4, 230, 50)}, options).u_angle) ==
        Approx(std::hypot(0.4, 0.02)));
}

TEST_CASE("the inputs' uncertainty covers what other inputs do", "[simulate]") {
  // the rig is at 1 % more volts and 4 K more than the plan says: 2 u each; touch and seat have to move by some u
  const RunOptions options;
  ClosingInputs in;
  in.conditions.closing_angle = radians(90);
  in.u_volts = 1.15;
  in.u_ambient = 2;
  const auto u = input_uncertainty(in, {}, {}, options).u;
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
  CHECK(input_uncertainty(exact, {}, {}, options).u.at("t_ct1") == 0);
  CHECK(input_uncertainty(exact, {}, {}, options).curves.empty());
}

TEST_CASE("behind a coil switch with a delay the simulation has the angle of its conditions", "[simulate]") {
  Folder folder;
  Store store{folder.file()};
  const auto campaign = store.create_campaign({});
  std::vector<PlannedShot> plan(1);
  plan[0].conditions.closing_angle = radians(60);
  rigs::SimRigConfig slow;
  slow.supply.coil_switch.kind = sim::CoilSwitch::Kind::relay;
  slow.supply.coil_switch.closing_delay = 2e-3;  // 36 degrees
  Progress silent("test", plan.size(), Progress::Style::none);
  simulate_campaign(store, campaign, plan, {}, slow, {}, silent);
  const StoredShot shot = store.shots(campaign, ShotKind::simulated).at(0);
  const Events events = *store.load_events(shot.id);
  CHECK(shot.angle_deg == 60);
  CHECK(degrees(events.coil.closing_angle.value) == Approx(60).margin(0.2));
  CHECK(events.coil.switch_on.value == Approx(2e-3).margin(20e-6));
  CHECK((events.coil.flags & flag_angle_off) == 0);
  // its times are those of a switch that takes no time
  const Events ideal = extract_checked(rigs::simulate_record({}, plan[0].conditions, {}).record, {});
  for (const char* symbol : {"t_ct1", "t_ct2", "t_xt1"}) {
    CAPTURE(symbol);
    const Quantity& q = *find_quantity(symbol);
    CHECK(q.of(events).value == Approx(q.of(ideal).value).margin(30e-6));
  }
}

TEST_CASE("simulations are stored as they come, in the order of the angles, and kept when a later one fails",
          "[simulate]") {
  const int threads = GENERATE(1, 3);
  CAPTURE(threads);
  Folder folder;
  Store store{folder.file()};
  const auto campaign = store.create_campaign({});
  std::vector<PlannedShot> plan(6);
  for (int i = 0; i < 6; ++i) {
    plan[static_cast<std::size_t>(i)].index = 5 - i;
    plan[static_cast<std::size_t>(i)].conditions.closing_angle = radians(10.0 * i);
  }
  Progress silent("test", plan.size(), Progress::Style::none);
  const auto angles = [&] {  // in the order in which they were stored
    std::map<std::int64_t, int> found;
    for (const StoredShot& s : store.shots(campaign, ShotKind::simulated))
      found[s.id] = static_cast<int>(std::lround(s.angle_deg));
    std::vector<int> list;
    for (const auto& [id, angle] : found) list.push_back(angle);
    return list;
  };
  std::vector<std::size_t> seen;  // shots in the store when an angle begins; one thread only
  const RecordMaker maker = [&](const sim::Specimen& specimen, const Conditions& c,
                                const rigs::SimRigConfig& rig) {
    if (threads == 1) seen.push_back(angles().size());
    if (std::lround(degrees(c.closing_angle)) == 40) throw std::runtime_error("no such angle");
    return rigs::simulate_record(specimen, c, rig);
  };
  const auto simulate = [&](const RecordMaker& with) {
    return simulate_campaign(store, campaign, plan, {}, {}, {}, silent, {{}, with, false, threads});
  };
  CHECK_THROWS_WITH(simulate(maker), "no such angle");
  if (threads == 1) CHECK(seen == std::vector<std::size_t>{0, 1, 2, 3, 4});
  auto kept = angles();
  REQUIRE(kept.size() >= 4);
  kept.resize(4);
  CHECK(kept == std::vector<int>{0, 10, 20, 30});
  const std::size_t missing = 6 - angles().size();
  CHECK(simulate(rigs::simulate_record).stored == missing);
  CHECK(angles().size() == 6);
}

TEST_CASE("a simulation whose inputs have changed is made anew, one that has the same is kept",
          "[simulate]") {
  Folder folder;
  Store store{folder.file()};
  const auto campaign = store.create_campaign({});
  std::vector<PlannedShot> plan(2);
  plan[1].index = 1;
  plan[1].conditions.closing_angle = radians(60);
  const RunOptions options;
  Progress silent("test", plan.size(), Progress::Style::none);
  const auto simulate = [&](const Simulation& how) {
    const SimulatedCount n = simulate_campaign(store, campaign, plan, {}, {}, options, silent, how);
    CHECK(n.stored + n.kept == 2);
    return n.renewed;
  };
  const auto volts_of_60 = [&] {
    for (const StoredShot& s : store.shots(campaign, ShotKind::simulated))
      if (s.number == 1) return s.conditions.supply_volts;
    return 0.0;
  };
  const auto fire = [&](int number, double volts) {  // a closing at 60 degrees on another supply than asked
    StoredShot shot = stored(campaign, ShotKind::measured, plan[1]);
    shot.number = number;
    shot.outcome = Outcome::not_judged;
    Conditions c = shot.conditions;
    c.supply_volts = volts;
    const Record record = rigs::simulate_record({}, c, {}).record;
    const Events events = extract_checked(record, options);
    store.store_shot(shot, &record, &events, extraction_info(options));
  };
  CHECK(simulate({}) == 0);
  CHECK(simulate({}) == 0);
  fire(1, 220);
  CHECK(simulate({}) == 1);  // of the two angles the one that was measured
  CHECK(volts_of_60() == Approx(220).epsilon(0.005));
  fire(2, 200);  // as after a resumed run
  CHECK(simulate({}) == 1);
  CHECK(volts_of_60() == Approx(210).epsilon(0.005));
  CHECK(simulate({}) == 0);
  CHECK(simulate({{}, rigs::simulate_record, true}) == 1);
  CHECK(volts_of_60() == 230);
  for (const StoredShot& s : store.shots(campaign, ShotKind::simulated)) {
    CHECK(store.prediction(s.id).empty());
    CHECK(s.reason.starts_with("at the conditions that the plan asks for; inputs "));
  }
  CHECK(simulate({"another model", rigs::simulate_record, true}) == 2);
  CHECK(simulate({"another model"}) == 1);
  CHECK(store.shots(campaign, ShotKind::simulated)
            .back()
            .reason.starts_with("under the mean conditions of 2 measured closings; inputs "));
  CHECK(store.shots(campaign, ShotKind::simulated).size() == 2);
}

TEST_CASE("an uncertainty that nobody needs any more is given up", "[simulate]") {
  ClosingInputs in;
  in.u_volts = 1;
  int asked = 0;
  CHECK_THROWS_AS(input_uncertainty(in, {}, {}, {}, {}, [&] { return ++asked == 2; }), NotNeeded);
  CHECK(asked == 2);
}

TEST_CASE("each closing is simulated at the conditions that it reached, too", "[simulate]") {
  const double degree = GENERATE(0., 60., 165.);
  Folder folder;
  Store store{folder.file()};
  const auto campaign = store.create_campaign({});
  std::vector<PlannedShot> plan(1);
  plan[0].conditions.closing_angle = radians(degree);
  const RunOptions options;
  Progress silent("test", plan.size(), Progress::Style::none);
  Random random(5);
  AngleGroup group;
  group.closing_angle = radians(degree);
  std::vector<Events> own;  // simulated by itself
  for (int i = 0; i < 4; ++i) {
    StoredShot shot = stored(campaign, ShotKind::measured, plan[0]);
    shot.number = 10 + i;
    shot.outcome = Outcome::not_judged;
    Conditions c = shot.conditions;  // a supply that is not regulated, a switch that is early or late
    c.seed = 100 + static_cast<std::uint64_t>(i);
    c.closing_angle = wrap_turn(c.closing_angle + radians(0.4) * random.normal());
    c.supply_volts += 1.5 * random.normal();
    const Record record = rigs::simulate_record({}, c, {}).record;
    const Events events = extract_checked(record, options);
    c = shot.conditions;
    c.closing_angle = wrap_turn(events.coil.closing_angle.value);
    c.supply_volts = events.coil.supply_volts.value;
    c.mains_hertz = events.coil.mains_hertz.value;
    own.push_back(extract_checked(rigs::simulate_record({}, c, {}).record, options));
    store.store_shot(shot, &record, &events, extraction_info(options));
    group.measured.push_back(events);
  }
  simulate_campaign(store, campaign, plan, {}, {}, options, silent);
  const StoredShot simulated = store.shots(campaign, ShotKind::simulated).at(0);
  const InputSpread spread = store.prediction(simulated.id);
  group.simulated = {*store.load_events(simulated.id)};
  for (int i = 0; i < 4; ++i) group.moved.push_back(spread.moved.at(10 + i));
  for (const char* symbol : {"t_ct1", "t_ct2", "t_xt1"}) {
    const Quantity& q = *find_quantity(symbol);
    for (std::size_t i = 0; i < own.size(); ++i) {
      CAPTURE(degree, symbol, i);
      CHECK(q.of(group.simulated[0]).value + group.moved[i].at(symbol) ==
            Approx(q.of(own[i]).value).margin(3e-6));
    }
  }
  const Comparison all = compare({group}, {}, {});
  for (const ComparisonRow& touch : all.rows) {
    if (touch.quantity != "t_ct1") continue;
    CAPTURE(degree, touch.scatter, touch.unexplained);
    CHECK(touch.scatter > 50e-6);
    CHECK(touch.unexplained < 10e-6);  // what the scatter came from is known of every closing
  }
}

TEST_CASE("of devices whose inputs scatter as stated, 95 % of the differences lie within U", "[.slow]") {
  const RunOptions options;
  Random random(11);
  int curve_within = 0, curve_all = 0;
  std::map<std::string, std::pair<int, int>> counts;  // of each quantity: within, all
  for (const double degree : {7.0, 20.0, 50.0, 75.0, 90.0, 103.0, 130.0, 164.0}) {
    ClosingInputs in;
    in.conditions.closing_angle = radians(degree);
    in.u_angle = radians(0.05), in.u_volts = 1.15, in.u_hertz = 0.005, in.u_ambient = 2;
    const InputSpread spread = input_uncertainty(in, {}, {}, options);
    const auto& u = spread.u;
    const Record middle = rigs::simulate_record({}, in.conditions, {}).record;
    const Events nominal = extract_checked(middle, options);
    REQUIRE(spread.curves.size() == 2);
    for (int i = 0; i < 20; ++i) {
      Conditions c = in.conditions;
      c.closing_angle += in.u_angle * random.normal();
      c.supply_volts += in.u_volts * random.normal();
      c.mains_hertz += in.u_hertz * random.normal();
      c.ambient += in.u_ambient * random.normal();
      const Record record = rigs::simulate_record({}, c, {}).record;
      const Events e = extract_checked(record, options);
      for (const CurveSpread& curve : spread.curves) {
        const Channel channel = curve.channel == "laser" ? Channel::laser : Channel::coil_current;
        const dsp::Signal a = dsp::to_signal(middle, channel), b = dsp::to_signal(record, channel);
        for (std::size_t k = 0; k < curve.u.size(); ++k) {
          const std::size_t n = a.index_at((static_cast<double>(k) + 0.5) * curve.dt);
          const double noise = channel == Channel::laser ? 3e-6 : 3e-3;  // of one sample of either
          ++curve_all;
          curve_within +=
              std::fabs(b.value[n] - a.value[n]) <= 1.96 * static_cast<double>(curve.u[k]) + noise;
        }
      }
      for (const Quantity& q : quantity_table) {
        const double off = std::fabs(q.of(e).value - q.of(nominal).value), of_u = u.at(std::string(q.symbol));
        if (q.unit != "s" || !std::isfinite(off) || !std::isfinite(of_u)) continue;  // "+- ?" claims nothing
        auto& [within, all] = counts[std::string(q.symbol)];
        ++all;
        within += off <= 1.96 * of_u + 6e-6;  // a sample
      }
    }
  }
  for (const auto& [symbol, count] : counts) {
    const auto [within, all] = count;
    CAPTURE(symbol, within, all);
    WARN(symbol << ": " << within << " of " << all << " differences lie within U");
    CHECK(within > 0.88 * all);
    CHECK(all > 100);
  }
  CAPTURE(curve_within, curve_all);
  CHECK(curve_within > 0.88 * curve_all);
  CHECK(curve_within < curve_all);
}
