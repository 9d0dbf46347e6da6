#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/error.h>
#include <dn/files/accuracy_files.h>
#include <dn/geo/accuracy_series.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory_covariance.h>
#include <dn/rotation.h>

#include <Eigen/LU>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <utility>

#include "fixed_trajectory.h"
#include "turn_position.h"

namespace dn {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;

using Ends = std::vector<const GaussHelmertEnd*>;

/// Returns whether the covariance covers every end. An end must lie in a strip of the covariance,
/// or as close to one as the epochs of the covariance are to each other.
bool Covers(const TrajectoryCovariance& covariance, const Ends& ends) {
  double spacing_s = 0.0;
  for (std::size_t k = 1; k < covariance.t_s.size(); ++k) {
    if (covariance.strip[k] != covariance.strip[k - 1]) continue;
    spacing_s = std::max(spacing_s, covariance.t_s[k] - covariance.t_s[k - 1]);
  }
  const auto covered = [&](double t_s) {
    const auto after = std::upper_bound(covariance.t_s.begin(), covariance.t_s.end(), t_s);
    const bool near_after = after != covariance.t_s.end() && *after - t_s <= spacing_s;
    return near_after || (after != covariance.t_s.begin() && t_s - *(after - 1) <= spacing_s);
  };
  return std::all_of(ends.begin(), ends.end(),
                     [&](const GaussHelmertEnd* end) { return covered(end->t_s); });
}

/// Throws InvalidInput unless the standard deviations and the covariance are the output of one run.
void CheckSameRun(const TrajectoryCovariance& covariance, const AccuracySeries& series,
                  const fs::path& file) {
  constexpr double kTolerance = 0.01;
  for (std::size_t k = 0; k < covariance.t_s.size(); ++k) {
    const double sigma_down_m = series.At(covariance.t_s[k]).sigma_ned_m.z();
    const auto at = static_cast<Eigen::Index>(6 * k);
    const double sigma_up_m = std::sqrt(covariance.covariance(at + 2, at + 2));
    if (std::abs(sigma_up_m - sigma_down_m) > kTolerance * sigma_down_m) {
      throw InvalidInput(
          "the file and the standard deviations next to it are of different runs: sigma up at " +
              FormatDouble(covariance.t_s[k]) + " s is " + FormatDouble(sigma_up_m) + " m and " +
              FormatDouble(sigma_down_m) + " m; remove the file, or smooth the flight again",
          FileLocation{file.string(), 0, 0});
    }
  }
}

PoseCovariance ToMapPoses(const Flight& flight, const TrajectoryCovariance& stated,
                          const fs::path& file) {
  PoseCovariance out{stated.t_s, stated.strip, stated.covariance};
  for (std::size_t k = 0; k < out.t_s.size(); ++k) {
    const NavPoint& point = flight.trajectory->FirstPointAtOrAfter(out.t_s[k]);
    adjustment_internal::RotatePosition(flight.frame.R_m_enu(flight.frame.ToMap(point.position)), k,
                                        &out.covariance);
  }
  try {
    out.Validate();
  } catch (const InvalidConfig& error) {
    throw InvalidInput(std::string(error.what()) + "; smooth the flight again, or remove the file",
                       FileLocation{file.string(), 0, 0});
  }
  return out;
}

/// Accumulates root mean squares over epochs.
class MeanAccuracy {
 public:
  void Add(const EpochAccuracy& epoch, const Vector3d& down_b) {
    const Matrix3d F = BodyFromEulerRates(down_b) * epoch.sigma_rph_rad.asDiagonal();
    Add(epoch, Matrix3d(F * F.transpose()));
  }
  void Add(const EpochAccuracy& epoch, const Matrix3d& attitude_rad2) {
    position2_ += epoch.sigma_ned_m.cwiseAbs2();
    attitude2_ += epoch.sigma_rph_rad.cwiseAbs2();
    covariance_rad2_ += attitude_rad2;
    n_ += 1.0;
  }
  void To(TrajectoryAccuracy* accuracy) const {
    accuracy->sigma_ned_m = (position2_ / n_).cwiseSqrt();
    accuracy->sigma_rph_rad = (attitude2_ / n_).cwiseSqrt();
    accuracy->attitude_covariance_rad2 = covariance_rad2_ / n_;
  }

