#include <dn/adjustment/beams.h>
#include <dn/files/scanners.h>

#include <cmath>
#include <utility>

namespace dn {

bool BeamCorrections::IsObservable(std::size_t k) const {
  return unknown.ends[k] > 0 && 2.0 * sigma[k] * sigma[k] <= prior_sigma[k] * prior_sigma[k];
}

void BeamCorrections::AddChange(const Eigen::VectorXd& change, const Eigen::VectorXd& variance) {
  for (std::size_t k = 0; k < value.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    value[k] += per_si * change[row];
    sigma[k] = std::hypot(sigma[k], per_si * std::sqrt(variance[row]));
  }
}

std::vector<std::size_t> BeamCorrections::NotObservable() const {
  std::vector<std::size_t> beams;
  for (std::size_t k = 0; k < value.size(); ++k) {
    if (!IsObservable(k)) beams.push_back(k);
  }
  return beams;
}

std::vector<BeamCorrections> ExtractBeams(const Adjustment& adjustment,
                                          const Marginals& marginals) {
  const FlightNetwork& network = *adjustment.network;
  std::vector<BeamCorrections> all;
  for (BeamUnknown& unknown : FindBeamUnknowns(network.flight())) {
    const BlockId id = network.net().Find(unknown.name);
    const BlockRecord& record = network.net().block(id);
    const Eigen::VectorXd variance = marginals.Covariance(id).diagonal().cwiseMax(0.0);
    BeamCorrections beams;
    beams.scanner = ScannerAt(network.flight().config, unknown.scanner).name;
    beams.unit = record.label.unit;
    beams.per_si = record.label.per_si;
    for (std::size_t k = 0; k < unknown.num_beams(); ++k) {
      const int i = static_cast<int>(k);
      beams.value.push_back(record.value[i] * beams.per_si);
      beams.sigma.push_back(std::sqrt(variance[i]) * beams.per_si);
      beams.prior_sigma.push_back(unknown.PriorSigma(k) * beams.per_si);
    }
    beams.unknown = std::move(unknown);
    all.push_back(std::move(beams));
  }
  return all;
}

}  // namespace dn
