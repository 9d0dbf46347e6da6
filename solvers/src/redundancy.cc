#include <dn/error.h>
#include <dn/solvers/redundancy.h>

#include <vector>

namespace dn {

Eigen::VectorXd RedundancyNumbers(const Network& network, FactorId factor,
                                  const Marginals& marginals) {
  const FactorRecord& record = network.factor(factor);
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  if (!record.active || !network.EvaluateFactor(factor, &r, &J)) {
    throw InvalidInput("redundancy numbers: factor " + std::to_string(factor) +
                       " is not active or undefined at the present values");
  }
  Eigen::VectorXd fitted = Eigen::VectorXd::Zero(r.size());  // diag(J C J^T)
  for (std::size_t a = 0; a < J.size(); ++a) {
    if (network.block(record.blocks[a]).held) continue;
    fitted += (J[a] * marginals.DiagonalBlock(record.blocks[a])).cwiseProduct(J[a]).rowwise().sum();
    for (std::size_t b = 0; b < a; ++b) {
      if (network.block(record.blocks[b]).held) continue;
      const auto cross = marginals.PatternBlock(record.blocks[a], record.blocks[b]);
      fitted += 2.0 * (J[a] * cross.value()).cwiseProduct(J[b]).rowwise().sum();
    }
  }
  return (1.0 - fitted.array()).cwiseMax(0.0);
}

}  // namespace dn
