#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/rotation.h>

#include <cmath>
#include <utility>

#include "coarse_alignment.h"
#include "line_consensus.h"

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kHuber = 2.5;

GaussHelmertProblem MakeCoarseProblem(const std::vector<CoarsePair>& pairs, double sigma_m,
                                      const MatchOptions& options,
                                      const FlightMatchSource& source) {
  GaussHelmertProblem problem;
  problem.lever_arm_b_m = source.mounting().lever_arm_b_m;
  problem.boresight_rad = source.mounting().boresight_rad;
  for (const CoarsePair& pair : pairs) {
    problem.pairs.push_back({MakeMatchEnd(source, pair.t_i_s, pair.x_i, options),
                             MakeMatchEnd(source, pair.t_j_s, pair.x_j, options),
                             sigma_m * sigma_m * Matrix3d::Identity()});
  }
  return problem;
}

std::vector<DifferenceLine<3>> Linearise(const GaussHelmertProblem& problem,
                                         const Vector3d& theta_rad) {
  std::vector<DifferenceLine<3>> lines;
  for (const GaussHelmertPair& pair : problem.pairs) {
    const PairLinearisation at =
        LinearisePair(pair, problem.lever_arm_b_m, BoresightModel::kExponential, theta_rad,
                      PairCorrection::Zero());
    lines.push_back({at.w, at.A});
  }
  return lines;
}

}  // namespace

GaussHelmertEnd MakeMatchEnd(const FlightMatchSource& source, double t_s, const Vector3d& u_s,
                             const MatchOptions& options) {
  const MapPose pose = source.PoseAt(t_s);
  GaussHelmertEnd end;
  end.t_s = t_s;
  end.q_mb = pose.q_mb;
  end.p_mb = pose.p_mb;
  end.q_mn = Eigen::Quaterniond(source.frame().R_mn(pose.p_mb));
  end.sigma_ned_m = options.sigma_ned_m;
  end.sigma_rph_rad = options.sigma_rph_rad;
  end.u_b = source.mounting().R_bs_nominal * u_s;
  return end;
}

AlignmentFit AlignBoresight(const std::vector<CoarsePair>& pairs,
                            const Vector3d& given_boresight_rad, double tolerance_m,
                            const MatchOptions& options, FlightMatchSource* source) {
  AlignmentFit fit;
  if (pairs.size() < kFewestToAlign) return fit;
  const double sigma_m = kSigmaPerTolerance * tolerance_m;
  GaussHelmertProblem problem = MakeCoarseProblem(pairs, sigma_m, options, *source);
  const std::vector<std::size_t> which = LargestConsensus(
      Linearise(problem, problem.boresight_rad), tolerance_m, options.search_rad, options.seed);
  fit.agreeing = which.size();
  if (which.size() < kFewestToAlign) return fit;

  std::vector<GaussHelmertPair> agreeing;
  for (const std::size_t k : which) agreeing.push_back(problem.pairs[k]);
  problem.pairs = std::move(agreeing);
  GaussHelmertProblem held = problem;
  held.boresight_sigma_rad = Vector3d::Constant(options.search_rad);
  held.boresight_rad = given_boresight_rad;
  GaussHelmertOptions adjust;
  adjust.loss = Loss::Huber(kHuber);
  adjust.threads = options.threads;
  source->SetBoresight(AdjustGaussHelmert(held, adjust).boresight_rad);

  double squares = 0.0;
  for (const DifferenceLine<3>& line : Linearise(problem, source->mounting().boresight_rad)) {
    squares += line.w.squaredNorm();
  }
  fit.rms_m = std::sqrt(squares / static_cast<double>(problem.pairs.size()));
  return fit;
}

}  // namespace dn::matching_internal
