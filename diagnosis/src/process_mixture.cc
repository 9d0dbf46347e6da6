#include "process_mixture.h"

#include <dn/log_sum.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Smallest probability of a size and shape, relative to the most probable ones.
constexpr double kLeastProbability = 1e-3;

/// One size with one shape.
struct GridPoint {
  const ProcessSize* size = nullptr;
  const ProcessShape* shape = nullptr;
  double log_probability = 0.0;
  double prior = 0.0;
};

class ProcessMixer {
 public:
  ProcessMixer(const VectorXd& s, const MatrixXd& A) : s_(s), A_(A) {}

  void Add(const ProcessSize& size, const ProcessShape& shape, SizeSource source) {
    GridPoint point{&size, &shape, size.log_probability + shape.log_probability, 0.0};
    point.prior = std::exp(point.log_probability);
    if (source == SizeSource::kDataAndPrior) point.log_probability += LogEvidence(Prior(point));
    points_.push_back(point);
  }

  ProcessMixture Take() {
    const double least = Normalise();
    const Index n = s_.size();
    VectorXd prior_variance = VectorXd::Zero(n);
    MatrixXd second = MatrixXd::Zero(n, n);
    out_.mean = VectorXd::Zero(n);
    for (const GridPoint& point : points_) {
      AddBefore(point);
      if (point.log_probability < least) continue;
      const double p = std::exp(point.log_probability);
      const VectorXd sigma = Prior(point);
      MatrixXd P = Factor(sigma).solve(MatrixXd(sigma.asDiagonal()));
      P = sigma.asDiagonal() * P;
      const VectorXd mean = -P * s_;
      out_.mean += p * mean;
      second += p * (P + mean * mean.transpose());
      prior_variance += p * sigma.cwiseAbs2();
      AddPoint(point, p);
    }
    out_.covariance = second - out_.mean * out_.mean.transpose();
    out_.covariance = (0.5 * (out_.covariance + out_.covariance.transpose())).eval();
    out_.prior_sigma = prior_variance.cwiseSqrt();
    for (ProcessMoments* one : {&out_.size, &out_.tau_s, &out_.log_size, &out_.size_before,
                                &out_.tau_before_s, &out_.log_size_before}) {
      one->variance = std::max(0.0, one->variance - one->mean * one->mean);
    }
    return std::move(out_);
  }

 private:
  static VectorXd Prior(const GridPoint& point) { return point.size->size * point.shape->sigma; }

  /// Returns the factorisation of I + sigma A sigma.
  Eigen::LLT<MatrixXd> Factor(const VectorXd& sigma) const {
    MatrixXd B = sigma.asDiagonal() * A_ * sigma.asDiagonal();
    B.diagonal().array() += 1.0;
    return Eigen::LLT<MatrixXd>(B);
  }

  double LogEvidence(const VectorXd& sigma) const {
    const Eigen::LLT<MatrixXd> llt = Factor(sigma);
    const VectorXd z = llt.matrixL().solve(sigma.cwiseProduct(s_));
    return 0.5 * z.squaredNorm() - llt.matrixLLT().diagonal().array().log().sum();
  }

  /// Makes the probabilities of the points that count sum to one. Returns the smallest logarithm
  /// that counts.
  double Normalise() {
    double most = kLogZero;
    for (const GridPoint& point : points_) most = std::max(most, point.log_probability);
    const double least = most + std::log(kLeastProbability);
    LogSum counted;
    for (const GridPoint& point : points_) {
      if (point.log_probability >= least) counted.Add(point.log_probability);
    }
    for (GridPoint& point : points_) point.log_probability -= counted.Value();
    return least - counted.Value();
  }

  static void AddTo(ProcessMoments* moments, double p, double value) {
    moments->mean += p * value;
    moments->variance += p * value * value;
  }

  void AddPoint(const GridPoint& point, double p) {
    AddTo(&out_.size, p, point.size->size);
    AddTo(&out_.log_size, p, std::log(point.size->size));
    AddTo(&out_.tau_s, p, point.shape->tau_s);
  }

  void AddBefore(const GridPoint& point) {
    AddTo(&out_.size_before, point.prior, point.size->size);
    AddTo(&out_.tau_before_s, point.prior, point.shape->tau_s);
    AddTo(&out_.log_size_before, point.prior, std::log(point.size->size));
  }

  const VectorXd& s_;
  const MatrixXd& A_;
  std::vector<GridPoint> points_;
  ProcessMixture out_;
};

}  // namespace

double ProcessMoments::sigma() const { return std::sqrt(variance); }

ProcessMixture MixProcess(const VectorXd& s, const MatrixXd& A,
                          const std::vector<ProcessSize>& sizes,
                          const std::vector<ProcessShape>& shapes, SizeSource source) {
  ProcessMixer mixer(s, A);
  for (const ProcessShape& shape : shapes) {
    for (const ProcessSize& size : sizes) mixer.Add(size, shape, source);
  }
  return mixer.Take();
}

}  // namespace dn::diagnosis_internal
