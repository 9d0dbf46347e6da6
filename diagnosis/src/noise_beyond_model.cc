#include "noise_beyond_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A smaller share of all sigmas is not listed.
constexpr double kLeastListedShare = 0.05;

Matrix3d Gram(const MatrixXd& G) { return G.transpose() * G; }

/// Returns the sum of squares of the numbers of rows that have the same two labels.
double SquaredOverlap(const ResidualForm& a, const ResidualForm& b) {
  std::map<std::pair<int, int>, double> count;
  for (std::size_t row = 0; row < a.label.size(); ++row) {
    if (a.label[row] >= 0 && b.label[row] >= 0) count[{a.label[row], b.label[row]}] += 1.0;
  }
  double sum = 0.0;
  for (const auto& [labels, n] : count) sum += n * n;
  return sum;
}

double CountRows(const ResidualForm& form) {
  return static_cast<double>(
      std::count_if(form.label.begin(), form.label.end(), [](int label) { return label >= 0; }));
}

EffectContribution MakePart(const std::string& name, const std::string& unit,
                            const std::string& remedy, const Matrix3d& covariance) {
  EffectContribution part;
  part.effect = name;
  part.unit = unit;
  part.remedy = remedy;
  part.angle_sigma_rad = covariance.diagonal().cwiseSqrt();
  return part;
}

}  // namespace

NoiseBeyondModel::NoiseBeyondModel(const std::vector<GroupCheck>& groups,
                                   const std::vector<ResidualForm>& forms,
                                   const std::vector<FormMoments>& moments,
                                   std::vector<ResidualForm> clusters,
                                   const std::vector<FormMoments>& cluster_moments,
                                   const VectorXd& residual)
    : clusters_(std::move(clusters)) {
  double pair_redundancy = 0.0, pair_squares = 0.0;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const GroupCheck& group = groups[k];
    if (group.name != forms[k].channel) continue;  // one axis
    const FormMoments expected{group.redundancy, moments[k].variance, moments[k].samples};
    if (!(expected.mean > 0.0) || !(expected.variance > 0.0)) continue;
    const double squares = forms[k].Energy(residual);
    const double dof = expected.Dof(), ratio = squares / group.redundancy;
    channels_[group.name] = {forms[k], PosteriorNoiseVariance(ratio, dof),
                             PosteriorNoiseSigma(ratio, dof)};
    if (clusters_.empty() || clusters_.front().channel != group.name) continue;
    pair_redundancy = group.redundancy;
    pair_squares = squares;
  }
  if (pair_redundancy <= 0.0) clusters_.clear();
  std::vector<ClusterSums> divisions;
  for (std::size_t k = 0; k < clusters_.size(); ++k) {
    divisions.emplace_back(clusters_[k], cluster_moments[k], residual);
  }
  pairs_ = EstimateSharedVariance(divisions, kClusterLengths_m, pair_squares, pair_redundancy);
}

double NoiseBeyondModel::WhiteVariance(const std::string& channel) const {
  const auto at = channels_.find(channel);
  if (at == channels_.end()) return 1.0;
  const bool of_pairs = !clusters_.empty() && clusters_.front().channel == channel;
  return std::max(1.0, at->second.variance - (of_pairs ? pairs_.total_shared() : 0.0));
}

NoiseBeyondModel::Part NoiseBeyondModel::ChannelPart(const std::string& name,
                                                     const Channel& channel,
                                                     const MatrixXd& gain) const {
  const double excess = std::max(0.0, WhiteVariance(name) - 1.0),
               ratio = std::sqrt(channel.variance);
  const Matrix3d added = excess * Gram(channel.form.SumByLabel(gain));
  EffectContribution words = MakePart(name + " noise", "1", "more data of this sensor", added);
  words.estimate = VectorXd::Constant(1, ratio);
  words.sigma = VectorXd::Constant(1, 0.5 * channel.sigma / ratio);
  words.prior = VectorXd::Constant(1, 0.5 * PriorNoiseSigma());
  return {added, std::move(words)};
}

