#pragma once

#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "ray_stretch.h"

namespace dn {

/// A car: a cabin on a body, both boxes with sides to the east and north. Its wheels stand on
/// ground of height zero.
struct Car {
  Eigen::AlignedBox3d body_m, cabin_m;

  void RaiseBy(double ground_m);
  Eigen::Vector2d centre_en_m() const { return body_m.center().head<2>(); }

  /// Returns the range at which a ray meets the car within the stretch.
  std::optional<double> FirstHit(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                                 const Stretch& within) const;
};

/// Streets of a town, on the borders of the squares in which its houses stand, and the cars on
/// them. Half of the cars are parked; the others are elsewhere on each visit.
class Streets {
 public:
  static constexpr double kHalfWidth_m = 4.5;
  static constexpr double kLongestCar_m = 5.0;

  /// square_m: edge of the squares; 0: there are no streets.
  Streets(const TerrainScenario& scenario, double square_m);

  bool OnStreet(const Eigen::Vector2d& en_m) const;

  /// Returns the cars along the western and the southern border of a square, on a visit.
  std::vector<Car> CarsAt(const Eigen::Vector2i& square, std::uint64_t visit) const;

 private:
  double square_m_;
  double occupied_ = 0.0;  // probability of a car in a place
  std::uint64_t seed_;
};

}  // namespace dn