 private:
  Vector3d position2_ = Vector3d::Zero(), attitude2_ = Vector3d::Zero();
  Matrix3d covariance_rad2_ = Matrix3d::Zero();
  double n_ = 0.0;
};

void AddEnds(const Ends& ends, const std::optional<AccuracySeries>& series, MeanAccuracy* mean) {
  for (const GaussHelmertEnd* end : ends) {
    const EpochAccuracy stated{end->t_s, end->sigma_ned_m, end->sigma_rph_rad};
    mean->Add(series ? series->At(end->t_s) : stated, end->down_b());
  }
}

/// Adds the standard deviations of a joint covariance at its own epochs, if there is no separate
/// series.
void AddEpochs(const Flight& flight, const TrajectoryCovariance& stated, MeanAccuracy* mean) {
  for (std::size_t k = 0; k < stated.t_s.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(6 * k);
    const Vector3d enu2 = stated.covariance.diagonal().segment<3>(at);
    const Matrix3d attitude = stated.covariance.block<3, 3>(at + 3, at + 3);
    const NavPoint& point = flight.trajectory->FirstPointAtOrAfter(stated.t_s[k]);
    const Vector3d down_b = point.q_nb.conjugate() * Vector3d::UnitZ();
    const Matrix3d E = BodyFromEulerRates(down_b).inverse();
    mean->Add({stated.t_s[k], Vector3d(enu2.y(), enu2.x(), enu2.z()).cwiseSqrt(),
               (E * attitude * E.transpose()).diagonal().cwiseSqrt()},
              attitude);
  }
}

}  // namespace

TrajectoryAccuracy ReadTrajectoryAccuracy(const Flight& flight,
                                          const GaussHelmertProblem& problem) {
  std::vector<const GaussHelmertEnd*> ends;
  ends.reserve(2 * problem.pairs.size());
  for (const GaussHelmertPair& pair : problem.pairs) {
    ends.push_back(&pair.i);
    ends.push_back(&pair.j);
  }
  return adjustment_internal::ReadAccuracyAt(flight, ends);
}

TrajectoryAccuracy adjustment_internal::ReadAccuracyAt(
    const Flight& flight, const std::vector<const GaussHelmertEnd*>& ends) {
  const AccuracyFiles files = FindAccuracyFiles(flight.config);
  std::optional<AccuracySeries> series;
  if (files.series) series.emplace(*files.series);
  TrajectoryAccuracy accuracy;
  accuracy.sigma_source = series ? SigmaSource::kSmoother : SigmaSource::kDataSheet;
  accuracy.source =
      series ? files.series->filename().string() : "the section trajectory of flight.yaml";
  MeanAccuracy mean;
  if (files.covariance) {
    const TrajectoryCovariance stated = ReadTrajectoryCovariance(*files.covariance);
    if (Covers(stated, ends)) {
      if (series) CheckSameRun(stated, *series, *files.covariance);
      if (!series) AddEpochs(flight, stated, &mean);
      accuracy.covariance = ToMapPoses(flight, stated, *files.covariance);
      accuracy.source = files.covariance->filename().string();
      accuracy.sigma_source = SigmaSource::kSmoother;
    } else if (files.named) {
      throw InvalidInput("the file does not cover the lidar data; smooth the flight again",
                         FileLocation{files.covariance->string(), 0, 0});
    }
  }
  if (series || !accuracy.covariance) AddEnds(ends, series, &mean);
  mean.To(&accuracy);
  return accuracy;
}

}  // namespace dn
