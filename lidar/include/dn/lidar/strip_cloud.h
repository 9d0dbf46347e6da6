#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace dn {

/// Points of a strip, all or a part of them, as a structure of arrays. An array that the file has
/// nothing for is empty, every other one has an element per point.
struct StripCloud {
  std::vector<Eigen::Vector3d> p_c;   ///< in the coordinate system c of the file, m
  std::vector<double> t_s;            ///< GPS seconds of week
  std::vector<Eigen::Vector3d> u_s;   ///< laser vector in the sensor frame, m
  std::vector<std::uint16_t> source;  ///< LAS point source id: the flight line, where it is used so
  std::vector<std::uint16_t> intensity;
  std::vector<std::uint8_t> returns_after;   ///< of the same pulse; 0: it is the last
  std::vector<std::uint8_t> classification;  ///< LAS class, as 2 for ground
  /// Of p_c, m^2.
  std::vector<Eigen::Matrix3d> covariance_c_m2;
  /// The LAS records as they stood in the file, `record_bytes` per point: what LAS holds of a point
  /// beside the arrays is kept there.
  std::string records;
  std::size_t record_bytes = 0;

  std::size_t size() const { return p_c.size(); }

  /// Empties every array.
  void Clear();

  /// Removes the points that are marked; `drop` has an element per point.
  void Drop(const std::vector<bool>& drop);
};

}  // namespace dn
