#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>

#include "core/units.h"
#include "dsp/filter/elliptic.h"
#include "dsp/filter/filter_design.h"

using namespace powbench;
using namespace powbench::dsp;
using Complex = std::complex<double>;

namespace {

/// Reference numbers: scipy 1.10.1, signal.cheby1, cheby2, ellip, butter(..., output="zpk"): poles and finite zeros
/// in the upper half plane and on the axis, gain.
struct Oracle {
  FilterSpec spec;
  std::vector<Complex> poles, zeros;
  double gain;
};

const std::vector<Oracle> oracles{
    {{FilterKind::low, 4, 0, 10000, 100000, false, FilterFamily::chebyshev1, 0.5, 60},
     {{0.7239436013477382, 0.5385622369307533}, {0.7331076561340162, 0.20838029555367607}},
     {},
     0.002477730019945458},
    {{FilterKind::high, 5, 800, 0, 100000, false, FilterFamily::chebyshev1, 0.5, 60},
     {{0.8702411282933548, 0.0},
      {0.9674868320106874, 0.06386737401807097},
      {0.9933852212158151, 0.048805117346469674}},
     {},
     0.9004744870631998},
    {{FilterKind::band, 3, 1000, 10000, 100000, false, FilterFamily::chebyshev1, 0.5, 60},
     {{0.9835085232832634, 0.05732012076070042},
      {0.6887684698977528, 0.5124017954518214},
      {0.8289191021043353, 0.07026389831311661}},
     {},
     0.011614224057123413},
    {{FilterKind::stop, 4, 2000, 4000, 100000, false, FilterFamily::chebyshev1, 0.5, 60},
     {{0.984933079905768, 0.1260547841756974},
      {0.9515847161510425, 0.101141630108999},
      {0.871287737262742, 0.2271743200231753},
      {0.9564425416955668, 0.24156922226545144}},
     {{0.9842294026289555, 0.17689681455766545},
      {0.9842294026289555, 0.17689681455766545},
      {0.9842294026289555, 0.17689681455766545},
      {0.9842294026289555, 0.17689681455766545}},
     0.7940216704159245},
    {{FilterKind::low, 5, 0, 2000, 100000, false, FilterFamily::chebyshev1, 0.5, 60},
     {{0.9781101206336965, 0.12500989593376494},
      {0.9608597225603304, 0.0757295064929002},
      {0.9554256449686634, 0.0}},
     {},
     1.6303859093193064e-07},
    {{FilterKind::low, 1, 0, 5000, 100000, false, FilterFamily::chebyshev1, 0.5, 60},
     {{0.3760656373928688, 0.0}},
     {},
     0.3119671813035656},
    {{FilterKind::low, 4, 0, 10000, 100000, false, FilterFamily::chebyshev2, 0.5, 50},
     {{0.778952338035602, 0.08650799772349702}, {0.8898837452585133, 0.21281462959569694}},
     {{0.16218512313469235, 0.9867603487340705}, {0.7798562711667266, 0.6259586218927967}},
     0.004385072245143642},
    {{FilterKind::high, 5, 800, 0, 100000, false, FilterFamily::chebyshev2, 0.5, 50},
     {{0.9700676481671102, 0.09084353408942361},
      {0.932471852812923, 0.05394936536800075},
      {0.9190233246129615, 0.0}},
     {{0.9988574976192706, 0.04778806806901455}, {0.9995634487972294, 0.029545081292641353}},
     0.8724141173645368},
    {{FilterKind::band, 3, 1000, 10000, 100000, false, FilterFamily::chebyshev2, 0.5, 50},
     {{0.9658243926635666, 0.1446862892892457},
      {0.9168656122942623, 0.1758508222049614},
      {0.9251772361933674, 0.25198910216779236}},
     {{0.7628942450751377, 0.6465232948867625}, {0.9984507722686484, 0.055642208404587744}},
     0.0026807718800095025},
    {{FilterKind::stop, 4, 2000, 4000, 100000, false, FilterFamily::chebyshev2, 0.5, 50},
     {{0.9224235983032281, 0.0719780281642108},
      {0.9775118972368685, 0.07629008591145302},
      {0.8456830773529073, 0.3374395835434429},
      {0.79915062460918, 0.16677476311642064}},
     {{0.9701286637594129, 0.24259096387206208},
      {0.9793633864746885, 0.20210729138957373},
      {0.9879550172726529, 0.1547413449786189},
      {0.9917019354005244, 0.12855843544028536}},
     0.6743167218494261},
    {{FilterKind::low, 5, 0, 2000, 100000, false, FilterFamily::chebyshev2, 0.5, 50},
     {{0.9277473717714785, 0.0},
      {0.9464370917355712, 0.04329228423347912},
      {0.9806969964721106, 0.06167150946954632}},
     {{0.9773457828307744, 0.21164881474485214}, {0.9912858553280967, 0.13172833038661025}},
     0.0009061924376105449},
    {{FilterKind::low, 1, 0, 5000, 100000, false, FilterFamily::chebyshev2, 0.5, 50},
     {{0.9989987853031659, 0.0}},
     {},
     0.0005006073484170324},
    {{FilterKind::low, 4, 0, 10000, 100000, false, FilterFamily::elliptic, 0.5, 60},
     {{0.7256962113775918, 0.21758282888958005}, {0.7290951272357428, 0.5434529817940444}},
     {{-0.6594686746971382, 0.751732044742806}, {0.06323030273680026, 0.9979989623320319}},
     0.006862527684185192},
    {{FilterKind::high, 5, 800, 0, 100000, false, FilterFamily::elliptic, 0.5, 60},
     {{0.882512625238791, 0.0},
      {0.9716013293427845, 0.06115486152245485},
      {0.9943510800186889, 0.049007997181630625}},
     {{0.9998440949918304, 0.017657454798687487}, {0.9996316941159222, 0.027138093502152395}},
     0.9112194824290355},
    {{FilterKind::band, 3, 1000, 10000, 100000, false, FilterFamily::elliptic, 0.5, 60},
     {{0.9837607555518256, 0.057355840311335934},
      {0.8275150853431114, 0.0663076610607038},
      {0.6899904423828328, 0.5143276780864485}},
     {{-0.5754104736013533, 0.8178647729728102}, {0.9999438006900413, 0.010601672582911524}},
     0.015009679990778426},
    {{FilterKind::stop, 4, 2000, 4000, 100000, false, FilterFamily::elliptic, 0.5, 60},
     {{0.9527152555573778, 0.10333696072251808},
      {0.9854674776256844, 0.12606594006229319},
      {0.8767750203434727, 0.22729330592247618},
      {0.9573617947497103, 0.2420232182238894}},
     {{0.9857852184355895, 0.16801042561072466},
      {0.9876425757889985, 0.15672313960890388},
      {0.9825048021575282, 0.1862372512076904},
      {0.9798830379308962, 0.19957262331120973}},
     0.8013104601772433},
    {{FilterKind::low, 5, 0, 2000, 100000, false, FilterFamily::elliptic, 0.5, 60},
     {{0.9505699060465629, 0.0},
      {0.9608718585208591, 0.08194124624040937},
      {0.9806011986904827, 0.12543440647965415}},
     {{0.9378248236508213, 0.347108916832031}, {0.9732034028454201, 0.22994594297376805}},
     0.0004926219434676732},
    {{FilterKind::low, 1, 0, 5000, 100000, false, FilterFamily::elliptic, 0.5, 60},
     {{0.3760656373928689, 0.0}},
     {},
     0.3119671813035655},
    {{FilterKind::band, 4, 50, 500, 1e+06, false, FilterFamily::elliptic, 0.5, 60},
     {{0.9997474803736096, 0.0004384821147829067},
      {0.9999599068011118, 0.00030471551956246586},
      {0.9990261212426275, 0.0016886271402464278},
      {0.9995765993250479, 0.003182500491309675}},
     {{0.9998145234378127, 0.01925925031820872},
      {0.9999656620312862, 0.008287023490468169},
      {0.9999999986871626, 5.1241336704470857e-05},
      {0.9999999929081724, 0.00011909515068742564}},
     0.000998424286044891},
    {{FilterKind::band, 4, 50, 500, 1e+06, false, FilterFamily::chebyshev2, 0.5, 50},
     {{0.9998947987226915, 0.0005920148537377728},
      {0.9996126217648678, 0.0006475673070675888},
      {0.999328638995436, 0.001121687872510733},
      {0.9997120493311709, 0.0016156262066287005}},
     {{0.9999717274827442, 0.007519590093638805},
      {0.9999943733268991, 0.0033545960326547275},
      {0.9999999567199946, 0.0002942108237028388},
      {0.9999999913866994, 0.00013125014681510884}},
     0.003157746427238959},
    {{FilterKind::band, 8, 50, 500, 1e+06, false, FilterFamily::butterworth, 0.5, 60},
     {{0.999616018609123, 0.00010561674228797802},
      {0.9997294341026527, 0.00023478842240664784},
      {0.9998444074583304, 0.0002902715631511455},
      {0.999949328924156, 0.0003117033956991378},
      {0.9994943893495535, 0.003083274570674202},
      {0.9985822433600761, 0.0026375050954703387},
      {0.997920184343548, 0.0018019391318149988},
      {0.9976135771344129, 0.000655695201993789}},
     {},
     1.5839968073167177e-23},
    {{FilterKind::low, 8, 0, 100, 1e+06, false, FilterFamily::elliptic, 0.5, 60},
     {{0.9998102713361298, 0.000186839432262597},
      {0.9998894976311871, 0.000461176371043261},
      {0.9999544943017312, 0.0005873281976297787},
      {0.9999883330476993, 0.0006302224716212148}},
     {{0.999996660617384, 0.0025843285551010245},
      {0.9999994876290897, 0.0010122951930385026},
      {0.999999701042739, 0.0007732492692305534},
      {0.9999997462925113, 0.0007123306207141346}},
     0.0009996450963606347},
    {{FilterKind::stop, 5, 48, 52, 10000, false, FilterFamily::butterworth, 0.5, 60},
     {{0.9991702198724319, 0.030200117092080727},
      {0.9985387344941443, 0.030609198789425432},
      {0.9982529072847063, 0.03132111052834439},
      {0.9984446604483964, 0.03208273880541271},
      {0.9990656663776993, 0.03258734871508657}},
     {{0.9995073495449984, 0.031385636930481714},
      {0.9995073495449984, 0.031385636930481714},
      {0.9995073495449984, 0.031385636930481714},
      {0.9995073495449984, 0.031385636930481714},
      {0.9995073495449984, 0.031385636930481714}},
     0.9959416929990151},
};

double nearest(const std::vector<Complex>& all, Complex p) {
  double d = 1e9;
  for (const Complex q : all) d = std::min(d, std::abs(p - q));
  return d;
}

double loss_db(const std::vector<Section>& s, double hertz, double rate, bool two_pass) {
  return (two_pass ? -20 : -10) * std::log10(std::norm(response(s, hertz, rate)));
}

}  // namespace

