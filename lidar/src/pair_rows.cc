#include "pair_rows.h"

#include "laser_vector.h"

namespace dn::lidar_internal {

LidarPair ReadEnds(const double* row, int file, const FileLocation& where) {
  LidarPair pair;
  pair.t_i_s = row[0];
  pair.t_j_s = row[1];
  pair.u_i_s = Eigen::Vector3d(row[2], row[3], row[4]);
  pair.u_j_s = Eigen::Vector3d(row[5], row[6], row[7]);
  pair.file = file;
  pair.line = where.line;
  for (const double t_s : {pair.t_i_s, pair.t_j_s}) {
    if (!IsWeekSeconds(t_s)) CheckWeekSeconds(t_s, where);
  }
  CheckLaserVector(pair.u_i_s, where);
  CheckLaserVector(pair.u_j_s, where);
  return pair;
}

}  // namespace dn::lidar_internal
