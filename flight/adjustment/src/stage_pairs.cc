#include <dn/adjustment/stages.h>
#include <dn/builder/use_surface.h>
#include <dn/builder/use_survey.h>
#include <dn/files/pair_clock.h>
#include <dn/files/scanners.h>
#include <dn/geo/text_table.h>
#include <dn/navigation/robust_scale.h>

#include <algorithm>

#include "expect_pairs.h"
#include "robust_loss_of.h"

namespace dn {
namespace {

const Loss kUsualPairLoss{Loss::Type::kCauchy, 3.0};
constexpr int kRobustIterations = 6;

void ExpectSeveralEpochs(const std::vector<LidarPair>& pairs) {
  const bool one = std::all_of(pairs.begin(), pairs.end(), [&](const LidarPair& pair) {
    return pair.t_i_s == pairs[0].t_i_s && pair.t_j_s == pairs[0].t_j_s;
  });
  if (!one) return;
  throw InvalidInput("adjustment: all " + std::to_string(pairs.size()) +
                     " pairs join the same two epochs, " + FormatDouble(pairs[0].t_i_s) + " and " +
                     FormatDouble(pairs[0].t_j_s) +
                     " s; a boresight needs pairs along whole strips");
}

/// Throws InvalidInput if the boresight of one of several scanners is an unknown without pairs.
void ExpectScannerPairs(const FlightNetwork& network) {
  const std::vector<ScannerBlocks>& scanners = network.calibration().scanners();
  for (std::size_t k = 0; k < scanners.size(); ++k) {
    const auto measured = [k = static_cast<int>(k)](const PairEdge& edge) {
      return edge.pair.scanner_i == k || edge.pair.scanner_j == k;
    };
    const std::vector<PairEdge>& edges = network.pairs().edges();
    if (network.net().block(scanners[k].boresight.id).held ||
        std::any_of(edges.begin(), edges.end(), measured)) {
      continue;
    }
    throw InvalidInput("adjustment: no usable pair has an end of scanner '" +
                       ScannerAt(network.flight().config, k).name +
                       "'; give it pairs (lidar.p2p, pairs_between), or select another with "
                       "--scanner");
  }
}

/// Leaves out surface pairs whose distance along the normal is larger than that of good ones.
void RejectSurfaces(AdjustmentRun& run) {
  FlightNetwork& network = run.network();
  const std::vector<ControlNode>& surfaces = network.surfaces().points();
  if (surfaces.empty()) return;
  std::vector<double> norm2;
  for (const ControlNode& surface : surfaces) {
    norm2.push_back(0.0);
    for (const std::size_t k : surface.edges) {
      Eigen::VectorXd r;
      network.net().EvaluateFactor(network.surfaces().edges()[k].id, &r);
      norm2.back() += r.squaredNorm();
    }
  }
  const double scale2 = RobustScalarVariance(norm2);
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    if (norm2[k] <= kOutlierScalar * kOutlierScalar * scale2) continue;
    UseSurface(surfaces[k], false, &network);
    ++run.result().surface_outliers;
  }
}

}  // namespace

void AddPairs(AdjustmentRun& run) {
  adjustment_internal::ExpectPairs(run.flight());
  const std::vector<LidarPair>& pairs = run.flight().pairs->pairs;
  ExpectSeveralEpochs(pairs);
  ExpectPairClock(run.flight());
  run.network().AddPairs(pairs);
  if (run.network().pairs().edges().empty()) {
    throw InvalidInput(
        "adjustment: the two epochs of every pair lie between the same two nodes; pairs must join "
        "different strips");
  }
  ExpectScannerPairs(run.network());
  run.result().residual_initial_m = run.MeanPairDifference();
  if (run.flight().ties) run.network().AddTies(*run.flight().ties);
  if (run.flight().surfaces) run.network().AddSurfaces(*run.flight().surfaces);
  if (!run.flight().control) return;
  run.network().AddControl(*run.flight().control);
  for (const ControlNode& point : run.network().control().points()) {
    UseSurvey(point, false, &run.network());
  }
}

void UseControl(AdjustmentRun& run) {
  for (const ControlNode& node : run.network().control().points()) {
    UseSurvey(node, !run.network().control().Point(node).is_check, &run.network());
  }
}

void SolvePairsRobustly(AdjustmentRun& run) {
  run.SetPairLoss(
      adjustment_internal::ConfiguredLoss(run.flight().config.lidar->robust, kUsualPairLoss));
  run.Solve("lidar, robust", kRobustIterations, AdjustmentRun::kRoughSigmas);
}

void RejectPairs(AdjustmentRun& run) {
  Network& net = run.network().net();
  std::vector<FactorId> in_use;
  std::vector<double> norm2;
  for (const auto& edge : run.network().pairs().edges()) {
    if (!net.factor(edge.id).active) continue;
    Eigen::VectorXd r;
    net.EvaluateFactor(edge.id, &r);
    in_use.push_back(edge.id);
    norm2.push_back(r.squaredNorm());
  }
  if (in_use.empty()) return;
  const double scale2 = RobustVariance(norm2);
  for (std::size_t k = 0; k < norm2.size(); ++k) {
    if (norm2[k] <= kOutlierPairNorm * kOutlierPairNorm * scale2) continue;
    net.SetActive(in_use[k], false);
    ++run.result().outliers;
  }
  RejectSurfaces(run);
}

}  // namespace dn
