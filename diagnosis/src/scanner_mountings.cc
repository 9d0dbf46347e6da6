#include <dn/diagnosis/scanner_mountings.h>
#include <dn/files/scanners.h>
#include <dn/rotation.h>

#include <algorithm>

namespace dn {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The posterior of all mountings: values, joint covariance, and what unmodelled effects change.
class JointMountings {
 public:
  JointMountings(const FlightNetwork& network, const Marginals& marginals,
                 const UnmodelledEffects* effects)
      : network_(network), ids_(MountingUnknowns(network)) {
    const auto size = 3 * static_cast<Index>(ids_.size());
    change_ = VectorXd::Zero(size);
    added_ = MatrixXd::Zero(size, size);
    covariance_.resize(size, size);
    const Marginals::Columns columns = marginals.SolveColumns(ids_);
    for (std::size_t k = 0; k < ids_.size(); ++k) {
      covariance_.middleRows<3>(3 * static_cast<Index>(k)) = columns.Rows(ids_[k]);
    }
    if (effects == nullptr || effects->mountings_covariance.rows() != size) return;
    added_ = effects->mountings_covariance;
    covariance_ += added_;
    if (effects->mountings.size() == size) change_ = effects->mountings;
  }

  bool Has(BlockId id) const { return std::find(ids_.begin(), ids_.end(), id) != ids_.end(); }
  Vector3d Change(BlockId id) const { return change_.segment<3>(Row(id)); }
  Matrix3d Added(BlockId id) const { return added_.block<3, 3>(Row(id), Row(id)); }

  Eigen::Quaterniond Boresight(const ScannerBlocks& scanner) const {
    return Exp(Change(scanner.boresight.id)) * network_.net().Value(scanner.boresight);
  }
  Vector3d LeverArm(const ScannerBlocks& scanner) const {
    return network_.net().Value(scanner.lever_arm) + Change(scanner.lever_arm.id);
  }

  /// Returns the covariance of b - a.
  Matrix3d DifferenceCovariance(BlockId a, BlockId b) const {
    const Index i = Row(a), j = Row(b);
    const Matrix3d cross = covariance_.block<3, 3>(i, j);
    return covariance_.block<3, 3>(i, i) + covariance_.block<3, 3>(j, j) - cross -
           cross.transpose();
  }

 private:
  Index Row(BlockId id) const {
    return 3 * static_cast<Index>(std::find(ids_.begin(), ids_.end(), id) - ids_.begin());
  }

  const FlightNetwork& network_;
  std::vector<BlockId> ids_;
  VectorXd change_;
  MatrixXd added_, covariance_;
};

/// A left perturbation d_b - d_a of the two boresights rotates Exp(theta_a)^-1 Exp(theta_b) by
/// Exp(theta_a)^-1 (d_b - d_a) from the left.
RelativeMounting Relate(const JointMountings& joint, const ScannerBlocks& a,
                        const ScannerBlocks& b) {
  RelativeMounting relative;
  const Eigen::Quaterniond to_a = joint.Boresight(a).conjugate();
  relative.angles_rad = Log(to_a * joint.Boresight(b));
  const Matrix3d R = to_a.toRotationMatrix();
  relative.covariance_rad2 =
      R * joint.DifferenceCovariance(a.boresight.id, b.boresight.id) * R.transpose();
  if (!joint.Has(a.lever_arm.id) || !joint.Has(b.lever_arm.id)) return relative;
  relative.lever_arm_b_m = joint.LeverArm(b) - joint.LeverArm(a);
  relative.lever_arm_covariance_m2 = joint.DifferenceCovariance(a.lever_arm.id, b.lever_arm.id);
  return relative;
}

std::vector<RelativeMounting> RelateAll(const FlightNetwork& network, const JointMountings& joint) {
  const std::vector<ScannerBlocks>& scanners = network.calibration().scanners();
  const FlightConfig& config = network.flight().config;
  std::vector<RelativeMounting> all;
  for (std::size_t i = 0; i < scanners.size(); ++i) {
    for (std::size_t j = i + 1; j < scanners.size(); ++j) {
      if (!joint.Has(scanners[i].boresight.id) || !joint.Has(scanners[j].boresight.id)) continue;
      all.push_back(Relate(joint, scanners[i], scanners[j]));
      all.back().from = ScannerAt(config, i).name;
      all.back().to = ScannerAt(config, j).name;
    }
  }
  return all;
}

/// Takes what unmodelled effects change into the boresight of scanner k.
void AddEffects(const UnmodelledEffects& effects, const JointMountings& joint, std::size_t k,
                BlockId id, BoresightResult* boresight) {
  UnmodelledEffects own;
  own.boresight_rad = joint.Change(id);
  own.covariance_rad2 = joint.Added(id);
  if (k < effects.scanner_contributions.size()) {
    own.contributions = effects.scanner_contributions[k];
  }
  AddUnmodelled(own, boresight);
}

ScannerMountings Extract(const Adjustment& adjustment, const Marginals& marginals,
                         const UnmodelledEffects* effects) {
  ScannerMountings out;
  const FlightNetwork& network = *adjustment.network;
  if (MountingUnknowns(network).empty()) return out;
  const JointMountings joint(network, marginals, effects);
  for (std::size_t k = 0; k < network.calibration().scanners().size(); ++k) {
    const BlockId id = network.calibration().scanners()[k].boresight.id;
    if (!joint.Has(id)) continue;
    out.scanners.push_back(
        {ScannerAt(network.flight().config, k).name, ExtractBoresight(adjustment, marginals, k)});
    if (effects != nullptr) {
      AddEffects(*effects, joint, k, id, &out.scanners.back().boresight);
    }
  }
  out.relative = RelateAll(network, joint);
  return out;
}

}  // namespace

std::vector<BlockId> MountingUnknowns(const FlightNetwork& network) {
  std::vector<BlockId> unknowns;
  const std::vector<ScannerBlocks>& scanners = network.calibration().scanners();
  if (scanners.size() < 2 || network.pairs().edges().empty()) return unknowns;
  for (const ScannerBlocks& scanner : scanners) {
    for (const BlockId id : {scanner.boresight.id, scanner.lever_arm.id}) {
      if (!network.net().block(id).held) unknowns.push_back(id);
    }
  }
  return unknowns;
}

ScannerMountings ExtractMountings(const Adjustment& adjustment, const Marginals& marginals,
                                  const ModelCheck* check) {
  const bool with_effects = check != nullptr && check->unmodelled;
  ScannerMountings out =
      Extract(adjustment, marginals, with_effects ? &*check->unmodelled : nullptr);
  if (check == nullptr) return out;
  for (ScannerBoresight& scanner : out.scanners) AddFindings(*check, &scanner.boresight);
  return out;
}

ScannerMountings PredictMountings(const Adjustment& adjustment, const Marginals& marginals,
                                  const UnmodelledEffects& effects) {
  return Extract(adjustment, marginals, &effects);
}

}  // namespace dn
