#include <dn/adjustment/gnss_errors.h>
#include <dn/geo/text_table.h>

namespace dn {
namespace {

Json TestJson(const GnssCorrelation& test) {
  if (test.process.tau_s == 0.0) return nullptr;
  return {
      {"lag1_correlation", ToJson(test.lag1)}, {"lag1_expected", ToJson(test.lag1_expected)},
      {"p_value", ToJson(test.p_value)},       {"p_value_together", test.p_value_together},
      {"tau_s", test.process.tau_s},           {"sigma_enu_m", ToJson(test.process.sigma_enu_m)}};
}

Json ProcessJson(const GnssProcess& process, const ProcessChain& chain, const Network& net,
                 const Marginals& marginals) {
  Eigen::Vector3d square = Eigen::Vector3d::Zero(), variance = square;
  for (const Block<Vec<3>>& block : chain.blocks) {
    square += net.Value(block).cwiseAbs2();
    variance += marginals.DiagonalBlock(block.id).diagonal();
  }
  const auto rms_m = [&](const Eigen::Vector3d& sum) {
    const auto states = static_cast<double>(chain.blocks.size());
    return ToJson(process.sigma_enu_m.cwiseProduct((sum / states).cwiseSqrt()));
  };
  Json json = {{"sigma_enu_m", ToJson(process.sigma_enu_m)},
               {"tau_s", process.tau_s},
               {"states", chain.blocks.size()},
               {"rms_enu_m", rms_m(square)},
               {"posterior_sigma_enu_m", rms_m(variance)}};
  if (process.growth == GnssErrorGrowth::kBank) json["grows_with"] = "bank";
  return json;
}

/// Returns the sigmas of the sum of the processes at an epoch. The position factor of the epoch
/// joins these processes, so their joint covariances are in the selected inverse.
Eigen::Vector3d ProcessSumSigma(const FlightNetwork& network, const Marginals& marginals,
                                double t_s) {
  const TrajectoryGraph& trajectory = network.trajectory();
  const std::vector<ProcessChain>& chains = trajectory.gnss_error();
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  for (std::size_t a = 0; a < chains.size(); ++a) {
    for (std::size_t b = 0; b < chains.size(); ++b) {
      const Eigen::MatrixXd covariance =
          marginals.Covariance(chains[a].At(t_s).id, chains[b].At(t_s).id);
      variance += trajectory.GnssErrorSigmaEnu(a, t_s)
                      .cwiseProduct(trajectory.GnssErrorSigmaEnu(b, t_s))
                      .cwiseProduct(covariance.diagonal());
    }
  }
  return variance.cwiseMax(0.0).cwiseSqrt();
}

}  // namespace

Json GnssErrorsJson(const Adjustment& adjustment, const Marginals& marginals) {
  const FlightNetwork& network = *adjustment.network;
  Json processes = Json::array();
  for (std::size_t i = 0; i < network.trajectory().gnss_error().size(); ++i) {
    processes.push_back(ProcessJson(network.flight().config.gnss->processes[i],
                                    network.trajectory().gnss_error()[i], network.net(),
                                    marginals));
  }
  return {{"test", TestJson(adjustment.gnss_correlation)}, {"processes", processes}};
}

std::string FormatGnssErrors(const FlightNetwork& network, const Marginals& marginals) {
  std::string text = "# t, GNSS error E, N, U [m], sigma E, N, U [m]\n";
  for (const GnssEdge& edge : network.gnss().edges()) {
    const double t_s = network.flight().gnss->epochs[edge.epoch].t_s;
    const Eigen::Vector3d error = network.trajectory().GnssErrorEnu(t_s);
    const Eigen::Vector3d sigma = ProcessSumSigma(network, marginals, t_s);
    text += FormatDouble(t_s);
    for (const Eigen::Vector3d& columns : {error, sigma}) {
      for (const double value : columns) text += ", " + FormatDouble(value);
    }
    text += '\n';
  }
  return text;
}

std::optional<Finding> GnssErrorWarning(const Adjustment& adjustment) {
  if (!adjustment.gnss_correlation.significant()) return std::nullopt;
  return Finding{facts::GnssErrorsCorrelated{adjustment.gnss_correlation}};
}

}  // namespace dn
