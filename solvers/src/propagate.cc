#include <dn/solvers/propagate.h>

namespace dn {

Eigen::MatrixXd Joint(const Marginals& marginals, const std::vector<BlockId>& blocks) {
  const Marginals::Columns columns = marginals.SolveColumns(blocks);
  std::vector<Eigen::MatrixXd> rows;
  Eigen::Index size = 0;
  for (const BlockId block : blocks) {
    rows.push_back(columns.Rows(block));
    size += rows.back().rows();
  }
  Eigen::MatrixXd covariance(size, size);
  Eigen::Index first = 0;
  for (const Eigen::MatrixXd& of_block : rows) {
    covariance.middleRows(first, of_block.rows()) = of_block;
    first += of_block.rows();
  }
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace dn
