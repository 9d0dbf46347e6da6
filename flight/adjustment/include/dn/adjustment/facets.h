#pragma once

#include <dn/adjustment/control_search.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Radius of the returns that FindFacets needs, relative to that of the facets.
inline constexpr double kSurroundings = 1.5;

/// Finds the planar facets that meet at a corner: sides of a roof, a wall, or faces of a target
/// such as a pyramid. `at_m` is the surveyed corner, map, m. Returns within `radius_m` of it are
/// those of facets. Those further away, up to kSurroundings times the radius, show where other
/// planes begin.
///
/// Planes are taken out of the cloud one after the other. Each is the plane with the most returns
/// among those through small neighbourhoods. A return within three standard deviations of two
/// planes belongs to neither, so that the edges do not tilt them. The standard deviation is that of
/// the returns about these planes; the first one is from the neighbourhoods.
///
/// A facet has at least ten returns. Its plane passes the corner within a fifth of the radius, and
/// its returns reach so far that the plane is determined there. SurfaceFit::foot_m is the point of
/// the plane that is nearest to the corner. The result is empty if the scatter is larger than a
/// thirtieth of the radius: such returns are plants.
std::vector<SurfaceFit> FindFacets(const std::vector<NearReturn>& returns,
                                   const Eigen::Vector3d& at_m, double radius_m);

/// Returns whether planes with these unit normals determine all three coordinates of the point at
/// which they meet: the smallest eigenvalue of the sum of n n^T is at least 0.1.
bool DetermineCorner(const std::vector<Eigen::Vector3d>& normals);

}  // namespace dn
