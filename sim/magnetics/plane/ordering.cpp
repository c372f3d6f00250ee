#include "sim/magnetics/plane/ordering.h"

#include <algorithm>
#include <mutex>
#include <stdexcept>

#include "sim/magnetics/plane/cholmod.h"

namespace powbench::sim {

Pattern pattern_of(int size, const std::vector<int>& lists, int width) {
  std::vector<int> count(static_cast<std::size_t>(size) + 1, 0);
  const auto each = [&](auto&& visit) {
    for (std::size_t at = 0; at + static_cast<std::size_t>(width) <= lists.size();
         at += static_cast<std::size_t>(width))
      for (int a = 0; a < width; ++a)
        for (int b = 0; b < width; ++b) {
          const int i = lists[at + static_cast<std::size_t>(a)];
          const int j = lists[at + static_cast<std::size_t>(b)];
          if (j >= 0 && i > j) visit(i, j);
        }
  };
  each([&](int, int j) { ++count[static_cast<std::size_t>(j) + 1]; });
  for (int j = 0; j < size; ++j)
    count[static_cast<std::size_t>(j) + 1] += count[static_cast<std::size_t>(j)] + 1;
  std::vector<int> raw(static_cast<std::size_t>(count.back()));
  std::vector<int> next(count.begin(), count.end() - 1);
  for (int j = 0; j < size; ++j) raw[static_cast<std::size_t>(next[static_cast<std::size_t>(j)]++)] = j;
  each([&](int i, int j) { raw[static_cast<std::size_t>(next[static_cast<std::size_t>(j)]++)] = i; });
  Pattern p;
  p.size = size;
  p.start.push_back(0);
  for (std::size_t j = 0; j < static_cast<std::size_t>(size); ++j) {
    const auto first = raw.begin() + count[j];
    const auto last = raw.begin() + count[j + 1];
    std::sort(first, last);
    p.row.insert(p.row.end(), first, std::unique(first, last));
    p.start.push_back(static_cast<int>(p.row.size()));
  }
  return p;
}

int position(const Pattern& p, int i, int j) {
  const auto first = p.row.begin() + p.start[static_cast<std::size_t>(j)];
  const auto last = p.row.begin() + p.start[static_cast<std::size_t>(j) + 1];
  return static_cast<int>(std::lower_bound(first, last, i) - p.row.begin());
}

namespace {

/// What CHOLMOD makes of a pattern: of `given` (new to old), or where there is none of the better of two methods.
std::vector<int> analysed(const Pattern& p, int* given) {
  // nested dissection draws from rand(), seeded at its start: two at a time would make the order one of chance
  static std::mutex alone;
  const std::lock_guard lock(alone);
  cholmod_common common;
  cholmod().cholmod_start(&common);
  common.supernodal = CHOLMOD_SIMPLICIAL;
  common.print = 0;
  common.nmethods = given ? 1 : 2;
  common.method[0].ordering = given ? CHOLMOD_GIVEN : CHOLMOD_AMD;
  common.method[1].ordering = CHOLMOD_METIS;
  common.postorder = true;
  cholmod_sparse a{};
  a.nrow = a.ncol = static_cast<std::size_t>(p.size);
  a.nzmax = p.row.size();
  a.p = const_cast<int*>(p.start.data());
  a.i = const_cast<int*>(p.row.data());
  a.stype = -1;
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_PATTERN;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  cholmod_factor* factor = cholmod().cholmod_analyze_p(&a, given, nullptr, 0, &common);
  std::vector<int> order;
  if (factor) {
    const int* const permutation = static_cast<const int*>(factor->Perm);
    order.assign(permutation, permutation + p.size);
  }
  cholmod().cholmod_free_factor(&factor, &common);
  cholmod().cholmod_finish(&common);
  if (order.empty() && p.size > 0) throw std::runtime_error("no memory for the order of elimination");
  return order;
}

}  // namespace

std::vector<int> fill_reducing_order(const Pattern& p) {
  return analysed(p, nullptr);
}

std::vector<int> postordered(const Pattern& p, std::vector<int> order) {
  return analysed(p, order.data());
}

}  // namespace powbench::sim
