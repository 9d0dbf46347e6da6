#include <dn/adjustment/facets.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Indices = std::vector<std::size_t>;

constexpr std::size_t kFewestReturns = 10;  // of a facet
constexpr std::size_t kMostFacets = 8;
// Returns of a neighbourhood: the fewest that a plane is fitted to, and the most if the scan lines
// are so far apart that fewer lie on one line.
constexpr std::size_t kFewestNeighbours = 8, kMostNeighbours = 64;
constexpr double kLeastWidth = 0.05;  // variance across a neighbourhood / variance along it
constexpr std::size_t kMostCandidates = 400;
constexpr int kRefinements = 5;
constexpr double kToleranceSigmas = 3.0;
// Neighbourhoods across an edge scatter more, so that the lower quartile is that of a plane: the
// square root of the quartile of chi-square with 5 degrees of freedom over 5.
constexpr double kLowerQuartile = 0.73;
constexpr int kPasses = 2;  // the planes give the scatter more exactly
// Returns that fill the tolerance evenly have 1.7 standard deviations.
constexpr double kMostFacetSigmas = 1.4;
constexpr double kLeastSigmaM = 1e-3;
constexpr double kMostSigmaOverRadius = 1.0 / 30.0;
constexpr double kMostDistanceOverRadius = 0.2;
// The corner of a rectangle is 2.4 standard deviations from its centre, that of a triangle 2.8, and
// more if the returns near the edges are left out.
constexpr double kMostReachSigmas = 6.0;
constexpr double kLeastAngleSine = 0.17;  // between two facets, 10 deg
constexpr double kLeastEigenvalue = 0.1;

/// A plane by orthogonal regression.
struct Plane {
  Vector3d centre_m, normal;
  Vector3d eigenvalues_m2;  ///< sums of squares along the principal axes, ascending
  Matrix3d axes;            ///< columns: the principal axes
  double count = 0.0;

  double Distance(const Vector3d& x_m) const { return normal.dot(x_m - centre_m); }
  double Sigma() const { return std::sqrt(std::max(0.0, eigenvalues_m2[0]) / (count - 3.0)); }
};

class FacetFinder {
 public:
  FacetFinder(const std::vector<NearReturn>& returns, const Vector3d& at_m, double radius_m)
      : returns_(returns), at_m_(at_m), radius_m_(radius_m) {
    for (std::size_t k = 0; k < returns.size(); ++k) {
      if (Distance(k) <= kSurroundings * radius_m) near_.push_back(k);
    }
  }

  std::vector<SurfaceFit> Run() {
    if (near_.size() < kFewestReturns || !FindNeighbourhoods()) return {};
    for (int pass = 0; pass < kPasses; ++pass) {
      TakeOutPlanes();
      if (!planes_.empty()) sigma_m_ = PlaneSigma();
    }
    LeaveOutEdges();
    std::vector<SurfaceFit> facets;
    for (std::size_t k = 0; k < planes_.size(); ++k) {
      if (const auto facet = Conclude(k)) facets.push_back(*facet);
    }
    return facets;
  }

 private:
  const Vector3d& Point(std::size_t k) const { return returns_[k].x_m; }
  double Distance(std::size_t k) const { return (Point(k) - at_m_).norm(); }

