#include <dn/adjustment/control_search.h>
#include <dn/adjustment/facets.h>
#include <dn/adjustment/result.h>
#include <dn/median.h>
#include <dn/rotation.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFewestReturns = 6;
constexpr int kFitSteps = 10;
constexpr int kAbsoluteSteps = 50;
constexpr double kOutlierSigmas = 3.0;
constexpr double kLeastNormalUp = 0.5;  // a slope of 60 deg
constexpr double kLeastSigmaM = 1e-3;
// The returns surround a point that is this close to their middle, in standard deviations of their
// horizontal distribution: the edge of a disk.
constexpr double kInsideSigmas = 2.0;
constexpr double kTrajectorySpacingS = 0.01;

/// Coefficients of up = c0 + c1 east + c2 north, relative to a point.
struct PlaneCoefficients {
  Vector3d c = Vector3d::Zero();
  Eigen::Matrix3d inverse_normal = Eigen::Matrix3d::Zero();
  bool determined = false;
};

class SurfaceFitter {
 public:
  SurfaceFitter(const std::vector<NearReturn>& returns, const Vector3d& at_m)
      : returns_(returns), at_m_(at_m) {
    for (std::size_t k = 0; k < returns.size(); ++k) used_.push_back(k);
  }

  std::optional<SurfaceFit> Run() {
    if (used_.size() < kFewestReturns) return std::nullopt;
    PlaneCoefficients plane = LeastAbsolute();
    if (!plane.determined) return std::nullopt;
    Trim(plane.c);
    for (int step = 0; step < kFitSteps; ++step) {
      if (used_.size() < kFewestReturns) return std::nullopt;
      plane = Solve();
      if (!plane.determined) return std::nullopt;
      const std::size_t before = used_.size();
      Trim(plane.c);
      if (used_.size() == before) break;
    }
    if (used_.size() < kFewestReturns || 2 * used_.size() < returns_.size()) return std::nullopt;
    return Conclude(plane);
  }

 private:
  Vector3d Row(std::size_t k) const {
    const Vector3d d = returns_[k].x_m - at_m_;
    return {1.0, d.x(), d.y()};
  }
  double Height(std::size_t k) const { return (returns_[k].x_m - at_m_).z(); }

  /// Returns the plane with the least sum of absolute residuals, which outliers do not tilt.
  PlaneCoefficients LeastAbsolute() const {
    PlaneCoefficients plane = Solve();
    for (int step = 0; step < kAbsoluteSteps && plane.determined; ++step) {
      const Vector3d c = plane.c;
      plane = Solve([&](std::size_t k) {
        return 1.0 / std::max(kLeastSigmaM, std::abs(Height(k) - Row(k).dot(c)));
      });
    }
    return plane;
  }

  PlaneCoefficients Solve(const std::function<double(std::size_t)>& weight = nullptr) const {
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (const std::size_t k : used_) {
      const double w = weight ? weight(k) : 1.0;
      N += w * Row(k) * Row(k).transpose();
      b += w * Row(k) * Height(k);
    }
    const Eigen::ColPivHouseholderQR<Eigen::Matrix3d> qr(N);
    PlaneCoefficients plane;
    plane.determined = qr.isInvertible();
    if (!plane.determined) return plane;
    plane.c = qr.solve(b);
    plane.inverse_normal = qr.inverse();
    return plane;
  }

  void Trim(const Vector3d& c) {
    std::vector<double> sizes;
    for (std::size_t k = 0; k < returns_.size(); ++k) {
      sizes.push_back(std::abs(Height(k) - Row(k).dot(c)));
    }
    std::vector<double> of_used;
    for (const std::size_t k : used_) of_used.push_back(sizes[k]);
    const double limit_m =
        kOutlierSigmas * std::max(kLeastSigmaM, kSigmaPerMedian * Median(std::move(of_used)));
    used_.clear();
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      if (sizes[k] <= limit_m) used_.push_back(k);
    }
  }

  std::optional<SurfaceFit> Conclude(const PlaneCoefficients& plane) const {
    double squares = 0.0;
    for (const std::size_t k : used_) squares += std::pow(Height(k) - Row(k).dot(plane.c), 2);
    const auto n = static_cast<double>(used_.size());
    // The variance at the point is 1/n in the middle of the returns, and grows with the distance.
    const double leverage = plane.inverse_normal(0, 0);
    if (leverage > (1.0 + kInsideSigmas * kInsideSigmas) / n) return std::nullopt;
    SurfaceFit fit;
    fit.normal_m = Vector3d(-plane.c[1], -plane.c[2], 1.0).normalized();
    if (fit.normal_m.z() < kLeastNormalUp) return std::nullopt;
    fit.foot_m = at_m_ + Vector3d(0.0, 0.0, plane.c[0]);
    const double sigma_up_m = std::sqrt(squares / (n - 3.0) * leverage);
    fit.sigma_m = std::max(kLeastSigmaM, sigma_up_m * fit.normal_m.z());
    fit.inliers = used_;
    return fit;
  }

  const std::vector<NearReturn>& returns_;
  Vector3d at_m_;
  std::vector<std::size_t> used_;
};

double SearchRadius(const FlightConfig& config, const ControlPoint& point) {
  if (point.plane && point.plane->extent_m > 0.0) return point.plane->extent_m;
  const ControlConfig control = config.control.value_or(ControlConfig());
  return point.is_corner ? control.corner_radius_m : control.search_radius_m;
}

/// Removes the returns of a corner whose facets leave a coordinate undetermined.
void ExpectDetermined(ControlPoint* corner) {
  std::vector<Vector3d> normals;
  for (const ControlReturn& one : corner->returns) normals.push_back(*one.normal_m);
  if (!DetermineCorner(normals)) corner->returns.clear();
}