TEST_CASE("poles, zeros and gain of every family agree with the reference to 1e-12") {
  for (const Oracle& o : oracles) {
    CAPTURE(static_cast<int>(o.spec.family), static_cast<int>(o.spec.kind), o.spec.order);
    const Zpk z = design_zpk(o.spec);
    const bool two = o.spec.kind == FilterKind::band || o.spec.kind == FilterKind::stop;
    REQUIRE(z.poles.size() == static_cast<std::size_t>(o.spec.order * (two ? 2 : 1)));
    for (const Complex p : o.poles) {
      CHECK(nearest(z.poles, p) < 1e-12);
      CHECK(nearest(z.poles, std::conj(p)) < 1e-12);
    }
    for (const Complex p : o.zeros) {
      CHECK(nearest(z.zeros, p) < 1e-12);
      CHECK(nearest(z.zeros, std::conj(p)) < 1e-12);
    }
    CHECK(std::abs(z.gain / o.gain - 1) < 1e-12);
  }
}

TEST_CASE("the sections of every family are the same filter as its zeros, poles and gain") {
  for (const Oracle& o : oracles) {
    CAPTURE(static_cast<int>(o.spec.family), static_cast<int>(o.spec.kind), o.spec.order);
    const Zpk z = design_zpk(o.spec);
    const auto sections = to_sections(o.spec);
    CHECK(sections.size() == (z.poles.size() + 1) / 2);
    if (o.spec.low_hertz + o.spec.high_hertz < 1e-2 * o.spec.rate)
      continue;  // the product form cannot judge these
    for (const double f : {0.004, 0.01, 0.03, 0.1, 0.3}) {
      const Complex at = std::polar(1.0, 2 * pi * f);
      Complex h = z.gain;
      for (const Complex p : z.poles) h /= at - p;
      for (const Complex p : z.zeros) h *= at - p;
      CHECK(std::abs(response(sections, f * o.spec.rate, o.spec.rate) - h) < 1e-11);
    }
  }
}

