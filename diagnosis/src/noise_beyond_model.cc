#include "noise_beyond_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A smaller share of all sigmas is not listed.
constexpr double kLeastListedShare = 0.05;

MatrixXd Gram(const MatrixXd& G) { return G.transpose() * G; }

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

/// Returns the clusters of one channel or axis, with their moments.
std::vector<std::size_t> FindClusters(const std::string& name,
                                      const std::vector<ResidualForm>& clusters) {
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    if (clusters[k].channel == name) found.push_back(k);
  }
  return found;
}

/// Returns whether the axes of a channel have clusters.
bool HasClusters(const std::string& channel, const std::vector<ResidualForm>& clusters) {
  return std::any_of(clusters.begin(), clusters.end(), [&](const ResidualForm& cluster) {
    return cluster.channel.starts_with(channel + " ");
  });
}

}  // namespace

double NoiseBeyondModel::Source::WhiteVariance() const {
  return std::max(1.0, variance - shared.total_shared());
}

MatrixXd NoiseBeyondModel::Source::WhiteCovariance(const MatrixXd& gain) const {
  return (WhiteVariance() - 1.0) * Gram(form.SumByLabel(gain));
}

MatrixXd NoiseBeyondModel::Source::SharedCovariance(const MatrixXd& gain) const {
  MatrixXd covariance = MatrixXd::Zero(gain.cols(), gain.cols());
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    covariance += shared.shared[static_cast<Index>(k)] * Gram(clusters[k].SumByLabel(gain));
  }
  return covariance;
}

NoiseBeyondModel::NoiseBeyondModel(const std::vector<GroupCheck>& groups,
                                   const std::vector<ResidualForm>& forms,
                                   const std::vector<FormMoments>& moments,
                                   const std::vector<ResidualForm>& clusters,
                                   const std::vector<FormMoments>& cluster_moments,
                                   const VectorXd& residual) {
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const GroupCheck& group = groups[k];
    const bool is_axis = group.name != forms[k].channel;
    if (is_axis != HasClusters(forms[k].channel, clusters)) continue;
    const FormMoments expected{group.redundancy, moments[k].variance, moments[k].samples};
    if (!(expected.mean > 0.0) || !(expected.variance > 0.0)) continue;
    const double squares = forms[k].Energy(residual);
    const double dof = expected.Dof(), ratio = squares / group.redundancy;
    Source source{
        forms[k], PosteriorNoiseVariance(ratio, dof), PosteriorNoiseSigma(ratio, dof), {}, {}};
    std::vector<ClusterSums> divisions;
    for (const std::size_t c : FindClusters(group.name, clusters)) {
      source.clusters.push_back(clusters[c]);
      divisions.emplace_back(clusters[c], cluster_moments[c], residual);
    }
    source.shared = EstimateSharedVariance(divisions, kClusterLengths_m, squares, group.redundancy);
    sources_.push_back(std::move(source));
  }
}

std::vector<std::string> NoiseBeyondModel::Channels() const {
  constexpr double kLeastExcess = 1e-3;
  std::vector<std::string> names;
  for (const Source& source : sources_) {
    const double excess = source.WhiteVariance() - 1.0 + source.shared.total_shared();
    if (excess <= kLeastExcess) continue;
    if (names.empty() || names.back() != source.form.channel) {
      names.push_back(source.form.channel);
    }
  }
  return names;
}

MatrixXd NoiseBeyondModel::Sample(const std::string& channel, int samples,
                                  std::mt19937_64* generator) const {
  std::normal_distribution<double> normal;
  const auto rows = static_cast<Index>(sources_.front().form.label.size());
  MatrixXd errors = MatrixXd::Zero(rows, samples);
  // Adds independent errors of this variance, one per label.
  const auto add = [&](double variance, const ResidualForm& form) {
    if (variance <= 0.0) return;
    const MatrixXd of_label = MatrixXd::NullaryExpr(
        form.labels, samples, [&] { return std::sqrt(variance) * normal(*generator); });
    for (Index row = 0; row < rows; ++row) {
      const int label = form.label[static_cast<std::size_t>(row)];
      if (label >= 0) errors.row(row) += of_label.row(label);
    }
  };
  for (const Source& source : sources_) {
    if (source.form.channel != channel) continue;
    add(source.WhiteVariance() - 1.0, source.form);
    for (std::size_t k = 0; k < source.clusters.size(); ++k) {
      add(source.shared.shared[static_cast<Index>(k)], source.clusters[k]);
    }
  }
  return errors;
}