/// Collects the returns of a strip around control points.
class ReturnCollector {
 public:
  ReturnCollector(const Flight& flight, const StripSource& source, const Mounting& mounting,
                  const std::vector<ControlPoint*>& points)
      : source_(source), mounting_(mounting), points_(points) {
    for (const ControlPoint* point : points) {
      radii_m_.push_back(SearchRadius(flight.config, *point));
    }
  }

  /// Adds to each point the return on the surface around it, or those on the facets of a corner.
  void Search(const std::filesystem::path& file) {
    near_.assign(points_.size(), {});
    source_.Read(file, [&](const LaserVectors& vectors) {
      for (std::size_t k = 0; k < vectors.size(); ++k) Take(vectors.t_s[k], vectors.u_s[k]);
    });
    for (std::size_t k = 0; k < points_.size(); ++k) {
      for (const SurfaceFit& fit : Surfaces(k)) {
        points_[k]->returns.push_back(OnSurface(fit, k, file));
      }
    }
  }

 private:
  void Take(double t_s, const Vector3d& u_s) {
    const Vector3d x_m = Georeference(source_.PoseAt(t_s), mounting_, u_s);
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const double radius_m = (points_[k]->is_corner ? kSurroundings : 1.0) * radii_m_[k];
      if ((x_m - points_[k]->p_m).head<2>().squaredNorm() > radius_m * radius_m) continue;
      near_[k].push_back({x_m, t_s, u_s});
    }
  }

  std::vector<SurfaceFit> Surfaces(std::size_t point) const {
    const ControlPoint& at = *points_[point];
    if (at.is_corner) return FindFacets(near_[point], at.p_m, radii_m_[point]);
    const auto fit = FitSurface(near_[point], at.p_m);
    return fit ? std::vector{*fit} : std::vector<SurfaceFit>{};
  }

  /// Returns the return nearest to the point, with its end moved onto the surface.
  ControlReturn OnSurface(const SurfaceFit& fit, std::size_t point,
                          const std::filesystem::path& file) const {
    const auto distance = [&](std::size_t k) {
      return (near_[point][k].x_m - fit.foot_m).squaredNorm();
    };
    const std::size_t nearest =
        *std::min_element(fit.inliers.begin(), fit.inliers.end(),
                          [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
    const NearReturn& one = near_[point][nearest];
    const Vector3d off_m = fit.normal_m * fit.normal_m.dot(fit.foot_m - one.x_m);
    const Eigen::Matrix3d R_ms =
        (source_.PoseAt(one.t_s).q_mb * Exp(mounting_.boresight_rad)).toRotationMatrix() *
        mounting_.R_bs_nominal;
    ControlReturn found;
    found.t_s = one.t_s;
    found.u_s = one.u_s + R_ms.transpose() * off_m;
    found.normal_m = fit.normal_m;
    found.sigma_m = fit.sigma_m;
    found.where = {file.string()};
    return found;
  }

  const StripSource& source_;
  const Mounting& mounting_;
  const std::vector<ControlPoint*>& points_;
  std::vector<double> radii_m_;
  std::vector<std::vector<NearReturn>> near_;
};

}  // namespace

std::optional<SurfaceFit> FitSurface(const std::vector<NearReturn>& returns, const Vector3d& at_m) {
  return SurfaceFitter(returns, at_m).Run();
}

bool NeedsControlSearch(const Flight& flight) {
  if (!flight.control || flight.config.strips_crs == "none") return false;
  const bool any = std::any_of(flight.control->points.begin(), flight.control->points.end(),
                               [](const ControlPoint& point) { return point.returns.empty(); });
  return any && !FindStripFiles(flight.config, 0).empty();
}

long FindControlReturns(const Flight& flight, const StripSourceOptions& options,
                        const Mounting& mounting, ControlData* control) {
  std::vector<ControlPoint*> points;
  for (ControlPoint& point : control->points) {
    if (point.returns.empty()) points.push_back(&point);
  }
  const StripSource source(options, flight.frame, flight.config.strips_crs);
  ReturnCollector collector(flight, source, mounting, points);
  for (const std::filesystem::path& file : FindStripFiles(flight.config, 0)) {
    collector.Search(file);
  }
  for (ControlPoint* point : points) {
    if (point->is_corner) ExpectDetermined(point);
  }
  return std::count_if(points.begin(), points.end(),
                       [](const ControlPoint* point) { return !point->returns.empty(); });
}

void AddControlFromStrips(const AdjustOptions& options, Flight* flight, Adjustment* adjustment) {
  const CalibrationState calibration = adjustment->network->calibration().State();
  const LidarConfig& lidar = *flight->config.lidar;
  StripSourceOptions source;
  source.trajectory =
      Trajectory(DenseTrajectory(*adjustment->network, kTrajectorySpacingS, options.threads));
  source.made_by = flight->trajectory;
  source.made_with = StripsGeoreferencing(flight->config);
  source.time_span_s = flight->config.time_span_s;
  source.time_offset_s = lidar.time_offset_s;
  Mounting mounting = lidar.mounting;
  mounting.boresight_rad = Log(calibration.q_boresight);
  mounting.lever_arm_b_m = calibration.lidar_lever_arm_b_m;
  const long found = FindControlReturns(*flight, source, mounting, &*flight->control);
  flight->counts["control points found in strips"] = found;
  if (found == 0) return;
  adjustment->network->AddControl(*flight->control);
  AdjustAgain(*flight, options, adjustment);
}

}  // namespace dn
