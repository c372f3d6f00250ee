#pragma once

#include <vector>

/// Symmetric sparsity and an order of elimination with little fill.

namespace powbench::sim {

/// Lower triangle with its diagonal, by columns: rows of column j are row[start[j] .. start[j + 1]), ascending, the
/// first one is j itself.
struct Pattern {
  int size = 0;
  std::vector<int> start;
  std::vector<int> row;
};

/// The pattern of a matrix that is the sum of dense blocks, one for each list of unknowns; entries < 0 are left out.
/// `lists` holds `width` entries a list.
Pattern pattern_of(int size, const std::vector<int>& lists, int width);

/// Position of entry (i, j) in `row`, i >= j; the entry must exist.
int position(const Pattern&, int i, int j);

/// Order of elimination, new to old, postordered: the better of approximate minimum degree and nested dissection
/// (SuiteSparse). Throws std::runtime_error if the library runs out of memory.
std::vector<int> fill_reducing_order(const Pattern&);

/// An order, new to old, with the same fill, postordered. Throws as that.
std::vector<int> postordered(const Pattern&, std::vector<int> order);

}  // namespace powbench::sim
