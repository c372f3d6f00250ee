#pragma once

#include <Eigen/Core>

#include "dsp/gram.h"

namespace powbench::dsp {

using ColumnsView = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// A^T B, both of the same rows.
inline Eigen::MatrixXd cross(const ColumnsView& a, const ColumnsView& b) {
  const auto set = [](const ColumnsView& m) {
    return ColumnSet{m.data(), static_cast<std::size_t>(m.outerStride()), static_cast<std::size_t>(m.cols())};
  };
  Eigen::MatrixXd c(a.cols(), b.cols());
  cross_products(set(a), set(b), static_cast<std::size_t>(a.rows()), c.data(),
                 static_cast<std::size_t>(a.cols()));
  return c;
}

}  // namespace powbench::dsp
