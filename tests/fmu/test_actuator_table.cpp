#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <sstream>

#include "host/export/actuator_table.h"
#include "host/export/mat_out.h"
#include "sim/specimen/specimen_potential.h"

using namespace powbench;

namespace {

/// W = psi^2 / (2 L(gap)) + k psi^4 / 4 with 1 / L = a + b gap: current and pull are known in closed form.
class Saturable : public sim::MagneticPotential {
 public:
  static constexpr double a = 0.2, b = 500, k = 3;
  bool has_ring() const override { return false; }
  sim::MagneticResponse at(const sim::MagneticState& s) const override {
    sim::MagneticResponse m;
    const double inverse = a + b * s.gap, p = s.psi;
    m.energy = p * p * inverse / 2 + k * p * p * p * p / 4;
    m.current = p * inverse + k * p * p * p;
    m.pull = b * p * p / 2;
    m.current_psi = inverse + 3 * k * p * p;
    m.current_gap = b * p;
    return m;
  }
};

struct Matrix {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;  ///< row by row
  double at(std::size_t r, std::size_t c) const { return values.at(r * columns + c); }
};

/// A reader of its own, by the format's description.
std::map<std::string, Matrix> read_mat(const std::string& bytes) {
  const auto word = [&](std::size_t at) {
    std::uint32_t v = 0;
    std::memcpy(&v, bytes.data() + at, 4);
    return v;
  };
  std::map<std::string, Matrix> all;
  REQUIRE(bytes.substr(124, 4) == std::string("\0\1IM", 4));
  for (std::size_t at = 128; at < bytes.size();) {
    REQUIRE(word(at) == 14);
    const std::size_t end = at + 8 + word(at + 4);
    REQUIRE(end <= bytes.size());
    std::size_t p = at + 8;
    std::vector<std::pair<std::uint32_t, std::string>> parts;
    while (p < end) {
      const std::size_t size = word(p + 4);
      parts.emplace_back(word(p), bytes.substr(p + 8, size));
      p += 8 + (size + 7) / 8 * 8;
    }
    REQUIRE(parts.size() == 4);
    CHECK((parts[0].first == 6 && parts[0].second[0] == 6));
    std::int32_t size[2];
    std::memcpy(size, parts[1].second.data(), 8);
    Matrix m{static_cast<std::size_t>(size[0]), static_cast<std::size_t>(size[1]), {}};
    REQUIRE(parts[3].second.size() == 8 * m.rows * m.columns);
    m.values.resize(m.rows * m.columns);
    for (std::size_t c = 0; c < m.columns; ++c)
      for (std::size_t r = 0; r < m.rows; ++r)
        std::memcpy(&m.values[r * m.columns + c], parts[3].second.data() + 8 * (c * m.rows + r), 8);
    all[parts[2].second] = m;
    at = end;
  }
  return all;
}

}  // namespace

