#include "sparse/supernode_tree.h"

#include <algorithm>
#include <queue>

#include "sparse/parallel_for.h"

namespace dn::sparse {
namespace {

/// Branches with more than this fraction of all operations are split.
constexpr double kLargestShare = 1.0 / 16.0;
/// Number of multiplications (some milliseconds) above which several threads are used.
constexpr double kWorthThreads = 2e7;

std::size_t At(int i) { return static_cast<std::size_t>(i); }

/// Returns the number of multiplications of a dense partial factorisation.
double Operations(const SupernodalPattern& L, int s) {
  const double c = L.columns(s), b = L.below(s);
  return c * (c * c / 6.0 + 0.5 * c * b + 0.5 * b * b);
}

}  // namespace

SupernodeTree::SupernodeTree(const SupernodalPattern& L) {
  column_owner_.resize(At(L.column.back()));
  for (int s = 0; s < L.num_supernodes(); ++s) {
    std::fill(column_owner_.begin() + L.column[At(s)], column_owner_.begin() + L.column[At(s) + 1],
              s);
  }
  FindChildren(L);
  FindBranches(L);
}

void SupernodeTree::FindChildren(const SupernodalPattern& L) {
  std::vector<int> parent(At(L.num_supernodes()), -1);
  first_child_.assign(At(L.num_supernodes()) + 1, 0);
  for (int s = 0; s < L.num_supernodes(); ++s) {
    if (L.below(s) == 0) continue;
    parent[At(s)] = column_owner(L.row_indices_below(s)[0]);
    ++first_child_[At(parent[At(s)]) + 1];
  }
  for (std::size_t s = 1; s < first_child_.size(); ++s) first_child_[s] += first_child_[s - 1];
  child_.resize(At(first_child_.back()));
  std::vector<int> next(first_child_.begin(), first_child_.end() - 1);
  for (int s = 0; s < L.num_supernodes(); ++s) {
    if (parent[At(s)] >= 0) child_[At(next[At(parent[At(s)])]++)] = s;
  }
}

std::span<const int> SupernodeTree::children(int s) const {
  return {child_.data() + first_child_[At(s)], child_.data() + first_child_[At(s) + 1]};
}

void SupernodeTree::FindBranches(const SupernodalPattern& L) {
  std::vector<Branch> branch(At(L.num_supernodes()));
  std::vector<bool> is_child(At(L.num_supernodes()), false);
  for (int s = 0; s < L.num_supernodes(); ++s) {
    Branch& all = branch[At(s)] = {s, s, Operations(L, s)};
    for (const int c : children(s)) {
      is_child[At(c)] = true;
      all.first = std::min(all.first, branch[At(c)].first);
      all.operations += branch[At(c)].operations;
    }
  }
  const auto less = [](const Branch& a, const Branch& b) { return a.operations < b.operations; };
  std::priority_queue<Branch, std::vector<Branch>, decltype(less)> open(less);
  double total = 0.0;
  for (int s = 0; s < L.num_supernodes(); ++s) {
    if (is_child[At(s)]) continue;
    open.push(branch[At(s)]);
    total += branch[At(s)].operations;
  }
  if (total < kWorthThreads) {
    for (int s = 0; s < L.num_supernodes(); ++s) trunk_.push_back(s);
    return;
  }
  while (!open.empty() && open.top().operations > kLargestShare * total) {
    const int root = open.top().root;
    open.pop();
    trunk_.push_back(root);
    for (const int c : children(root)) open.push(branch[At(c)]);
  }
  std::sort(trunk_.begin(), trunk_.end());
  for (; !open.empty(); open.pop()) branches_.push_back(open.top());
}

void SupernodeTree::Down(int threads, const Work& work) const {
  for (auto s = trunk_.rbegin(); s != trunk_.rend(); ++s) work(*s, threads);
  ParallelForDynamic(static_cast<int>(branches_.size()), threads, [&](int b) {
    for (int s = branches_[At(b)].root; s >= branches_[At(b)].first; --s) work(s, 1);
  });
}

}  // namespace dn::sparse
