#include <dn/files/control.h>
#include <dn/files/flight_config.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/text_table.h>
#include <dn/geo/week_seconds.h>
#include <dn/lidar/pairs.h>
#include <dn/names.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "control_file.h"
#include "lower_case.h"

namespace dn {
namespace {

namespace fs = std::filesystem;
using files_internal::ControlRow;

constexpr std::size_t kMostPoints = 1000;
constexpr double kFarFromFlightM = 2e4;
constexpr double kSqrt2 = 1.4142135623730951;

const char* const kGeographic = "geographic";

/// Returns whether the name of a file says that its points are checks.
bool IsCheckFile(const fs::path& file) {
  return files_internal::LowerCase(file.filename().string()).starts_with("check");
}

/// Converts the rows of control files to the map.
class ControlReader {
 public:
  ControlReader(const FlightConfig& config, const LocalFrame& frame)
      : config_(config),
        control_(config.control.value_or(ControlConfig())),
        frame_(frame),
        crs_name_(ControlCrs(config)) {
    if (crs_name_ != kGeographic && crs_name_ != "none") crs_.emplace(crs_name_, frame);
  }

  ControlData Read() {
    data_.files = FindPairFiles(config_.folder, control_.files);
    for (const fs::path& file : data_.files) {
      const bool checks = IsCheckFile(file);
      const bool geographic = crs_name_ == kGeographic;
      for (const ControlRow& row : files_internal::ReadControlRows(file, geographic)) {
        Add(row, checks);
      }
    }
    WithholdNamed();
    return std::move(data_);
  }

 private:
  void Add(const ControlRow& row, bool check_file) {
    ControlPoint point = ToPoint(row);
    point.is_check = row.is_check.value_or(check_file);
    const auto [at, is_new] = index_.emplace(row.name, data_.points.size());
    if (is_new) {
      if (data_.points.size() == kMostPoints) {
        throw InvalidInput("more than 1000 control points; split control.files", row.where);
      }
      data_.points.push_back(std::move(point));
    } else {
      AddReturn(point, &data_.points[at->second]);
    }
  }

  /// Adds a further return of a point that an earlier row describes.
  static void AddReturn(const ControlPoint& row, ControlPoint* point) {
    const bool same = row.p_m == point->p_m && row.is_check == point->is_check &&
                      row.is_corner == point->is_corner &&
                      row.plane.has_value() == point->plane.has_value();
    if (!same || row.returns.empty() || point->returns.empty()) {
      throw InvalidInput(
          "point '" + row.name + "' is given twice, first in " + point->where.ToString() +
              "; rename one of them. Only further returns (t, ux, uy, uz) of the same point repeat "
              "its name, coordinates and role",
          row.where);
    }
    point->returns.push_back(row.returns.front());
  }

  ControlPoint ToPoint(const ControlRow& row) const {
    ControlPoint point;
    point.name = row.name;
    point.where = row.where;
    point.is_corner = row.is_corner;
    const Eigen::Matrix3d J_c_m = Place(row, &point.p_m);
    if (row.normal) {
      point.plane = ToPlane(row, J_c_m);
    } else {
      point.covariance_m2 = PointCovariance(row, point.p_m, J_c_m);
    }
    if (row.t_s) {
      const double t_s = *row.t_s - (config_.lidar ? config_.lidar->time_offset_s : 0.0);
      if (!IsWeekSeconds(t_s)) CheckWeekSeconds(t_s, row.where);
      point.returns.push_back({.t_s = t_s, .u_s = row.u_s, .where = row.where});
    }
    return point;
  }

  /// Sets the position in map and returns d coordinates / d position, in m for geographic ones.
  Eigen::Matrix3d Place(const ControlRow& row, Eigen::Vector3d* p_m) const {
    if (row.geographic) {
      const Geodetic at{row.coordinates.x() * kRadPerDeg, row.coordinates.y() * kRadPerDeg,
                        row.coordinates.z()};
      CheckGeodetic(at, row.where);
      *p_m = frame_.ToMap(at);
      return frame_.R_m_enu(*p_m).transpose();
    }
    if (!crs_) {
      throw InvalidConfig(
          "the coordinate system of the control points is not known; state it in flight.yaml, "
          "control: {crs: utm:32n} or the like",
          row.where);
    }
    try {
      *p_m = crs_->ToMap(row.coordinates);
    } catch (const InvalidInput& error) {
      throw InvalidInput(std::string(error.what()) + "; the coordinate system is " + crs_name_ +
                             " (control.crs, or else strips_crs)",
                         row.where);
    }
    return crs_->J_c_m(*p_m);
  }