NoiseBeyondModel::Part NoiseBeyondModel::ChannelPart(const std::string& channel,
                                                     const MatrixXd& gain) const {
  Matrix3d added = Matrix3d::Zero();
  const Source* largest = nullptr;
  for (const Source& source : sources_) {
    if (source.form.channel != channel) continue;
    added += source.WhiteCovariance(gain);
    if (largest == nullptr || source.variance > largest->variance) largest = &source;
  }
  const double ratio = std::sqrt(largest->variance);
  EffectContribution words = MakePart(channel + " noise", "1", "more data of this sensor", added);
  words.estimate = VectorXd::Constant(1, ratio);
  words.sigma = VectorXd::Constant(1, 0.5 * largest->sigma / ratio);
  words.prior = VectorXd::Constant(1, 0.5 * PriorNoiseSigma());
  return {added, std::move(words)};
}

NoiseBeyondModel::Part NoiseBeyondModel::SharedPart(const MatrixXd& gain,
                                                    double pair_sigma_m) const {
  Matrix3d added = Matrix3d::Zero();
  const SharedVariance* largest = &sources_.front().shared;
  for (const Source& source : sources_) {
    added += source.SharedCovariance(gain);
    if (source.shared.total_shared() > largest->total_shared()) largest = &source.shared;
  }
  EffectContribution words =
      MakePart("pair_shared_error", "m", "more pairs, and pairs farther from each other", added);
  const SharedVariance prior = PriorSharedVariance(kClusterLengths_m);
  words.estimate = Eigen::Vector2d(pair_sigma_m * largest->size, largest->length_m);
  words.sigma = Eigen::Vector2d(pair_sigma_m * largest->size_sigma, largest->length_sigma_m);
  words.prior = Eigen::Vector2d(pair_sigma_m * prior.size_sigma, prior.length_sigma_m);
  return {added, std::move(words)};
}

Matrix3d NoiseBeyondModel::AddedCovariance(const MatrixXd& gain, double pair_sigma_m,
                                           const Eigen::Vector3d& angle_sigma_rad,
                                           std::vector<EffectContribution>* contributions) const {
  std::vector<Part> parts;
  std::set<std::string> channels;
  for (const Source& source : sources_) channels.insert(source.form.channel);
  for (const std::string& channel : channels) parts.push_back(ChannelPart(channel, gain));
  if (!sources_.empty()) parts.push_back(SharedPart(gain, pair_sigma_m));
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
  for (const Source& source : sources_) {
    covariance += source.WhiteCovariance(gain) + source.SharedCovariance(gain);
  }
  return covariance;
}

double NoiseBeyondModel::Growth(const ResidualForm& form, const FormMoments& moments) const {
  const double rows = CountRows(form);
  if (rows == 0.0) return 1.0;
  // The unknowns absorb a part of the sums of the form.
  const double left = moments.mean / rows;
  double growth = 1.0;
  for (const Source& source : sources_) {
    if (source.form.channel != form.channel) continue;
    growth += (source.WhiteVariance() - 1.0) * SquaredOverlap(form, source.form) / rows;
    for (std::size_t k = 0; k < source.clusters.size(); ++k) {
      growth += source.shared.shared[static_cast<Index>(k)] * left *
                SquaredOverlap(form, source.clusters[k]) / rows;
    }
  }
  return growth;
}

double NoiseBeyondModel::PairGrowth() const {
  double largest = 1.0;
  for (const Source& source : sources_) {
    if (source.clusters.empty()) continue;
    double growth = source.WhiteVariance();
    for (std::size_t k = 0; k < source.clusters.size(); ++k) {
      const VectorXd count = source.clusters[k].SumByLabel(
          VectorXd::Ones(static_cast<Index>(source.clusters[k].label.size())));
      growth += source.shared.shared[static_cast<Index>(k)] * count.squaredNorm() / count.sum();
    }
    largest = std::max(largest, growth);
  }
  return largest;
}

std::vector<FormMoments> MomentsWithNoise(const std::vector<ResidualForm>& forms,
                                          const Marginals& marginals, const NoiseBeyondModel& noise,
                                          const std::vector<std::string>& channels) {
  constexpr int kSamples = 32;
  constexpr std::mt19937_64::result_type kSeed = 20261128;
  std::mt19937_64 generator(kSeed);
  std::normal_distribution<double> normal;
  const MatrixXd stated = marginals.Project(MatrixXd::NullaryExpr(
      marginals.linearized().rows(), kSamples, [&] { return normal(generator); }));
  std::map<std::string, MatrixXd> beyond;  // by channel
  for (const std::string& channel : channels) {
    beyond[channel] = marginals.Project(noise.Sample(channel, kSamples, &generator));
  }
  std::vector<FormMoments> moments;
  for (const ResidualForm& form : forms) {
    MatrixXd sums = form.SumByLabel(stated);
    for (const auto& [channel, errors] : beyond) {
      if (channel != form.channel) sums += form.SumByLabel(errors);
    }
    const Eigen::RowVectorXd energies = sums.colwise().squaredNorm();
    moments.push_back(SampleMoments({energies.begin(), energies.end()}));
  }
  return moments;
}

}  // namespace dn::diagnosis_internal
