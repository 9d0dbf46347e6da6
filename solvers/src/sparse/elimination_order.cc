#include "sparse/elimination_order.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "sparse/cholmod_support.h"

namespace dn::sparse {
namespace {

/// Thresholds of estimated operations above which nested dissection can save more time than it
/// takes. They are half a second of factorisation, and ten times the cost of dissection per block.
constexpr double kWorthDissecting = 1e10;
constexpr double kWorthDissectingPerBlock = 2e5;

// METIS uses and seeds the random generator of the C library, which is global.
std::mutex g_metis_mutex;

/// The graph of the blocks as a CHOLMOD matrix.
class Graph {
 public:
  explicit Graph(const SymmetricCsc& blocks) {
    common_->nmethods = 1;
    common_->method[0].ordering = CHOLMOD_GIVEN;
    common_->supernodal = CHOLMOD_SIMPLICIAL;  // sufficient for counting operations
    cholmod_sparse lower = View(blocks);
    // AMD needs the upper triangle.
    upper_ = cholmod_transpose(&lower, 0, common_.get());
    common_.Check("ordering");
  }
  ~Graph() { cholmod_free_sparse(&upper_, common_.get()); }
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;

  std::vector<int> MinimumDegree() {
    std::vector<int> order(upper_->nrow);
    cholmod_amd(upper_, nullptr, 0, order.data(), common_.get());
    common_.Check("ordering");
    return order;
  }

  std::vector<int> Dissection() {
    std::vector<int> order(upper_->nrow), parent(upper_->nrow), member(upper_->nrow);
    const std::lock_guard lock(g_metis_mutex);
    cholmod_nested_dissection(upper_, nullptr, 0, order.data(), parent.data(), member.data(),
                              common_.get());
    common_.Check("ordering");
    return order;
  }

  double Operations(const std::vector<int>& order) {
    cholmod_factor* analysed =
        cholmod_analyze_p(upper_, const_cast<int*>(order.data()), nullptr, 0, common_.get());
    common_.Check("ordering");
    cholmod_free_factor(&analysed, common_.get());
    return 0.5 * common_->fl;
  }

 private:
  CholmodCommon common_;
  cholmod_sparse* upper_ = nullptr;
};

}  // namespace

double EliminationOrder::operations(int unknowns) const {
  if (position.empty()) return 0.0;
  return block_operations * std::pow(unknowns / static_cast<double>(position.size()), 3);
}

EliminationOrder FindEliminationOrder(const SymmetricCsc& blocks, int unknowns) {
  EliminationOrder best;
  if (blocks.n == 0) return best;
  Graph graph(blocks);
  best.position = graph.MinimumDegree();
  best.block_operations = graph.Operations(best.position);
  const double worth = std::max(kWorthDissecting, kWorthDissectingPerBlock * blocks.n);
  if (best.operations(unknowns) < worth) return best;
  EliminationOrder dissected{graph.Dissection(), 0.0, true};
  dissected.block_operations = graph.Operations(dissected.position);
  return dissected.block_operations < best.block_operations ? dissected : best;
}

}  // namespace dn::sparse
