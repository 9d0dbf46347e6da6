#include <dn/error.h>
#include <dn/linear_prior.h>

#include <string>
#include <utility>

namespace dn {
namespace {

struct TotalSizes {
  Eigen::Index stored = 0, tangent = 0;
  explicit TotalSizes(const std::vector<BlockKind>& kinds) {
    for (const BlockKind& kind : kinds) {
      stored += kind.stored_size;
      tangent += kind.tangent_size;
    }
  }
};

}  // namespace

LinearPrior::LinearPrior(std::vector<BlockKind> kinds, Eigen::VectorXd center, Eigen::MatrixXd R,
                         Eigen::VectorXd d, double nonlinearity)
    : DynamicFactor(static_cast<int>(R.rows()), std::move(kinds)),
      center_(std::move(center)),
      R_(std::move(R)),
      d_(std::move(d)),
      nonlinearity_(nonlinearity) {
  const TotalSizes sizes(block_kinds());
  if (center_.size() != sizes.stored || R_.cols() != sizes.tangent || R_.rows() < 1 ||
      d_.size() != R_.rows()) {
    throw InvalidInput(
        "linear prior: a center of " + std::to_string(center_.size()) + " numbers, R of " +
        std::to_string(R_.rows()) + " x " + std::to_string(R_.cols()) + " and d of " +
        std::to_string(d_.size()) + " do not fit blocks of " + std::to_string(sizes.stored) +
        " stored numbers and " + std::to_string(sizes.tangent) + " tangent coordinates");
  }
  if (!center_.allFinite() || !R_.allFinite() || !d_.allFinite()) {
    throw InvalidInput("linear prior: a number of the center, of R or of d is not finite");
  }
}

Eigen::VectorXd LinearPrior::Movement(double const* const* x) const {
  Eigen::VectorXd movement(R_.cols());
  Eigen::Index stored = 0, tangent = 0;
  for (std::size_t i = 0; i < block_kinds().size(); ++i) {
    const BlockKind& kind = block_kinds()[i];
    Minus(kind, x[i], center_.data() + stored, movement.data() + tangent);
    stored += kind.stored_size;
    tangent += kind.tangent_size;
  }
  return movement;
}

bool LinearPrior::Evaluate(double const* const* x, double* r, double** J) const {
  Eigen::Map<Eigen::VectorXd>(r, R_.rows()) = R_ * Movement(x) + d_;
  Eigen::Index stored = 0, tangent = 0;
  for (std::size_t i = 0; J != nullptr && i < block_kinds().size(); ++i) {
    const BlockKind& kind = block_kinds()[i];
    if (J[i] != nullptr) {
      const Eigen::MatrixXd J_r_x = R_.middleCols(tangent, kind.tangent_size) *
                                    MinusJacobian(kind, x[i], center_.data() + stored);
      Put(static_cast<int>(i), x, J, J_r_x);
    }
    stored += kind.stored_size;
    tangent += kind.tangent_size;
  }
  return true;
}

}  // namespace dn
