#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace dn {

/// All points or some points of a strip, as a structure of arrays. Each array has one element per
/// point, or is empty if the file lacks that quantity.
struct StripCloud {
  std::vector<Eigen::Vector3d> p_c;  ///< in the coordinate system c of the file, m
  std::vector<double> t_s;           ///< GPS seconds of week
  std::vector<Eigen::Vector3d> u_s;  ///< laser vector in the sensor frame, m
  /// LAS point source id; in many files the number of the flight line.
  std::vector<std::uint16_t> source;
  std::vector<std::uint16_t> intensity;
  std::vector<std::uint8_t> return_number;  ///< number of this return in its pulse, from 1
  /// Number of later returns of the same pulse; 0: this is the last return.
  std::vector<std::uint8_t> returns_after;
  std::vector<std::uint8_t> classification;  ///< LAS class, such as 2 for ground
  std::vector<std::uint8_t> flags;           ///< any of the flags below
  std::vector<std::uint16_t> beam;           ///< number of the laser beam, from 0
  /// Covariance of p_c, m^2.
  std::vector<Eigen::Matrix3d> covariance_c_m2;
  /// The LAS records as read from the file, `record_bytes` per point. They preserve the LAS
  /// attributes that have no array here.
  std::string records;
  std::size_t record_bytes = 0;

  static constexpr std::uint8_t kSynthetic = 1;  ///< not measured, such as a breakline
  static constexpr std::uint8_t kWithheld = 4;   ///< deleted, but kept in the file

  std::size_t size() const { return p_c.size(); }

  /// Empties every array.
  void Clear();

  /// Removes the marked points. `drop` must have one element per point.
  void Drop(const std::vector<bool>& drop);
};

}  // namespace dn