TEST_CASE("ripple and stop band are where they were asked for, also after two passes") {
  for (const bool two_pass : {false, true})
    for (const int order : {3, 4, 7})
      for (const FilterFamily family :
           {FilterFamily::chebyshev1, FilterFamily::chebyshev2, FilterFamily::elliptic}) {
        CAPTURE(two_pass, order, static_cast<int>(family));
        const double edge = family == FilterFamily::chebyshev2 ? 50 : 0.5;
        const FilterSpec low{FilterKind::low, order, 0, 9e3, 100e3, two_pass, family, 0.5, 50};
        CHECK(loss_db(to_sections(low), 9e3, 100e3, two_pass) == Approx(edge).epsilon(1e-9));
        const FilterSpec band{FilterKind::band, order, 30, 900, 1e6, two_pass, family, 0.5, 50};
        CHECK(loss_db(to_sections(band), 30, 1e6, two_pass) == Approx(edge).epsilon(1e-9));
        CHECK(loss_db(to_sections(band), 900, 1e6, two_pass) == Approx(edge).epsilon(1e-9));
        const auto s = to_sections(low);
        for (double f = 10; f < 9e3 && family != FilterFamily::chebyshev2; f += 97)
          CHECK(loss_db(s, f, 100e3, two_pass) < 0.5 + 1e-9);
        if (family != FilterFamily::elliptic) continue;
        double least = 1e9;  // the stop band of an elliptic filter begins a little above its edge
        for (double f = 30e3; f < 49.9e3; f += 97) least = std::min(least, loss_db(s, f, 100e3, two_pass));
        CHECK(least > 50 - 1e-9);
      }
}

