#include <dn/distributions.h>
#include <dn/solvers/residual_form.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

namespace dn {
namespace {

constexpr Eigen::Index kMaxRowsExactMoments = 400;
// The more samples, the less does the accuracy that follows from them depend on the seed. Large
// networks have many degrees of freedom in each form and need fewer.
constexpr int kFewestSamples = 32, kMostSamples = 512;
constexpr Eigen::Index kSampledRows = 1 << 22;
// Samples per batch: enough for two threads, but few enough for the memory of networks with
// millions of rows.
constexpr int kSamplesPerBatch = 16, kSamplesPerLargeBatch = 8;
constexpr Eigen::Index kManyRows = 1 << 20;
constexpr unsigned kSeed = 20240501;

/// Builds sums of squares: forms in which every row has its own label.
class SquareSums {
 public:
  explicit SquareSums(Eigen::Index rows) : rows_(rows) {}

  void Add(const std::string& name, const std::string& channel, int row) {
    const auto [at, is_new] = index_.try_emplace(name, forms_.size());
    if (is_new) {
      forms_.push_back({name, channel, {}, 0, {}});
      forms_.back().label.assign(static_cast<std::size_t>(rows_), -1);
    }
    ResidualForm& form = forms_[at->second];
    form.label[static_cast<std::size_t>(row)] = form.labels++;
  }

  std::vector<ResidualForm> Take() { return std::move(forms_); }

 private:
  Eigen::Index rows_;
  std::vector<ResidualForm> forms_;
  std::map<std::string, std::size_t> index_;
};

std::vector<FormMoments> ExactMoments(const Marginals& marginals,
                                      const std::vector<ResidualForm>& forms) {
  const Eigen::Index n = marginals.linearized().rows();
  const Eigen::MatrixXd M = marginals.Project(Eigen::MatrixXd::Identity(n, n));
  std::vector<FormMoments> moments;
  for (const ResidualForm& form : forms) {
    const Eigen::MatrixXd half = form.SumByLabel(M).transpose();
    const Eigen::MatrixXd Q = form.SumByLabel(half);
    moments.push_back({Q.trace(), 2.0 * Q.squaredNorm(), 0});
  }
  return moments;
}

/// The rows of a form with a label.
class FewRows {
 public:
  explicit FewRows(const ResidualForm& form) : labels_(form.labels) {
    for (std::size_t row = 0; row < form.label.size(); ++row) {
      if (form.label[row] < 0) continue;
      row_.push_back(static_cast<Eigen::Index>(row));
      label_.push_back(form.label[row]);
    }
  }

  /// Returns the energies of residual vectors that are the rows of R.
  Eigen::VectorXd Energies(const Eigen::Ref<const Eigen::MatrixXd>& R) const {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(R.rows(), labels_);
    for (std::size_t k = 0; k < row_.size(); ++k) sum.col(label_[k]) += R.col(row_[k]);
    return sum.rowwise().squaredNorm();
  }

 private:
  int labels_;
  std::vector<Eigen::Index> row_;
  std::vector<int> label_;
};

/// Returns the number of samples for a network, a multiple of the batches.
int CountSamples(Eigen::Index rows) {
  const Eigen::Index samples = kSampledRows / rows / kSamplesPerBatch * kSamplesPerBatch;
  return static_cast<int>(std::clamp<Eigen::Index>(samples, kFewestSamples, kMostSamples));
}

/// Calls use(R) for the samples of ForEachSampledResidual in batches; the rows of R are the
/// samples.
template <class Use>
void ForSampleRows(const Marginals& marginals, const Use& use) {
  std::mt19937_64 generator(kSeed);
  std::normal_distribution<double> normal;
  const Eigen::Index rows = marginals.linearized().rows();
  const int at_once = rows < kManyRows ? kSamplesPerBatch : kSamplesPerLargeBatch;
  const int samples = CountSamples(rows);
  for (int k = 0; k < samples; k += at_once) {
    Eigen::MatrixXd R(at_once, rows);
    {
      Eigen::MatrixXd E(rows, at_once);
      for (double& e : E.reshaped()) e = normal(generator);
      R = E.transpose();
    }
    marginals.ProjectRows(&R);
    use(R);
  }
}

std::vector<FormMoments> SampledMoments(const Eigen::MatrixXd& energies) {
  std::vector<FormMoments> moments;
  for (const auto form : energies.rowwise()) {
    moments.push_back(SampleMoments({form.begin(), form.end()}));
  }
  return moments;
}

bool AreMomentsExact(const Marginals& marginals) {
  return marginals.linearized().rows() <= kMaxRowsExactMoments;
}

}  // namespace

double ResidualForm::Energy(const Eigen::Ref<const Eigen::VectorXd>& residual) const {
  const Eigen::Map<const Eigen::MatrixXd> as_row(residual.data(), 1, residual.size());
  return FewRows(*this).Energies(as_row)[0];
}

Eigen::MatrixXd ResidualForm::SumByLabel(const Eigen::MatrixXd& X) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(labels, X.cols());
  for (std::size_t row = 0; row < label.size(); ++row) {
    if (label[row] >= 0) sum.row(label[row]) += X.row(static_cast<Eigen::Index>(row));
  }
  return sum;
}