  ControlPlane ToPlane(const ControlRow& row, const Eigen::Matrix3d& J_c_m) const {
    ControlPlane plane;
    const Eigen::Vector3d normal_m = J_c_m.transpose() * *row.normal;
    plane.normal_m = normal_m.normalized();
    const double per_metre = normal_m.norm() / row.normal->norm();
    if (row.normal_sigma) {
      plane.sigma_m = *row.normal_sigma / per_metre;
    } else {
      plane.sigma_m = StatedSigma(row).dot(plane.normal_m.cwiseAbs());
    }
    plane.extent_m = row.extent.value_or(0.0) / per_metre;
    return plane;
  }

  Eigen::Matrix3d PointCovariance(const ControlRow& row, const Eigen::Vector3d& p_m,
                                  const Eigen::Matrix3d& J_c_m) const {
    const Eigen::Matrix3d root =
        row.sigma ? Eigen::Matrix3d(J_c_m.inverse() * row.sigma->asDiagonal())
                  : Eigen::Matrix3d(frame_.R_m_enu(p_m) * StatedSigma(row).asDiagonal());
    return root * root.transpose();
  }

  const Eigen::Vector3d& StatedSigma(const ControlRow& row) const {
    if (control_.sigma_enu_m) return *control_.sigma_enu_m;
    throw InvalidInput(
        "point '" + row.name +
            "' has no sigma: add the columns sigma_e, sigma_n, sigma_h (a plane: sigma) to the "
            "file, or state control.sigma_enu_m in flight.yaml",
        row.where);
  }

  void WithholdNamed() {
    for (const std::string& name : control_.checks) {
      const auto at = index_.find(name);
      if (at == index_.end()) {
        std::vector<std::string> names;
        for (const ControlPoint& point : data_.points) names.push_back(point.name);
        throw InvalidInput(
            "control.checks names '" + name + "', but no control file has it" +
                (names.empty() ? "" : "; the nearest is " + NearestName(name, names)),
            {config_.file.string()});
      }
      data_.points[at->second].is_check = true;
    }
  }

  const FlightConfig& config_;
  ControlConfig control_;
  const LocalFrame& frame_;
  std::string crs_name_;
  std::optional<PointCrs> crs_;
  std::map<std::string, std::size_t> index_;
  ControlData data_;
};

/// Returns the horizontal distance from the nearest of the positions, m.
double Distance(const Eigen::Vector3d& p_m, const std::vector<Eigen::Vector3d>& flown_m) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& at : flown_m) {
    least_m = std::min(least_m, (at - p_m).head<2>().norm());
  }
  return least_m;
}

/// Returns whether a point is near the flight if its latitude and longitude are exchanged.
bool IsSwapped(const Eigen::Vector3d& p_m, const std::vector<Eigen::Vector3d>& flown_m,
               const LocalFrame& frame) {
  const Geodetic at = frame.ToGeodetic(p_m);
  const Geodetic swapped{at.lon_rad, at.lat_rad, at.h_m};
  try {
    CheckGeodetic(swapped);
  } catch (const InvalidInput&) {
    return false;
  }
  return Distance(frame.ToMap(swapped), flown_m) < kFarFromFlightM;
}

}  // namespace

std::string ControlCrs(const FlightConfig& config) {
  return config.control && !config.control->crs.empty() ? config.control->crs : config.strips_crs;
}

double LaserSigma(const FlightConfig& config) {
  if (config.control && config.control->laser_sigma_m) return *config.control->laser_sigma_m;
  return config.lidar->sigma_p_m / kSqrt2;
}

bool HasControl(const FlightConfig& config) {
  if (config.control && config.control->files != ControlConfig().files) return true;
  try {
    return !FindPairFiles(config.folder, ControlConfig().files).empty();
  } catch (const InvalidInput&) {
    return false;
  }
}

ControlData ReadControl(const FlightConfig& config, const LocalFrame& frame) {
  return ControlReader(config, frame).Read();
}

void ExpectControlNear(const ControlData& control, const std::vector<Eigen::Vector3d>& flown_m,
                       const LocalFrame& frame, const std::string& crs) {
  for (const ControlPoint& point : control.points) {
    const double distance_m = Distance(point.p_m, flown_m);
    if (flown_m.empty() || distance_m < kFarFromFlightM) continue;
    throw InvalidInput(
        "point '" + point.name + "' is " + FormatDouble(std::round(distance_m / 1e3)) +
            " km from the flight" +
            (IsSwapped(point.p_m, flown_m, frame)
                 ? "; latitude and longitude are exchanged: the order is lat, lon, height, or name "
                   "the columns in a header"
                 : ": check the coordinate system (" + crs +
                       "; control.crs states it) and the order of the columns"),
        point.where);
  }
}

}  // namespace dn
