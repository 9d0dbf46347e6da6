#pragma once

#include <dn/solvers/marginals.h>

#include <Eigen/Core>

#include "hypothesis.h"

namespace dn::diagnosis_internal {

/// Returns L X with the columns L of all effects of the library. X has one row per component of the
/// score, the result one per residual.
Eigen::MatrixXd EffectRows(const Library& library, const LinearizedNetwork& linearized,
                           const Eigen::MatrixXd& X);

/// Returns the residuals as they would be if effects of this size were in the model. `effects` are
/// in SI, one value per component of the score.
Eigen::VectorXd ResidualWith(const Library& library, const Marginals& marginals,
                             const Eigen::VectorXd& effects);

}  // namespace dn::diagnosis_internal
