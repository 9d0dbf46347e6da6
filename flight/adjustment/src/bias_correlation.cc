#include <dn/adjustment/bias_correlation.h>
#include <dn/adjustment/result.h>

namespace dn {
namespace {

/// Correlations of the boresight with one triad. They change only where an interval of a process
/// begins, so the last ones are kept.
class WithBias {
 public:
  WithBias(const std::vector<ProcessChain>& chains, const Eigen::Vector3d& sigma_boresight,
           const Marginals& marginals, const Marginals::Columns& boresight)
      : chains_(chains),
        sigma_boresight_(sigma_boresight),
        marginals_(marginals),
        boresight_(boresight) {}

  const Eigen::Matrix3d& At(double t_s) {
    std::vector<BlockId> ids;
    for (const ProcessChain& chain : chains_) ids.push_back(chain.At(t_s).id);
    if (ids != ids_) correlation_ = Correlate(ids, t_s);
    ids_ = ids;
    return correlation_;
  }

 private:
  Eigen::Matrix3d Correlate(const std::vector<BlockId>& ids, double t_s) const {
    Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  // bias x boresight
    for (const BlockId id : ids) cross += boresight_.Rows(id);
    const Eigen::Vector3d sigma_bias =
        TotalBiasCovariance(chains_, t_s, marginals_).diagonal().cwiseMax(1e-300).cwiseSqrt();
    return sigma_boresight_.cwiseInverse().asDiagonal() * cross.transpose() *
           sigma_bias.cwiseInverse().asDiagonal();
  }

  const std::vector<ProcessChain>& chains_;
  Eigen::Vector3d sigma_boresight_;
  const Marginals& marginals_;
  const Marginals::Columns& boresight_;
  std::vector<BlockId> ids_;
  Eigen::Matrix3d correlation_ = Eigen::Matrix3d::Zero();
};

}  // namespace

std::vector<BiasCorrelationAt> BiasCorrelationOverTime(const FlightNetwork& network,
                                                       const Marginals& marginals,
                                                       const Marginals::Columns& boresight,
                                                       std::size_t scanner) {
  const Eigen::Matrix3d covariance =
      boresight.Rows(network.calibration().scanners()[scanner].boresight.id);
  const Eigen::Vector3d sigma = covariance.diagonal().cwiseSqrt();
  WithBias gyro(network.trajectory().gyro_bias(), sigma, marginals, boresight);
  WithBias accel(network.trajectory().accel_bias(), sigma, marginals, boresight);
  std::vector<BiasCorrelationAt> series;
  for (const NodeBlocks& node : network.nodes()) {
    series.push_back({node.t_s, gyro.At(node.t_s), accel.At(node.t_s)});
  }
  return series;
}

double LidarBarycentre(const FlightNetwork& network) {
  double sum = 0.0;
  double n = 0.0;
  for (const auto& edge : network.pairs().edges()) {
    if (!network.net().factor(edge.id).active) continue;
    sum += edge.pair.t_i_s + edge.pair.t_j_s;
    n += 2.0;
  }
  return n > 0.0 ? sum / n : network.trajectory().node_times().front();
}

}  // namespace dn
