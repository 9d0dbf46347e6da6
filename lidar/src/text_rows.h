#pragma once

#include <Eigen/Core>
#include <string>

namespace dn::lidar_internal {

/// These functions append numbers to a row of a text file, separated by ", ".
void AppendNumbers(const double* values, Eigen::Index count, std::string& line);

void AppendInteger(int value, std::string& line);

/// Converts between a symmetric matrix and its upper triangle xx, xy, xz, yy, yz, zz in a row.
Eigen::Matrix3d FromUpperTriangle(const double* c);
void AppendUpperTriangle(const Eigen::Matrix3d& M, std::string& line);

}  // namespace dn::lidar_internal
