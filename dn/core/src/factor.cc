#include <dn/factor.h>

#include <algorithm>

namespace dn {

bool EvaluateStored(const FactorBase& factor, double const* const* x, double* r, double** J) {
  const std::vector<BlockKind>& kinds = factor.block_kinds();
  const int rows = factor.residual_size();
  std::fill_n(r, rows, UnwrittenNan());
  for (std::size_t i = 0; J != nullptr && i < kinds.size(); ++i) {
    if (J[i] != nullptr) std::fill_n(J[i], rows * kinds[i].stored_size, UnwrittenNan());
  }
  return factor.Evaluate(x, r, J);
}

bool EvaluateInTangent(const FactorBase& factor, const std::vector<const double*>& x,
                       Eigen::VectorXd* r, std::vector<Eigen::MatrixXd>* J) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const std::vector<BlockKind>& kinds = factor.block_kinds();
  r->setConstant(factor.residual_size(), UnwrittenNan());
  if (J == nullptr) return factor.Evaluate(x.data(), r->data(), nullptr);
  std::vector<RowMajor> stored;
  std::vector<double*> stored_data;
  for (const BlockKind& kind : kinds) {
    stored.push_back(RowMajor::Constant(factor.residual_size(), kind.stored_size, UnwrittenNan()));
  }
  for (RowMajor& matrix : stored) stored_data.push_back(matrix.data());
  if (!factor.Evaluate(x.data(), r->data(), stored_data.data())) return false;
  J->clear();
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    J->emplace_back(factor.residual_size(), kinds[i].tangent_size);
    StoredToTangent(kinds[i], x[i], stored[i], J->back());
  }
  return true;
}

}  // namespace dn
