#pragma once

#include <dn/flight/strip_source.h>
#include <dn/geo/trajectory.h>
#include <dn/lidar/mounting.h>

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Points of a strip in the form that a MatchSource keeps them: what it computes positions from.
struct RawPoints {
  std::vector<double> t_s;
  std::vector<Eigen::Vector3d> x;  ///< m; of a flight the laser vector, of bare strips the position

  std::size_t size() const { return t_s.size(); }
  void Clear() {
    t_s.clear();
    x.clear();
  }
  void Add(double t, const Eigen::Vector3d& point) {
    t_s.push_back(t);
    x.push_back(point);
  }
};

/// A strip to be matched: the points of its files, all or those with one LAS point source id.
struct MatchStrip {
  std::string name;
  std::vector<std::filesystem::path> files;
  std::optional<std::uint16_t> source = {};
};

/// The strips in the files: where one of them holds points of two source ids or more, each id is a
/// strip (files are tiles then), else each file is one. Throws InvalidInput as OpenStrip.
std::vector<MatchStrip> FindMatchStrips(const std::vector<std::filesystem::path>& files);

/// Strips, and where their points lie by the present alignment.
class MatchSource {
 public:
  virtual ~MatchSource() = default;

  virtual const std::vector<MatchStrip>& strips() const = 0;

  /// Gives `take` the points of a strip in chunks; `take` may throw to end the reading.
  virtual StripCounts Read(std::size_t strip,
                           const std::function<void(const RawPoints&)>& take) const = 0;

  /// Position of a point in m, by the present alignment. Thread-safe.
  virtual Eigen::Vector3d Position(std::size_t strip, double t_s,
                                   const Eigen::Vector3d& x) const = 0;

  /// Place of the body; nothing for strips without a trajectory. Thread-safe.
  virtual std::optional<Eigen::Vector3d> PlaceOfBody(double /*t_s*/) const { return std::nullopt; }

  /// What x has to be for the point to lie at p_m.
  virtual Eigen::Vector3d RawAt(std::size_t strip, double t_s,
                                const Eigen::Vector3d& p_m) const = 0;
};

/// The strips of a flight: x is the laser vector in the sensor frame, the alignment the boresight.
class FlightMatchSource : public MatchSource {
 public:
  FlightMatchSource(const StripSourceOptions& options, const LocalFrame& frame,
                    const std::string& strips_crs, std::vector<MatchStrip> strips);

  const std::vector<MatchStrip>& strips() const override { return strips_; }
  StripCounts Read(std::size_t strip,
                   const std::function<void(const RawPoints&)>& take) const override;
  Eigen::Vector3d Position(std::size_t strip, double t_s, const Eigen::Vector3d& x) const override;
  Eigen::Vector3d RawAt(std::size_t strip, double t_s, const Eigen::Vector3d& p_m) const override;

  std::optional<Eigen::Vector3d> PlaceOfBody(double t_s) const override { return PoseAt(t_s).p_mb; }
  MapPose PoseAt(double t_s) const { return source_.PoseAt(t_s); }
  const LocalFrame& frame() const { return frame_; }
  const Mounting& mounting() const { return mounting_; }
  void SetBoresight(const Eigen::Vector3d& boresight_rad) {
    mounting_.boresight_rad = boresight_rad;
  }

 private:
  Mounting mounting_;
  LocalFrame frame_;
  StripSource source_;
  std::vector<MatchStrip> strips_;
};

/// Strips without a trajectory: x is the position of the file, the alignment a shift of each strip
/// after the first. m is the coordinate system of the files, counted from a point near the first.
class BareMatchSource : public MatchSource {
 public:
  /// Throws InvalidInput as OpenStrip.
  explicit BareMatchSource(std::vector<MatchStrip> strips, PointFilter filter = {});

  const std::vector<MatchStrip>& strips() const override { return strips_; }
  StripCounts Read(std::size_t strip,
                   const std::function<void(const RawPoints&)>& take) const override;
  Eigen::Vector3d Position(std::size_t strip, double t_s, const Eigen::Vector3d& x) const override;
  Eigen::Vector3d RawAt(std::size_t strip, double t_s, const Eigen::Vector3d& p_m) const override;

  /// Of m in the files' system.
  const Eigen::Vector3d& origin_c_m() const { return origin_c_m_; }
  const Eigen::Vector3d& shift_m(std::size_t strip) const { return shifts_m_[strip]; }
  void SetShift(std::size_t strip, const Eigen::Vector3d& shift_m) { shifts_m_[strip] = shift_m; }

 private:
  std::vector<MatchStrip> strips_;
  PointFilter filter_;
  Eigen::Vector3d origin_c_m_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> shifts_m_;
};

}  // namespace dn
