#include "host/compare/pair.h"

#include <cmath>

#include "host/compare/compare.h"
#include "host/compare/student.h"

namespace powbench::host {

namespace {

const ComparisonRow* find(const Comparison& c, const ComparisonRow& like) {
  for (const ComparisonRow& r : c.rows)
    if (r.quantity == like.quantity && same_angle(r.closing_angle, like.closing_angle)) return &r;
  return nullptr;
}

PairRow row_of(const ComparisonRow* a, const ComparisonRow* b) {
  const ComparisonRow& any = a != nullptr ? *a : *b;
  PairRow row;
  row.closing_angle = any.closing_angle, row.quantity = any.quantity, row.unit = any.unit;
  if (a != nullptr) row.first = a->measured, row.n[0] = a->repeats, row.k[0] = a->coverage;
  if (b != nullptr) row.second = b->measured, row.n[1] = b->repeats, row.k[1] = b->coverage;
  if (a == nullptr || b == nullptr) return row;
  row.difference = b->measured.value - a->measured.value;
  const double va = a->measured.u * a->measured.u, vb = b->measured.u * b->measured.u;
  if (!std::isfinite(va + vb)) return row;  // of one at least no uncertainty is known
  const double parts =
      (std::isfinite(a->dof) ? va * va / a->dof : 0) + (std::isfinite(b->dof) ? vb * vb / b->dof : 0);
  const double dof = parts > 0 ? (va + vb) * (va + vb) / parts : std::numeric_limits<double>::infinity();
  row.U = coverage_factor(dof) * std::sqrt(va + vb);
  return row;
}

}  // namespace

double PairRow::over_U() const {
  return U > 0 ? std::fabs(difference) / U : std::numeric_limits<double>::quiet_NaN();
}

std::vector<PairRow> compare_pair(const Comparison& first, const Comparison& second) {
  std::vector<PairRow> rows;
  for (const ComparisonRow& a : first.rows) rows.push_back(row_of(&a, find(second, a)));
  for (const ComparisonRow& b : second.rows)
    if (find(first, b) == nullptr) rows.push_back(row_of(nullptr, &b));
  std::erase_if(rows, [](const PairRow& r) { return r.n[0] == 0 && r.n[1] == 0; });
  return rows;
}

}  // namespace powbench::host
