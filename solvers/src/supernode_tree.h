#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace dn {

/// How a Cholesky factor is laid out by supernodes. Supernode s has the columns column[s] ..
/// column[s + 1] and the rows row[row_start[s]] .. row[row_start[s + 1]], of which the first are its
/// columns; its values are dense, column-major, from value_start[s] of num_values.
struct SupernodalPattern {
  std::vector<int> column, row_start, value_start, row;
  std::size_t num_values = 0;

  int num_supernodes() const { return static_cast<int>(value_start.size()); }
  int columns(int s) const { return column[At(s) + 1] - column[At(s)]; }
  int rows(int s) const { return row_start[At(s) + 1] - row_start[At(s)]; }
  /// Rows below the columns.
  int below(int s) const { return rows(s) - columns(s); }
  const int* row_indices(int s) const { return row.data() + row_start[At(s)]; }
  const int* row_indices_below(int s) const { return row_indices(s) + columns(s); }

 private:
  static std::size_t At(int s) { return static_cast<std::size_t>(s); }
};

/// Which supernodes wait for which: the parent of s owns the first row of s below its columns, and
/// all that s has to do with stands among the ancestors of s. Branches without a supernode in
/// common can be worked on side by side.
class SupernodeTree {
 public:
  /// Of supernodes in postorder: those of a branch stand together, its root last.
  explicit SupernodeTree(const SupernodalPattern& L);

  std::span<const int> children(int s) const;  ///< ascending
  int owner_of_column(int c) const { return owner_of_column_[static_cast<std::size_t>(c)]; }

  /// What is done for supernode s, with so many threads.
  using Work = std::function<void(int s, int threads)>;

  /// Calls work for every supernode, children before their parent.
  void Up(int threads, const Work& work) const;
  /// Calls work for every supernode, the parent before its children.
  void Down(int threads, const Work& work) const;

 private:
  /// The supernodes first .. root.
  struct Branch {
    int first = 0;
    int root = 0;
    double operations = 0.0;
  };

  void FindChildren(const SupernodalPattern& L);
  void FindBranches(const SupernodalPattern& L);

  std::vector<int> owner_of_column_;
  std::vector<int> first_child_, child_;  ///< of s: child_[first_child_[s]] .. first_child_[s + 1]
  std::vector<Branch> branches_;          ///< those with most to do first
  std::vector<int> trunk_;                ///< supernodes of no branch, ascending
};

}  // namespace dn