NoiseBeyondModel::Part NoiseBeyondModel::SharedPart(const MatrixXd& gain,
                                                    double pair_sigma_m) const {
  Matrix3d added = Matrix3d::Zero();
  for (std::size_t k = 0; k < clusters_.size(); ++k) {
    added += pairs_.shared[static_cast<Index>(k)] * Gram(clusters_[k].SumByLabel(gain));
  }
  EffectContribution words =
      MakePart("pair_shared_error", "m", "more pairs, and pairs farther from each other", added);
  const SharedVariance prior = PriorSharedVariance(kClusterLengths_m);
  words.estimate = Eigen::Vector2d(pair_sigma_m * pairs_.size, pairs_.length_m);
  words.sigma = Eigen::Vector2d(pair_sigma_m * pairs_.size_sigma, pairs_.length_sigma_m);
  words.prior = Eigen::Vector2d(pair_sigma_m * prior.size_sigma, prior.length_sigma_m);
  return {added, std::move(words)};
}

Matrix3d NoiseBeyondModel::AddedCovariance(const MatrixXd& gain, double pair_sigma_m,
                                           const Eigen::Vector3d& angle_sigma_rad,
                                           std::vector<EffectContribution>* contributions) const {
  std::vector<Part> parts;
  for (const auto& [name, channel] : channels_) parts.push_back(ChannelPart(name, channel, gain));
  if (!clusters_.empty()) parts.push_back(SharedPart(gain, pair_sigma_m));
  Matrix3d covariance = Matrix3d::Zero();
  for (const Part& part : parts) covariance += part.covariance;
  const VectorXd all = (angle_sigma_rad.cwiseAbs2() + covariance.diagonal()).cwiseSqrt();
  for (Part& part : parts) {
    const VectorXd share = part.words.angle_sigma_rad.cwiseQuotient(all);
    if (share.maxCoeff() >= kLeastListedShare) contributions->push_back(std::move(part.words));
  }
  return covariance;
}

MatrixXd NoiseBeyondModel::AddedCovariance(const MatrixXd& gain) const {
  MatrixXd covariance = MatrixXd::Zero(gain.cols(), gain.cols());
  const auto add = [&](double variance, const ResidualForm& form) {
    const MatrixXd sums = form.SumByLabel(gain);
    covariance += variance * sums.transpose() * sums;
  };
  for (const auto& [name, channel] : channels_) {
    add(std::max(0.0, WhiteVariance(name) - 1.0), channel.form);
  }
  for (std::size_t k = 0; k < clusters_.size(); ++k) {
    add(pairs_.shared[static_cast<Index>(k)], clusters_[k]);
  }
  return covariance;
}

double NoiseBeyondModel::Growth(const ResidualForm& form, const FormMoments& moments) const {
  double growth = WhiteVariance(form.channel);
  if (clusters_.empty() || clusters_.front().channel != form.channel) return growth;
  const double rows = CountRows(form);
  if (rows == 0.0) return growth;
  // The unknowns absorb a part of the sums of the form.
  const double left = moments.mean / rows;
  for (std::size_t k = 0; k < clusters_.size(); ++k) {
    growth +=
        pairs_.shared[static_cast<Index>(k)] * left * SquaredOverlap(form, clusters_[k]) / rows;
  }
  return growth;
}

double NoiseBeyondModel::PairGrowth() const {
  if (clusters_.empty()) return 1.0;
  double growth = WhiteVariance(clusters_.front().channel);
  for (std::size_t k = 0; k < clusters_.size(); ++k) {
    const VectorXd count =
        clusters_[k].SumByLabel(VectorXd::Ones(static_cast<Index>(clusters_[k].label.size())));
    growth += pairs_.shared[static_cast<Index>(k)] * count.squaredNorm() / count.sum();
  }
  return growth;
}

}  // namespace dn::diagnosis_internal
