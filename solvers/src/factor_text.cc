#include "factor_text.h"

#include <vector>

namespace dn {
namespace {

bool HasUnwritten(const Eigen::Ref<const Eigen::MatrixXd>& values) {
  return values.unaryExpr([](double value) { return IsUnwritten(value); }).any();
}

/// Returns, for example, "row 1 of its 3 residuals" if the factor reports success but does not
/// write that part. Returns an empty string if everything is written.
std::string UnwrittenPart(const Network& network, FactorId id) {
  const FactorRecord& record = network.factor(id);
  const auto rows = static_cast<Eigen::Index>(record.factor->residual_size());
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> stored;
  std::vector<const double*> x;
  std::vector<double*> J;
  for (const BlockId b : record.blocks) {
    x.push_back(network.block(b).value.get());
    stored.emplace_back(rows, network.block(b).kind.stored_size);
    J.push_back(stored.back().data());
  }
  for (std::size_t i = 0; i < J.size(); ++i) J[i] = stored[i].data();
  Eigen::VectorXd r(rows);
  if (!network.EvaluateStored(id, x.data(), r.data(), J.data())) return "";
  for (Eigen::Index row = 0; row < rows; ++row) {
    if (IsUnwritten(r[row])) {
      return "row " + std::to_string(row) + " of its " + std::to_string(rows) +
             " residuals (rows count from 0)";
    }
  }
  for (std::size_t i = 0; i < stored.size(); ++i) {
    if (HasUnwritten(stored[i])) {
      return "its Jacobian of block '" + network.block(record.blocks[i]).name + "'";
    }
  }
  return "";
}

}  // namespace

FactorId FindUndefinedFactor(const Network& network) {
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    if (!network.factor(id).active) continue;
    if (!network.EvaluateFactor(id, &r, &J) || !r.allFinite()) return id;
    for (const Eigen::MatrixXd& block : J) {
      if (!block.allFinite()) return id;
    }
  }
  return -1;
}

std::string UndefinedFactorMessage(const Network& network, FactorId id) {
  const std::string where = network.DescribeFactor(id);
  const std::string unwritten = UnwrittenPart(network, id);
  if (!unwritten.empty()) {
    return where + " does not write " + unwritten + ": correct its residual function";
  }
  return where +
         " is undefined or not finite at the current values; start nearer to the solution or leave "
         "this measurement out";
}

}  // namespace dn
