#include "sim/magnetics/space/cholesky.h"

#include <cassert>
#include <cstring>
#include <new>

#include "sim/magnetics/plane/cholmod.h"

namespace powbench::sim::space {
namespace {

/// Keeps this thread's factorisations on it. CHOLMOD asks OpenMP for four threads for every supernode, however many
/// cores there are: with blocks of this size they wait for each other longer than they work.
void stay_on_this_thread() {
  if (cholmod().omp_set_max_active_levels) cholmod().omp_set_max_active_levels(0);
}

}  // namespace

void SymmetricMatrix::multiply(const std::vector<double>& x, std::vector<double>& y) const {
  const int n = size();
  y.assign(static_cast<std::size_t>(n), 0);
  for (int c = 0; c < n; ++c) {
    double sum = 0;
    const double xc = x[c];
    int k = start[c];
    y[c] += value[k++] * xc;
    for (; k < start[c + 1]; ++k) {
      y[row[k]] += value[k] * xc;
      sum += value[k] * x[row[k]];
    }
    y[c] += sum;
  }
}

struct Cholesky::Impl {
  cholmod_common common;
  cholmod_factor* factor = nullptr;

  Impl() {
    cholmod().cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.print = 0;
    common.try_catch = 1;  // a matrix that is not positive definite is told by the return value
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_METIS;
    common.postorder = 1;
  }
  ~Impl() {
    cholmod().cholmod_free_factor(&factor, &common);
    cholmod().cholmod_finish(&common);
  }

  /// CHOLMOD's view of the matrix; it is not changed through it.
  static cholmod_sparse view(const SymmetricMatrix& m) {
    cholmod_sparse s{};
    s.nrow = s.ncol = static_cast<std::size_t>(m.size());
    s.nzmax = m.row.size();
    s.p = const_cast<int*>(m.start.data());
    s.i = const_cast<int*>(m.row.data());
    s.x = const_cast<double*>(m.value.data());
    s.stype = -1;
    s.itype = CHOLMOD_INT;
    s.xtype = CHOLMOD_REAL;
    s.dtype = CHOLMOD_DOUBLE;
    s.sorted = 1;
    s.packed = 1;
    return s;
  }
};

Cholesky::Cholesky(const SymmetricMatrix& pattern) : impl_(std::make_unique<Impl>()) {
  auto view = Impl::view(pattern);
  impl_->factor = cholmod().cholmod_analyze(&view, &impl_->common);
  if (!impl_->factor) throw std::bad_alloc();
}

Cholesky::~Cholesky() = default;

bool Cholesky::factor(const SymmetricMatrix& matrix) {
  stay_on_this_thread();
  auto view = Impl::view(matrix);
  cholmod().cholmod_factorize(&view, impl_->factor, &impl_->common);
  if (impl_->common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  return impl_->common.status == CHOLMOD_OK;
}

std::vector<double> Cholesky::solve(const std::vector<double>& b) const {
  cholmod_dense right{};
  right.nrow = right.d = impl_->factor->n;
  right.ncol = b.size() / right.nrow;
  right.nzmax = b.size();
  right.x = const_cast<double*>(b.data());
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* x = cholmod().cholmod_solve(CHOLMOD_A, impl_->factor, &right, &impl_->common);
  if (!x) throw std::bad_alloc();
  std::vector<double> out(b.size());
  std::memcpy(out.data(), x->x, b.size() * sizeof(double));
  cholmod().cholmod_free_dense(&x, &impl_->common);
  return out;
}

}  // namespace powbench::sim::space