TEST_CASE("elliptic integrals and functions: known values") {
  CHECK(complete_integral(1.0) == Approx(pi / 2).epsilon(1e-15));
  CHECK(complete_integral(std::sqrt(0.5)) == Approx(1.8540746773013719).epsilon(1e-15));
  CHECK(incomplete_integral(1.0, 1.0) == Approx(pi / 4).epsilon(1e-15));
  CHECK(incomplete_integral(1e9, std::sqrt(0.5)) ==
        Approx(1.8540746773013719 - 1e-9 / std::sqrt(0.5)).epsilon(1e-14));
  const Modulus m{std::sqrt(0.5), std::sqrt(0.5)};
  const Jacobi half = jacobi(1.8540746773013719 / 2, m);  // sn^2(K / 2) = 1 / (1 + kc)
  CHECK(half.sn * half.sn == Approx(1 / (1 + m.kc)).epsilon(1e-15));
  CHECK(half.sn * half.sn + half.cn * half.cn == Approx(1).epsilon(1e-15));
  CHECK(half.dn * half.dn == Approx(m.kc).epsilon(1e-15));
  const Modulus lemniscate = modulus_from_ratio(1.0);
  CHECK(lemniscate.k == Approx(std::sqrt(0.5)).epsilon(1e-15));
  CHECK(lemniscate.kc == Approx(std::sqrt(0.5)).epsilon(1e-15));
}

TEST_CASE("impossible filters of the other families are refused") {
  const double nan = std::nan("");
  using F = FilterFamily;
  const auto low = [](F family, double ripple, double stop) {
    return FilterSpec{FilterKind::low, 4, 0, 1e3, 100e3, false, family, ripple, stop};
  };
  CHECK_THROWS_AS(design_zpk(low(F::chebyshev1, 0, 60)), FilterDesignError);
  CHECK_THROWS_AS(design_zpk(low(F::chebyshev1, nan, 60)), FilterDesignError);
  CHECK_THROWS_AS(design_zpk(low(F::chebyshev2, 1, -3)), FilterDesignError);
  CHECK_THROWS_AS(design_zpk(low(F::chebyshev2, 1, nan)), FilterDesignError);
  CHECK_THROWS_AS(design_zpk(low(F::elliptic, 3, 2)), FilterDesignError);
  CHECK_THROWS_WITH(design_zpk(low(F::elliptic, 30, 60)),
                    Catch::Contains("ripple_db") && Catch::Contains("20 dB"));
}
