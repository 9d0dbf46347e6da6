#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "coarse_alignment.h"

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kTrials = 2000;
constexpr double kHuber = 2.5;
constexpr std::size_t kFewestPairs = 3;

/// The difference of a pair, linearised at a boresight: w + A d.
struct Line {
  Vector3d w;
  Matrix3d A;
};

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

std::vector<Line> Linearise(const GaussHelmertProblem& problem, const Vector3d& theta_rad) {
  std::vector<Line> lines;
  for (const GaussHelmertPair& pair : problem.pairs) {
    const PairLinearisation at =
        LinearisePair(pair, problem.lever_arm_b_m, BoresightModel::kExponential, theta_rad,
                      PairCorrection::Zero());
    lines.push_back({at.w, at.A});
  }
  return lines;
}

/// Returns the change of the boresight from some of the pairs, with a weak prior at zero.
Vector3d Solve(const std::vector<Line>& lines, const std::vector<std::size_t>& which,
               double sigma_m, double prior_rad) {
  Matrix3d N = Matrix3d::Identity() / (prior_rad * prior_rad);
  Vector3d h = Vector3d::Zero();
  for (const std::size_t k : which) {
    N += lines[k].A.transpose() * lines[k].A / (sigma_m * sigma_m);
    h += lines[k].A.transpose() * lines[k].w / (sigma_m * sigma_m);
  }
  return -N.ldlt().solve(h);
}

std::vector<std::size_t> Agreeing(const std::vector<Line>& lines, const Vector3d& d,
                                  double tolerance_m) {
  std::vector<std::size_t> which;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if ((lines[k].w + lines[k].A * d).norm() < tolerance_m) which.push_back(k);
  }
  return which;
}

/// Returns the pairs that agree with the best of many boresights.
std::vector<std::size_t> LargestConsensus(const std::vector<Line>& lines, double tolerance_m,
                                          const MatchOptions& options) {
  std::mt19937_64 engine(options.seed);
  std::vector<std::size_t> best;
  for (int trial = 0; trial < kTrials; ++trial) {
    const std::vector<std::size_t> two{engine() % lines.size(), engine() % lines.size()};
    if (two[0] == two[1]) continue;
    const Vector3d d = Solve(lines, two, 0.3 * tolerance_m, options.search_rad);
    std::vector<std::size_t> which = Agreeing(lines, d, tolerance_m);
    if (which.size() > best.size()) best = std::move(which);
  }
  return best;
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
  if (pairs.size() < kFewestPairs) return fit;
  const double sigma_m = 0.3 * tolerance_m;
  GaussHelmertProblem problem = MakeCoarseProblem(pairs, sigma_m, options, *source);
  const std::vector<std::size_t> which =
      LargestConsensus(Linearise(problem, problem.boresight_rad), tolerance_m, options);
  fit.agreeing = which.size();
  if (which.size() < kFewestPairs) return fit;

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
  for (const Line& line : Linearise(problem, source->mounting().boresight_rad)) {
    squares += line.w.squaredNorm();
  }
  fit.rms_m = std::sqrt(squares / static_cast<double>(problem.pairs.size()));
  return fit;
}

}  // namespace dn::matching_internal
