#include "effect_rows.h"

#include <cmath>

namespace dn::diagnosis_internal {

Eigen::MatrixXd EffectRows(const Library& library, const LinearizedNetwork& linearized,
                           const Eigen::MatrixXd& X) {
  Eigen::MatrixXd added = Eigen::MatrixXd::Zero(linearized.rows(), X.cols());
  Eigen::Index first = 0;
  for (const EffectModel& block : library.blocks) {
    const Eigen::Index size = block.empty() ? 0 : block.front().L.cols();
    const Eigen::MatrixXd value = X.middleRows(first, size);
    first += size;
    if (value.isZero(0.0)) continue;
    for (const EffectPart& part : block) {
      const auto rows = linearized.FindRows(part.factor);
      if (!rows) continue;
      added.middleRows(rows->first, rows->count) += std::sqrt(rows->weight) * part.L * value;
    }
  }
  return added;
}

Eigen::VectorXd ResidualWith(const Library& library, const Marginals& marginals,
                             const Eigen::VectorXd& effects) {
  const LinearizedNetwork& linearized = marginals.linearized();
  if (effects.isZero(0.0)) return linearized.residual();
  return linearized.residual() + marginals.Project(EffectRows(library, linearized, effects));
}

}  // namespace dn::diagnosis_internal
