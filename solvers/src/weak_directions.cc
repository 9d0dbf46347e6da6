#include <dn/error.h>
#include <dn/solvers/weak_directions.h>

#include <cmath>
#include <string>

#include "marginals_impl.h"
#include "rank.h"
#include "sparse/sparse.h"

namespace dn {

std::vector<WeakDirection> WeakDirections(const Marginals& marginals, int k) {
  if (k < 1) {
    throw InvalidInput("weak directions: the number of directions is " + std::to_string(k) +
                       ", must be at least 1");
  }
  const Marginals::Impl& impl = marginals.impl();
  if (impl.layout().size() == 0) return {};
  const sparse::SerialBlas serial;
  const ScaledDirections found =
      FindWeakestDirections(impl.network().linearization, impl.scale, *impl.cholesky, k);
  std::vector<WeakDirection> directions;
  for (Eigen::Index i = 0; i < found.information.size(); ++i) {
    WeakDirection direction;
    direction.information = found.information[i];
    const Eigen::VectorXd one_sigma =
        impl.scale.cwiseProduct(found.v.col(i)) / std::sqrt(direction.information);
    for (const BlockId block : impl.layout().blocks) {
      direction.one_sigma[block] = one_sigma.segment(marginals.linearized().FirstColumn(block),
                                                     impl.block(block).kind.tangent_size);
    }
    direction.shares = ComputeUnknownShares(impl.network(), found.v.col(i));
    direction.text = DescribeShares(direction.shares);
    directions.push_back(std::move(direction));
  }
  return directions;
}

}  // namespace dn
