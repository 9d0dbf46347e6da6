#pragma once

#include <dn/builder/edge_context.h>
#include <dn/builder/inertial_edges.h>
#include <dn/builder/pair_factors.h>
#include <dn/factors/point_to_control.h>
#include <dn/files/control.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

namespace dn {

/// A laser return on a control point, and the node to which it is attached.
struct ControlEdge {
  std::size_t point = 0;      ///< index into ControlData::points
  std::size_t return_of = 0;  ///< index into ControlPoint::returns
  std::size_t node = 0;
  /// Index of the inertial edge that conditions the noise of the increments, as in PairEdge.
  std::optional<std::size_t> bridge = {};
  FactorId id = -1;
};

/// A control point in the network.
struct ControlNode {
  std::size_t point = 0;  ///< index into ControlData::points
  /// Deviation of the true point from the surveyed one along `directions`, m.
  BlockId deviation = -1;
  Eigen::Matrix<double, 3, Eigen::Dynamic> directions;  ///< columns, map axes
  /// The accuracy of the survey; not active for checks, and -1 without a survey.
  FactorId survey = -1;
  std::vector<std::size_t> edges;  ///< indices into ControlEdges::edges
};

/// The edges of laser returns on control points and planes (PointToControl), on tie points, or on
/// the planes of surface pairs. Tie points and surfaces have no survey: their position is an
/// unknown without a prior. Each return is attached to the node before its epoch.
///
/// Block names: "control/<name>" for the deviation of a point, "control_datum_shift". Factor
/// groups: "control" and "control plane" for the survey, "lidar control" and "lidar control plane"
/// for the returns, "withheld control" for those on checks. A tie point is "tie/<name>", its
/// position in map, and its returns are of the group "tie point". The plane of a surface pair is
/// "surface/<name>", its distance from the origin of map, and its returns are of the group "lidar
/// surface".
class ControlEdges {
 public:
  enum class Kind { kControl, kTies, kSurfaces };

  ControlEdges(const EdgeContext& context, const InertialEdges& inertial, Network* net, Kind kind)
      : context_(context), inertial_(inertial), net_(*net), kind_(kind) {}

  /// Adds the points that have a laser return. A return with an IMU gap between it and its node is
  /// left out. So is a point without any return, or a surface without both. A second call adds the
  /// points that have got returns since. `control` must outlive the object.
  void Add(const ControlData& control);

  const std::vector<ControlEdge>& edges() const { return edges_; }
  const std::vector<ControlNode>& points() const { return points_; }
  /// Returns the control point of an entry of points().
  const ControlPoint& Point(const ControlNode& node) const { return control_->points[node.point]; }
  /// Returns the shift from the datum of GNSS to that of the control, map axes; nullopt if the
  /// configuration states none.
  std::optional<Block<Vec<3>>> datum_shift() const { return datum_shift_; }

  /// Returns the factor of an edge for another calibration at the present trajectory and biases.
  /// Its blocks are those of the edge, then the effects of the calibration in the order of
  /// PairEffectIndices. `bridge`: the inertial factor of the edge's bridge with this calibration.
  std::shared_ptr<const FactorBase> Factor(
      const ControlEdge& edge, const CalibrationState& calibration,
      const std::shared_ptr<const PreintegratedInertial>& bridge) const;

  /// Integrates the increments to all returns again, at the present biases and this calibration.
  void Repreintegrate(const CalibrationState& calibration);

 private:
  void AddDatumShift();
  void AddPoint(std::size_t index, double margin_s, const CalibrationState& calibration);
  std::optional<ControlEdge> Attach(std::size_t point, std::size_t return_of,
                                    double margin_s) const;
  std::shared_ptr<const PreintegratedInertial> BridgeInUse(const ControlEdge& edge) const;
  void AddDeviation(const ControlPoint& point, ControlNode* node);
  void AddSurvey(const ControlPoint& point, ControlNode* node);
  void MoveToReturn(const ControlNode& node);
  const FactorGroup& ReturnGroup(const ControlPoint& point, const ControlReturn& one) const;
  std::vector<BlockId> Blocks(const ControlEdge& edge, BlockId deviation) const;

  const EdgeContext& context_;
  const InertialEdges& inertial_;
  Network& net_;
  Kind kind_;
  const ControlData* control_ = nullptr;
  std::optional<Block<Vec<3>>> datum_shift_;
  std::vector<ControlEdge> edges_;
  std::vector<ControlNode> points_;
};

}  // namespace dn
