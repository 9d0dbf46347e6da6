#include "factor_text.h"

#include <cmath>
#include <cstdio>

namespace dn {

std::string DescribeFactor(const Network& network, FactorId id) {
  const FactorRecord& record = network.factor(id);
  std::string details = network.group(id).name;
  if (std::isfinite(record.t_s)) {
    char time[48];
    std::snprintf(time, sizeof(time), "%s%.3f s", details.empty() ? "" : ", ", record.t_s);
    details += time;
  }
  std::string text = "factor ";
  text += std::to_string(id);
  if (!details.empty()) text.append(" (").append(details).append(")");
  text += " on";
  for (const BlockId b : record.blocks) text.append(" '").append(network.block(b).name).append("'");
  return text;
}

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
  return DescribeFactor(network, id) +
         " is undefined or not finite at the current values; start nearer to the solution or leave "
         "this measurement out";
}

}  // namespace dn
