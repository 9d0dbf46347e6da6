#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/files/control.h>
#include <dn/files/flight.h>
#include <dn/files/strip_source.h>
#include <dn/lidar/mounting.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

namespace dn {

/// A laser return near a control point: its georeferenced position, and the reading.
struct NearReturn {
  Eigen::Vector3d x_m;  ///< map
  double t_s = 0.0;
  Eigen::Vector3d u_s;
};

/// A plane through returns near a point.
struct SurfaceFit {
  Eigen::Vector3d normal_m;          ///< unit, upwards, map axes
  Eigen::Vector3d foot_m;            ///< point of the plane at the given point
  double sigma_m = 0.0;              ///< of the plane at that point, along the normal
  std::vector<std::size_t> inliers;  ///< indices of the returns that it fits
};

/// Fits a plane to the returns around the point `at_m` by robust least squares. Its foot is above
/// or below the point. Returns beyond three robust standard deviations are left out. The result is
/// nullopt if fewer than six returns, or less than half of them, lie on one plane. It is also
/// nullopt if they do not surround the point, or if the plane is steeper than 60 deg.
std::optional<SurfaceFit> FitSurface(const std::vector<NearReturn>& returns,
                                     const Eigen::Vector3d& at_m);

/// Returns whether control points without a laser vector could be found in the strips of the
/// flight.
bool NeedsControlSearch(const Flight& flight);

/// Finds returns for the control points that have none, one per strip file that passes a point. The
/// return is the surface of the cloud at the point. It is fitted to the points of the cloud within
/// control.search_radius_m, or within the extent of a plane. Its laser vector is that of the
/// nearest point, moved onto the surface. A corner has one return per strip file and facet, and
/// none at all if the facets of all strips leave a coordinate undetermined (facets.h). `mounting`
/// has the boresight with which the returns are georeferenced. Returns the number of points found.
long FindControlReturns(const Flight& flight, const StripSourceOptions& options,
                        const Mounting& mounting, ControlData* control);

/// Finds control in the strips with the trajectory and the boresight of an adjustment, and adjusts
/// the flight again with it. Throws as Adjust and StripSource.
void AddControlFromStrips(const AdjustOptions& options, Flight* flight, Adjustment* adjustment);

}  // namespace dn
