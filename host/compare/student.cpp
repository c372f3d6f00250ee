#include "host/compare/student.h"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <stdexcept>

#include "core/normal.h"

namespace powbench::host {

double student_probability(double t, double dof) {
  if (std::isinf(dof)) return std::erf(t / std::sqrt(2.0));
  return 1 - 2 * cdf(complement(boost::math::students_t(dof), t));
}

double coverage_factor(double dof, double probability) {
  if (!(dof > 0)) throw std::invalid_argument("dof: allowed > 0");
  if (!(probability > 0 && probability < 1)) throw std::invalid_argument("probability: allowed 0 < p < 1");
  const double tail = 0.5 * (1 - probability);
  return std::isinf(dof) ? -normal_quantile(tail) : quantile(complement(boost::math::students_t(dof), tail));
}

}  // namespace powbench::host
