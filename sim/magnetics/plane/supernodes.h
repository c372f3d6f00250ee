#pragma once

#include <vector>

#include "sim/magnetics/plane/ordering.h"

/// Which columns of a Cholesky factor are worth treating as one block.

namespace powbench::sim {

/// Parent of each column in the elimination tree; -1 at a root.
std::vector<int> elimination_tree(const Pattern&);

/// Entries of each column of L, the diagonal counted.
std::vector<int> column_counts(const Pattern&, const std::vector<int>& parent);

/// How many zeros a block may hold: loops of one matrix want wide blocks, where four lie side by side an entry is a
/// whole vector already, and a zero costs as much as any other.
enum class Joining { eager, sparing };

/// First column of each supernode, and the size of the matrix at the end. Columns of equal structure are joined, then
/// children with their parents where that brings few zeros.
std::vector<int> supernodes(const std::vector<int>& parent, const std::vector<int>& counts, Joining);

}  // namespace powbench::sim
