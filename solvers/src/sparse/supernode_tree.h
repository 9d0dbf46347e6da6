#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace dn::sparse {

/// Supernodal layout of a Cholesky factor. Supernode s has the columns column[s] .. column[s + 1]
/// and the rows row[row_start[s]] .. row[row_start[s + 1]], which start with its own columns. Its
/// values are dense and column-major, from value_start[s] of num_values.
struct SupernodalPattern {
  std::vector<int> column, row_start, value_start, row;
  std::size_t num_values = 0;

  int num_supernodes() const { return static_cast<int>(value_start.size()); }
  int columns(int s) const { return column[At(s) + 1] - column[At(s)]; }
  int rows(int s) const { return row_start[At(s) + 1] - row_start[At(s)]; }
  /// Returns the number of rows below the columns.
  int below(int s) const { return rows(s) - columns(s); }
  const int* row_indices(int s) const { return row.data() + row_start[At(s)]; }
  const int* row_indices_below(int s) const { return row_indices(s) + columns(s); }

 private:
  static std::size_t At(int s) { return static_cast<std::size_t>(s); }
};

/// Dependencies between supernodes (elimination tree). The parent of s owns the first row of s
/// below its columns, and s depends only on its descendants and affects only its ancestors.
/// Branches without a common supernode can be processed in parallel.
class SupernodeTree {
 public:
  /// Builds the tree of supernodes in postorder: a branch is contiguous, with its root last.
  explicit SupernodeTree(const SupernodalPattern& L);

  std::span<const int> children(int s) const;  ///< ascending
  int column_owner(int c) const { return column_owner_[static_cast<std::size_t>(c)]; }

  /// Work for supernode s with the given number of threads.
  using Work = std::function<void(int s, int threads)>;

  /// Calls `work` for every supernode, the parent before its children.
  void Down(int threads, const Work& work) const;

 private:
  /// A branch: the supernodes first .. root.
  struct Branch {
    int first = 0;
    int root = 0;
    double operations = 0.0;
  };

  void FindChildren(const SupernodalPattern& L);
  void FindBranches(const SupernodalPattern& L);

  std::vector<int> column_owner_;
  /// Children of s: child_[first_child_[s]] .. child_[first_child_[s + 1]].
  std::vector<int> first_child_, child_;
  std::vector<Branch> branches_;  ///< in descending order of operations
  std::vector<int> trunk_;        ///< supernodes outside of all branches, ascending
};

}  // namespace dn::sparse