  Plane Fit(const Indices& of) const {
    Plane plane;
    plane.count = static_cast<double>(of.size());
    plane.centre_m = Vector3d::Zero();
    for (const std::size_t k : of) plane.centre_m += Point(k) / plane.count;
    Matrix3d squares_m2 = Matrix3d::Zero();
    for (const std::size_t k : of) {
      const Vector3d d_m = Point(k) - plane.centre_m;
      squares_m2 += d_m * d_m.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(squares_m2);
    plane.eigenvalues_m2 = eigen.eigenvalues();
    plane.axes = eigen.eigenvectors();
    plane.normal = plane.axes.col(0);
    return plane;
  }

  /// Returns the plane through the returns nearest to one of them; nullopt if they lie on a line.
  std::optional<Plane> Neighbourhood(std::size_t centre) const {
    Indices nearest = near_;
    const auto nearer = [&](std::size_t a, std::size_t b) {
      return (Point(a) - Point(centre)).squaredNorm() < (Point(b) - Point(centre)).squaredNorm();
    };
    for (std::size_t count = kFewestNeighbours; count <= kMostNeighbours && count <= nearest.size();
         count *= 2) {
      std::nth_element(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count - 1),
                       nearest.end(), nearer);
      const Plane plane =
          Fit({nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count)});
      if (plane.eigenvalues_m2[1] >= kLeastWidth * plane.eigenvalues_m2[2]) return plane;
    }
    return std::nullopt;
  }

  /// Finds the candidates of planes and the scatter of the returns. Returns false without any, and
  /// if the scatter is that of plants.
  bool FindNeighbourhoods() {
    const std::size_t step = near_.size() / kMostCandidates + 1;
    std::vector<double> sigmas_m;
    for (std::size_t k = 0; k < near_.size(); k += step) {
      const auto plane = Neighbourhood(near_[k]);
      if (!plane) continue;
      candidates_.push_back(*plane);
      sigmas_m.push_back(plane->Sigma());
    }
    if (candidates_.empty()) return false;
    const auto quartile = sigmas_m.begin() + static_cast<std::ptrdiff_t>(sigmas_m.size() / 4);
    std::nth_element(sigmas_m.begin(), quartile, sigmas_m.end());
    sigma_m_ = std::max(kLeastSigmaM, *quartile / kLowerQuartile);
    return sigma_m_ <= kMostSigmaOverRadius * radius_m_;
  }

  bool Fits(const Plane& plane, std::size_t k) const {
    return std::abs(plane.Distance(Point(k))) <= kToleranceSigmas * sigma_m_;
  }

  Indices Fitting(const Plane& plane, const Indices& among) const {
    Indices fitting;
    std::copy_if(among.begin(), among.end(), std::back_inserter(fitting),
                 [&](std::size_t k) { return Fits(plane, k); });
    return fitting;
  }

  /// Returns the candidate with the most returns among those left.
  const Plane& Largest(const Indices& left) const {
    const auto support = [&](const Plane& plane) {
      return std::count_if(left.begin(), left.end(), [&](std::size_t k) { return Fits(plane, k); });
    };
    std::size_t best = 0;
    std::ptrdiff_t most = -1;
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      const std::ptrdiff_t count = support(candidates_[c]);
      if (count > most) {
        most = count;
        best = c;
      }
    }
    return candidates_[best];
  }

  void TakeOutPlanes() {
    planes_.clear();
    Indices left = near_;
    while (planes_.size() < kMostFacets && left.size() >= kFewestReturns) {
      Plane plane = Largest(left);
      Indices own = Fitting(plane, left);
      for (int step = 0; step < kRefinements && own.size() >= kFewestReturns; ++step) {
        plane = Fit(own);
        own = Fitting(plane, left);
      }
      if (own.size() < kFewestReturns) return;
      planes_.push_back(plane);
      std::erase_if(left, [&](std::size_t k) { return Fits(plane, k); });
    }
  }

  /// Returns the scatter of the returns about the planes.
  double PlaneSigma() const {
    double squares_m2 = 0.0, count = 0.0;
    for (const Plane& plane : planes_) {
      squares_m2 += std::max(0.0, plane.eigenvalues_m2[0]);
      count += plane.count - 3.0;
    }
    return std::clamp(std::sqrt(squares_m2 / count), kLeastSigmaM, sigma_m_);
  }

  bool PassesCorner(const Plane& plane) const {
    return std::abs(plane.Distance(at_m_)) <= kMostDistanceOverRadius * radius_m_;
  }

  /// Returns whether another plane through the corner has about the direction of this one, and more
  /// returns.
  bool IsCopy(std::size_t k) const {
    for (std::size_t other = 0; other < k; ++other) {
      const double sine = planes_[other].normal.cross(planes_[k].normal).norm();
      if (sine < kLeastAngleSine && PassesCorner(planes_[other])) return true;
    }
    return false;
  }

  /// Returns the returns within the radius that fit one plane only.
  Indices OwnReturns(std::size_t plane) const {
    Indices own;
    for (const std::size_t k : Fitting(planes_[plane], near_)) {
      if (Distance(k) > radius_m_) continue;
      const auto fitting = std::count_if(planes_.begin(), planes_.end(),
                                         [&](const Plane& each) { return Fits(each, k); });
      if (fitting == 1) own.push_back(k);
    }
    return own;
  }

  /// Fits all planes again to the returns that fit no other one.
  void LeaveOutEdges() {
    std::vector<Plane> fitted = planes_;
    for (std::size_t k = 0; k < planes_.size(); ++k) {
      const Indices own = OwnReturns(k);
      if (own.size() >= kFewestReturns) fitted[k] = Fit(own);
    }
    planes_ = std::move(fitted);
  }

  std::optional<SurfaceFit> Conclude(std::size_t k) const {
    if (IsCopy(k)) return std::nullopt;
    SurfaceFit facet;
    facet.inliers = OwnReturns(k);
    if (facet.inliers.size() < kFewestReturns) return std::nullopt;
    const Plane plane = Fit(facet.inliers);
    if (plane.Sigma() > kMostFacetSigmas * sigma_m_ || !PassesCorner(plane)) return std::nullopt;
    const double above_m = plane.Distance(at_m_);
    facet.foot_m = at_m_ - above_m * plane.normal;
    facet.normal_m = plane.normal.z() < 0.0 ? Vector3d(-plane.normal) : plane.normal;
    double reach = 0.0;  // squared, in standard deviations of the returns
    for (Eigen::Index axis = 1; axis < 3; ++axis) {
      const double along_m = plane.axes.col(axis).dot(facet.foot_m - plane.centre_m);
      reach += plane.count * along_m * along_m / plane.eigenvalues_m2[axis];
    }
    if (!(reach <= kMostReachSigmas * kMostReachSigmas)) return std::nullopt;
    facet.sigma_m = std::max(kLeastSigmaM, plane.Sigma() * std::sqrt((1.0 + reach) / plane.count));
    return facet;
  }

  const std::vector<NearReturn>& returns_;
  Vector3d at_m_;
  double radius_m_;
  Indices near_;
  std::vector<Plane> candidates_;
  double sigma_m_ = 0.0;  ///< scatter of the returns about a plane
  std::vector<Plane> planes_;
};

}  // namespace

std::vector<SurfaceFit> FindFacets(const std::vector<NearReturn>& returns, const Vector3d& at_m,
                                   double radius_m) {
  return FacetFinder(returns, at_m, radius_m).Run();
}

bool DetermineCorner(const std::vector<Vector3d>& normals) {
  Matrix3d sum = Matrix3d::Zero();
  for (const Vector3d& normal : normals) sum += normal * normal.transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(sum, Eigen::EigenvaluesOnly).eigenvalues()[0] >=
         kLeastEigenvalue;
}

}  // namespace dn
