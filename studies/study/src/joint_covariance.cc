#include "joint_covariance.h"

#include <dn/adjustment/bias_correlation.h>
#include <dn/axis_names.h>
#include <dn/effects/effect_table.h>
#include <dn/geo/local_frame.h>

#include <cmath>

namespace dn {
namespace {

const char* const kBoresight = "boresight";

/// Numbers that are a sum over blocks, each multiplied by its own matrix.
struct Quantity {
  std::string name;
  std::vector<std::string> components;
  std::string unit;
  double per_si = 1.0;
  bool calibration = false;
  std::vector<std::pair<BlockId, Eigen::MatrixXd>> blocks;
};

std::vector<std::string> ComponentNames(const std::string& unknown, int size) {
  if (IsBoresight({.unknown = unknown})) return AxisNames(kRollPitchYaw);
  if (size == 1) return {""};
  std::vector<std::string> names;
  if (const EffectSpec* effect = FindEffect(unknown)) {
    for (const EffectComponent& component : effect->components) names.push_back(component.name);
  }
  names.resize(static_cast<std::size_t>(size));
  return names;
}

std::vector<Quantity> Calibration(const FlightNetwork& network) {
  std::vector<Quantity> quantities;
  const auto add = [&](const std::string& unknown) {
    const BlockId id = network.net().Find(unknown);
    const BlockRecord& record = network.net().block(id);
    const int size = record.kind.tangent_size;
    quantities.push_back({unknown,
                          ComponentNames(unknown, size),
                          record.label.unit,
                          record.label.per_si,
                          true,
                          {{id, Eigen::MatrixXd::Identity(size, size)}}});
  };
  add(kBoresight);
  for (const EstimateEntry& entry : network.flight().config.estimate) {
    if (entry.unknown != kBoresight) add(entry.unknown);
  }
  return quantities;
}

/// Appends the sum of chains at a time; scale(chain) maps a block to the quantity.
template <class Scale>
void AppendTotal(const std::vector<ProcessChain>& chains, double t_s, Quantity quantity,
                 const Scale& scale, std::vector<Quantity>* quantities) {
  if (chains.empty()) return;
  for (std::size_t k = 0; k < chains.size(); ++k) {
    quantity.blocks.emplace_back(chains[k].At(t_s).id, scale(k));
  }
  quantities->push_back(std::move(quantity));
}

std::vector<Quantity> ListCorrelatedErrors(const FlightNetwork& network) {
  constexpr double kDegPerHour = kDegPerRad * 3600.0;
  const double mg = 1e3 / kStandardGravityMps2;
  const double t_s = LidarBarycentre(network);
  const auto as_is = [](std::size_t) { return Eigen::MatrixXd::Identity(3, 3).eval(); };
  std::vector<Quantity> all;
  AppendTotal(network.trajectory().gyro_bias(), t_s,
              {"gyro_bias", AxisNames(kXyz), "deg/h", kDegPerHour, false, {}}, as_is, &all);
  AppendTotal(network.trajectory().accel_bias(), t_s,
              {"accel_bias", AxisNames(kXyz), "mg", mg, false, {}}, as_is, &all);
  const auto in_sigmas = [&](std::size_t k) {
    return Eigen::MatrixXd(network.trajectory().GnssErrorSigmaEnu(k, t_s).asDiagonal());
  };
  AppendTotal(network.trajectory().gnss_error(), t_s,
              {"gnss_error", AxisNames(kEnu), "m", 1.0, false, {}}, in_sigmas, &all);
  return all;
}

std::vector<BlockId> ListBlocks(const std::vector<Quantity>& quantities) {
  std::vector<BlockId> blocks;
  for (const Quantity& quantity : quantities) {
    for (const auto& [block, scale] : quantity.blocks) blocks.push_back(block);
  }
  return blocks;
}

/// Returns the matrix that maps all blocks, stacked, to all quantities.
Eigen::MatrixXd Sums(const std::vector<Quantity>& quantities) {
  Eigen::Index rows = 0, columns = 0;
  for (const Quantity& quantity : quantities) {
    rows += static_cast<Eigen::Index>(quantity.components.size());
    for (const auto& [block, scale] : quantity.blocks) columns += scale.cols();
  }
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(rows, columns);
  Eigen::Index row = 0, column = 0;
  for (const Quantity& quantity : quantities) {
    for (const auto& [block, scale] : quantity.blocks) {
      sums.block(row, column, scale.rows(), scale.cols()) = scale;
      column += scale.cols();
    }
    row += static_cast<Eigen::Index>(quantity.components.size());
  }
  return sums;
}

JointCovariance ComputeJointCovariance(const std::vector<Quantity>& quantities,
                                       const Marginals& marginals) {
  const std::vector<BlockId> blocks = ListBlocks(quantities);
  const Marginals::Columns columns = marginals.SolveColumns(blocks);
  const Eigen::MatrixXd sums = Sums(quantities);
  Eigen::MatrixXd covariance(sums.cols(), sums.cols());
  Eigen::Index row = 0;
  for (const BlockId block : blocks) {
    const Eigen::MatrixXd rows = columns.Rows(block);
    covariance.middleRows(row, rows.rows()) = rows;
    row += rows.rows();
  }
  JointCovariance joint;
  for (const Quantity& quantity : quantities) {
    for (const std::string& component : quantity.components) {
      const std::string suffix = component.empty() ? "" : "_" + component;
      joint.unknowns.push_back(
          {quantity.name + suffix, quantity.unit, quantity.per_si, quantity.calibration});
    }
  }
  joint.covariance = sums * covariance * sums.transpose();
  joint.covariance = 0.5 * (joint.covariance + joint.covariance.transpose()).eval();
  return joint;
}

/// Removes quantities without variance, such as an axis on which a GNSS process has no error.
JointCovariance WithoutConstants(const JointCovariance& joint) {
  JointCovariance kept;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < joint.covariance.rows(); ++i) {
    if (!(joint.covariance(i, i) > 0.0)) continue;
    kept.unknowns.push_back(joint.unknowns[static_cast<std::size_t>(i)]);
    rows.push_back(i);
  }
  kept.covariance = joint.covariance(rows, rows);
  return kept;
}

}  // namespace

double JointCovariance::sigma(Eigen::Index i) const { return std::sqrt(covariance(i, i)); }

double JointCovariance::correlation(Eigen::Index i, Eigen::Index j) const {
  return covariance(i, j) / (sigma(i) * sigma(j));
}

JointCovariance CalibrationCovariance(const FlightNetwork& network, const Marginals& marginals) {
  return ComputeJointCovariance(Calibration(network), marginals);
}

JointCovariance CovarianceWithErrors(const FlightNetwork& network, const Marginals& marginals) {
  std::vector<Quantity> quantities = Calibration(network);
  for (Quantity& quantity : ListCorrelatedErrors(network))
    quantities.push_back(std::move(quantity));
  return WithoutConstants(ComputeJointCovariance(quantities, marginals));
}

}  // namespace dn
