#include "tested_forms.h"

#include <dn/solvers/fit_check.h>

#include <iterator>
#include <utility>

#include "common_errors.h"
#include "pair_clusters.h"

namespace dn::diagnosis_internal {
namespace {

void Append(std::vector<ResidualForm> more, std::vector<ResidualForm>* forms) {
  std::move(more.begin(), more.end(), std::back_inserter(*forms));
}

}  // namespace

std::vector<ResidualForm> TestedForms::Tested() const {
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(tested)};
}

std::vector<FormMoments> TestedForms::TestedMoments() const {
  return {moments.begin(), moments.begin() + static_cast<std::ptrdiff_t>(tested)};
}

NoiseBeyondModel TestedForms::EstimateNoise(const std::vector<GroupCheck>& groups,
                                            const Eigen::VectorXd& residual) const {
  const auto clusters = static_cast<std::ptrdiff_t>(tested);
  return {groups,
          all,
          moments,
          {all.begin() + clusters, all.end()},
          {moments.begin() + clusters, moments.end()},
          residual};
}

TestedForms MakeTestedForms(const FlightNetwork& network, const Marginals& marginals,
                            bool with_clusters) {
  const LinearizedNetwork& linearized = marginals.linearized();
  TestedForms forms;
  forms.all = ChannelForms(linearized);
  forms.channels = forms.all.size();
  Append(CommonErrorForms(network, linearized), &forms.all);
  forms.tested = forms.all.size();
  if (with_clusters) Append(PairClusters(network, linearized, kClusterLengths_m), &forms.all);
  forms.energies = SampleFormEnergies(marginals, forms.all);
  forms.moments = ComputeFormMoments(marginals, forms.all, forms.energies);
  return forms;
}

}  // namespace dn::diagnosis_internal