std::vector<ResidualForm> ChannelForms(const LinearizedNetwork& linearized) {
  SquareSums sums(linearized.rows());
  for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
    const FactorGroup& group = linearized.group(rows.factor);
    if (!group.measured()) continue;
    for (int k = 0; k < rows.count; ++k) {
      const std::string channel = group.Channel(k);
      sums.Add(channel, channel, rows.first + k);
      sums.Add(channel + " " + group.Axis(k), channel, rows.first + k);
    }
  }
  return sums.Take();
}

double FormMoments::Dof() const {
  const double dof = 2.0 * mean * mean / variance;
  if (samples == 0) return dof;
  const double uncertainty = std::sqrt((2.0 + 12.0 / dof) / (samples - 1));
  return std::max(1.0, dof / (1.0 + 2.0 * uncertainty));
}

double FormMoments::UpperTail(double energy) const {
  if (!(variance > 0.0) || !(mean > 0.0)) return 1.0;
  const double dof = Dof();
  return ChiSquareTail(dof * energy / mean, dof);
}

double FormMoments::LowerTail(double energy) const {
  if (!(variance > 0.0) || !(mean > 0.0)) return 1.0;
  const double dof = Dof();
  return ChiSquareCdf(dof * energy / mean, dof);
}

void ForEachSampledResidual(
    const Marginals& marginals,
    const std::function<void(const Eigen::Ref<const Eigen::VectorXd>&)>& use) {
  ForSampleRows(marginals, [&](const Eigen::MatrixXd& R) {
    for (const auto residual : R.rowwise()) use(Eigen::VectorXd(residual.transpose()));
  });
}

FormMoments SampleMoments(const std::vector<double>& energies) {
  const auto n = static_cast<double>(energies.size());
  FormMoments moments{0.0, 0.0, static_cast<int>(energies.size())};
  for (const double energy : energies) moments.mean += energy / n;
  for (const double energy : energies) {
    moments.variance += std::pow(energy - moments.mean, 2) / (n - 1.0);
  }
  return moments;
}

Eigen::MatrixXd SampleFormEnergies(const Marginals& marginals,
                                   const std::vector<ResidualForm>& forms) {
  const std::vector<FewRows> of_forms(forms.begin(), forms.end());
  Eigen::MatrixXd energies(static_cast<Eigen::Index>(forms.size()),
                           CountSamples(marginals.linearized().rows()));
  Eigen::Index sample = 0;
  ForSampleRows(marginals, [&](const Eigen::MatrixXd& R) {
    for (std::size_t i = 0; i < forms.size(); ++i) {
      energies.row(static_cast<Eigen::Index>(i)).segment(sample, R.rows()) =
          of_forms[i].Energies(R).transpose();
    }
    sample += R.rows();
  });
  return energies;
}

std::vector<FormMoments> ComputeFormMoments(const Marginals& marginals,
                                            const std::vector<ResidualForm>& forms) {
  return AreMomentsExact(marginals) ? ExactMoments(marginals, forms)
                                    : SampledMoments(SampleFormEnergies(marginals, forms));
}

std::vector<FormMoments> ComputeFormMoments(const Marginals& marginals,
                                            const std::vector<ResidualForm>& forms,
                                            const Eigen::MatrixXd& energies) {
  return AreMomentsExact(marginals) ? ExactMoments(marginals, forms) : SampledMoments(energies);
}

}  // namespace dn
