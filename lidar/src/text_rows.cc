#include "text_rows.h"

#include <dn/geo/text_table.h>

namespace dn::lidar_internal {

void AppendNumbers(const double* values, Eigen::Index count, std::string& line) {
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!line.empty()) line += ", ";
    line += FormatDouble(values[i]);
  }
}

void AppendInteger(int value, std::string& line) {
  line += ", ";
  line += std::to_string(value);
}

Eigen::Matrix3d FromUpperTriangle(const double* c) {
  Eigen::Matrix3d M;
  M << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
  return M;
}

void AppendUpperTriangle(const Eigen::Matrix3d& M, std::string& line) {
  const double upper[6] = {M(0, 0), M(0, 1), M(0, 2), M(1, 1), M(1, 2), M(2, 2)};
  AppendNumbers(upper, 6, line);
}

}  // namespace dn::lidar_internal
