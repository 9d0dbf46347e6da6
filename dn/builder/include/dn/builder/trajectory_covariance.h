#pragma once

#include <dn/builder/adjust.h>
#include <dn/flight/flight.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/trajectory_scatter.h>

#include <filesystem>
#include <string>
#include <vector>

namespace dn {

/// Joint covariance of the adjusted poses at nodes spread evenly over the strips, up to 64 and at
/// least two in each; nothing (no epochs) without strips, or with more than 32. Positions east,
/// north, up at their own places, m; attitudes in body axes, rad.
///
/// Six columns of the covariance matrix are solved for per node.
PoseCovariance ExtractPoseCovariance(const Adjustment& adjustment, const Marginals& marginals,
                                     const std::vector<StripInterval>& strips);

/// trajectory_covariance.txt: a row for each two epochs, t_j <= t_i: t_i, strip_i, t_j, strip_j,
/// and the 36 elements of the covariance of pose i with pose j, row by row; position E, N, U in m,
/// attitude about the body axes in deg.
std::string FormatPoseCovariance(const PoseCovariance& covariance);

/// Throws InvalidInput naming file and line for columns, times or variances that do not fit, and
/// where a row is missing.
PoseCovariance ReadPoseCovariance(const std::filesystem::path& file);

}  // namespace dn