TEST_CASE("the table over current and position is the potential's, and its force the integral of its flux") {
  const double travel = 4e-3, most = 2.5;
  const host::ActuatorTable t = host::actuator_table(Saturable(), most, travel, 41, 31);
  REQUIRE((t.current.size() == 41 && t.position.size() == 31));
  CHECK((t.current.front() == 0 && t.current.back() == most));
  CHECK((t.position.front() == 0 && t.position.back() == travel));
  for (std::size_t i = 0; i < 41; ++i)
    for (std::size_t x = 0; x < 31; ++x) {
      const double psi = t.linkage[t.at(i, x)], gap = travel - t.position[x];
      const double inverse = Saturable::a + Saturable::b * gap;
      REQUIRE(psi * inverse + Saturable::k * psi * psi * psi ==
              Approx(t.current[i]).epsilon(1e-12).margin(1e-14));
      REQUIRE(t.force[t.at(i, x)] == Approx(Saturable::b * psi * psi / 2).margin(1e-14));
      if (i > 0) REQUIRE(t.current[i] > t.current[i - 1]);
      if (x > 0) REQUIRE(t.position[x] > t.position[x - 1]);
    }
  // F = integral of dPhi/dx di, by Simpson on a finer table
  const host::ActuatorTable fine = host::actuator_table(Saturable(), most, travel, 401, 3);
  for (std::size_t x = 0; x < 3; ++x) {
    double sum = 0;
    for (std::size_t i = 1; i < 401; ++i)
      sum += 0.5 * (fine.current[i] - fine.current[i - 1]) *
             (fine.linkage_position[fine.at(i, x)] + fine.linkage_position[fine.at(i - 1, x)]);
    CHECK(sum == Approx(fine.force[fine.at(400, x)]).epsilon(1e-4));
  }
  // derivatives against differences of two tables
  const host::ActuatorTable moved = host::actuator_table(Saturable(), most * 1.0001, travel, 401, 3);
  const std::size_t k = fine.at(400, 1);
  CHECK((moved.linkage[k] - fine.linkage[k]) / (most * 1e-4) ==
        Approx(fine.linkage_current[k]).epsilon(1e-3));
  CHECK((t.linear_error_linkage > 0 && t.linear_error_linkage < 0.02));
  CHECK(t.linear_error_force < 0.02);
  CHECK(host::actuator_table(Saturable(), most, travel, 81, 61).linear_error_force <
        0.4 * t.linear_error_force);
}

TEST_CASE("MAT-file, Modelica text and CSV have the same numbers") {
  sim::Specimen s;
  s.magnet.shaded_share = 0;  // no ring
  const sim::SpecimenPotential potential(s);
  REQUIRE_FALSE(potential.has_ring());
  const host::ActuatorTable t = host::actuator_table(potential, 3, s.core.travel, 21, 11);
  const auto mat = read_mat(host::actuator_mat(t));
  CHECK(mat.at("i").values == t.current);
  CHECK(mat.at("x").values == t.position);
  CHECK((mat.at("i").rows == 1 && mat.at("Phi").rows == 21 && mat.at("Phi").columns == 11));
  CHECK(mat.at("Phi").values == t.linkage);
  CHECK(mat.at("F").values == t.force);
  CHECK(mat.at("dPhi_di").values == t.linkage_current);
  CHECK(mat.at("dPhi_dx").values == t.linkage_position);

  std::istringstream text(host::actuator_modelica(t, "a title"));
  std::string line;
  std::getline(text, line);
  CHECK(line == "#1");
  for (const auto& [name, values] : {std::pair{"flux_linkage", &t.linkage}, {"force", &t.force}}) {
    while (text.peek() == '#') std::getline(text, line);
    std::getline(text, line);
    CHECK(line.starts_with("double " + std::string(name) + "(22,12)"));
    const auto& m = mat.at(name);
    for (std::size_t r = 0; r < 22; ++r)
      for (std::size_t c = 0; c < 12; ++c) {
        double v = -1;
        text >> v;
        REQUIRE(v == m.at(r, c));
        const double expected = r == 0 && c == 0 ? 0
                                : r == 0         ? t.position[c - 1]
                                : c == 0         ? t.current[r - 1]
                                                 : (*values)[t.at(r - 1, c - 1)];
        REQUIRE(v == expected);
      }
    std::getline(text, line);
  }

  std::istringstream rows(host::actuator_csv(t));
  std::getline(rows, line);
  CHECK(line.starts_with("current [A],position [m],flux linkage [Wb],force [N],"));
  std::size_t n = 0;
  double i = 0, x = 0, psi = 0, force = 0;
  char comma = 0;
  for (; std::getline(rows, line); ++n) {
    std::istringstream cells(line);
    cells >> i >> comma >> x >> comma >> psi >> comma >> force;
    REQUIRE(
        (i == t.current[n / 11] && x == t.position[n % 11] && psi == t.linkage[n] && force == t.force[n]));
  }
  CHECK(n == 21 * 11);
}
