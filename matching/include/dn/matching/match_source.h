#pragma once

#include <dn/files/strip_source.h>
#include <dn/geo/trajectory.h>
#include <dn/lidar/mounting.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Points of a strip in the form that a MatchSource stores; it computes positions from them.
struct RawPoints {
  std::vector<double> t_s;
  /// Laser vector for a flight, position for bare strips, m.
  std::vector<Eigen::Vector3d> x;
  std::vector<std::uint16_t> beam;  ///< number of the laser beam; empty if unknown

  std::size_t size() const { return t_s.size(); }
  void Clear() {
    t_s.clear();
    x.clear();
    beam.clear();
  }
  void Add(double t, const Eigen::Vector3d& point) {
    t_s.push_back(t);
    x.push_back(point);
  }
};

/// A strip to be matched: all points of its files, or those with one LAS point source id.
struct MatchStrip {
  std::string name;
  std::vector<std::filesystem::path> files;
  std::optional<std::uint16_t> source = {};
};

/// Returns the strips in the files. If a file has points of two or more source ids, the files are
/// tiles and each id is a strip. Otherwise each file is a strip. Throws InvalidInput like
/// OpenStrip.
std::vector<MatchStrip> FindMatchStrips(const std::vector<std::filesystem::path>& files);

/// Strips and the positions of their points with the present alignment.
class MatchSource {
 public:
  virtual ~MatchSource() = default;

  virtual const std::vector<MatchStrip>& strips() const = 0;

  /// Passes the points of a strip to `take` in chunks; `take` may throw to stop the reading.
  virtual StripCounts Read(std::size_t strip,
                           const std::function<void(const RawPoints&)>& take) const = 0;

  /// Returns the position of a point in the map frame with the present alignment. Thread-safe.
  virtual Eigen::Vector3d Position(std::size_t strip, double t_s,
                                   const Eigen::Vector3d& x) const = 0;

  /// Returns the position of the body during a strip; nullopt for strips without a trajectory.
  /// Thread-safe.
  virtual std::optional<Eigen::Vector3d> BodyPosition(std::size_t /*strip*/, double /*t_s*/) const {
    return std::nullopt;
  }

  /// Returns the x for which the point has the position p_m.
  virtual Eigen::Vector3d RawAt(std::size_t strip, double t_s,
                                const Eigen::Vector3d& p_m) const = 0;
};

/// The strips of a flight: x is the laser vector in the scanner frame, the alignment is the
/// boresight.
class FlightMatchSource : public MatchSource {
 public:
  FlightMatchSource(const StripSourceOptions& options, const LocalFrame& frame,
                    const std::string& strips_crs, std::vector<MatchStrip> strips);

  const std::vector<MatchStrip>& strips() const override { return strips_; }
  StripCounts Read(std::size_t strip,
                   const std::function<void(const RawPoints&)>& take) const override;
  Eigen::Vector3d Position(std::size_t strip, double t_s, const Eigen::Vector3d& x) const override;
  Eigen::Vector3d RawAt(std::size_t strip, double t_s, const Eigen::Vector3d& p_m) const override;

  std::optional<Eigen::Vector3d> BodyPosition(std::size_t, double t_s) const override {
    return PoseAt(t_s).p_mb;
  }
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

/// The strips of several scanners, of one flight or of several: x is the laser vector in the frame
/// of the strip's scanner. Each scanner keeps the boresight of its source. The map frame is that of
/// the first source.
class ScannersMatchSource : public MatchSource {
 public:
  struct Scanner {
    std::string name;
    FlightMatchSource* source;  ///< must outlive this object
    bool aligned = true;        ///< false: its boresight may be off by the search angle
  };

  /// Names the strips <scanner>_<strip>.
  explicit ScannersMatchSource(std::vector<Scanner> scanners);

  const std::vector<MatchStrip>& strips() const override { return strips_; }
  StripCounts Read(std::size_t strip,
                   const std::function<void(const RawPoints&)>& take) const override;
  Eigen::Vector3d Position(std::size_t strip, double t_s, const Eigen::Vector3d& x) const override;
  Eigen::Vector3d RawAt(std::size_t strip, double t_s, const Eigen::Vector3d& p_m) const override;
  std::optional<Eigen::Vector3d> BodyPosition(std::size_t strip, double t_s) const override;

  /// Returns the derivative of Position by a left rotation of the boresight of the strip's source,
  /// m/rad.
  Eigen::Matrix3d TurnDerivative(std::size_t strip, double t_s, const Eigen::Vector3d& x) const;

  const std::vector<Scanner>& scanners() const { return scanners_; }
  /// Returns the index of the scanner of a strip, and the index of the strip in its source.
  std::size_t ScannerIndex(std::size_t strip) const { return places_[strip].scanner; }
  std::size_t StripIndex(std::size_t strip) const { return places_[strip].strip; }

 private:
  struct Place {
    std::size_t scanner, strip;
  };

  const FlightMatchSource& Source(std::size_t strip) const {
    return *scanners_[ScannerIndex(strip)].source;
  }
  const Eigen::Isometry3d& ToFirstFrame(std::size_t strip) const {
    return to_first_frame_[ScannerIndex(strip)];
  }

  std::vector<Scanner> scanners_;
  std::vector<Eigen::Isometry3d> to_first_frame_;  // from the map frame of each source
  std::vector<MatchStrip> strips_;
  std::vector<Place> places_;
};

/// Strips without a trajectory: x is the position in the file, the alignment is a shift of each
/// strip after the first. The frame m is the coordinate system of the files with its origin at a
/// point near the first one.
class BareMatchSource : public MatchSource {
 public:
  /// Throws InvalidInput like OpenStrip.
  explicit BareMatchSource(std::vector<MatchStrip> strips, PointFilter filter = {});

  const std::vector<MatchStrip>& strips() const override { return strips_; }
  StripCounts Read(std::size_t strip,
                   const std::function<void(const RawPoints&)>& take) const override;
  Eigen::Vector3d Position(std::size_t strip, double t_s, const Eigen::Vector3d& x) const override;
  Eigen::Vector3d RawAt(std::size_t strip, double t_s, const Eigen::Vector3d& p_m) const override;

  /// Returns a point of m in the coordinate system of the files, in its units.
  Eigen::Vector3d ToFile(const Eigen::Vector3d& p_m) const {
    return origin_c_ + p_m.cwiseQuotient(unit_m_);
  }
  const Eigen::Vector3d& shift_m(std::size_t strip) const { return shifts_m_[strip]; }
  void SetShift(std::size_t strip, const Eigen::Vector3d& shift_m) { shifts_m_[strip] = shift_m; }

 private:
  std::vector<MatchStrip> strips_;
  PointFilter filter_;
  Eigen::Vector3d origin_c_ = Eigen::Vector3d::Zero();  // of m, in the units of the files
  Eigen::Vector3d unit_m_ = Eigen::Vector3d::Ones();    // metres per unit of the files
  std::vector<Eigen::Vector3d> shifts_m_;
};

}  // namespace dn
