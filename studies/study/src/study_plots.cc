#include <dn/axis_names.h>
#include <dn/geo/local_frame.h>
#include <dn/study/study_output.h>
#include <fmt/format.h>

#include <algorithm>

namespace dn {
namespace {

constexpr std::size_t kMostPoints = 2000;
constexpr double kMdegPerRad = 1e3 * kDegPerRad;

template <class Row, class Get>
PlotSeries Curve(const std::string& label, const std::vector<Row>& rows, const Get& get) {
  PlotSeries series{label, {}};
  const std::size_t step = std::max<std::size_t>(1, rows.size() / kMostPoints);
  for (std::size_t i = 0; i < rows.size(); i += step) {
    series.points.emplace_back(rows[i].t_s - rows.front().t_s, get(rows[i]));
  }
  return series;
}

StudyPlot SigmaPlot(const StudyResult& study) {
  PlotPanel panel;
  PlotSeries sigmas{"sigma", {}, PlotStyle::kBars};
  const Eigen::Vector3d sigma_mdeg = study.boresight.sigma_rad() * kMdegPerRad;
  for (int i = 0; i < 3; ++i) {
    sigmas.points.emplace_back(sigma_mdeg[i], i);
    panel.rows.emplace_back(kRollPitchYaw[i]);
  }
  panel.series.push_back(sigmas);
  return {"sigmas.svg", study.name + ": boresight", "standard deviation [mdeg]", {panel}};
}

StudyPlot CorrelationPlot(const StudyResult& study) {
  std::vector<PlotPanel> panels;
  for (int i = 0; i < 3; ++i) {
    PlotPanel panel{fmt::format("{} [%]", kRollPitchYaw[i]), {}};
    for (int axis = 0; axis < 3; ++axis) {
      panel.series.push_back(
          Curve(fmt::format("accelerometer {}", kXyz[axis]), study.correlations,
                [=](const BiasCorrelationAt& at) { return 100.0 * at.accel(i, axis); }));
      panel.series.push_back(
          Curve(fmt::format("gyro {}", kXyz[axis]), study.correlations,
                [=](const BiasCorrelationAt& at) { return 100.0 * at.gyro(i, axis); }));
    }
    panels.push_back(panel);
  }
  return {"correlations.svg", study.name + ": correlation of the boresight with the biases",
          "time since start [s]", panels};
}

StudyPlot TrajectoryPlot(const StudyResult& study) {
  std::vector<PlotPanel> panels{{"position [m]", {}}, {"attitude [deg]", {}}};
  for (int i = 0; i < 3; ++i) {
    panels[0].series.push_back(Curve(kEnu[i], study.trajectory, [=](const TrajectorySigma& sigma) {
      return sigma.position_enu_m[i];
    }));
    panels[1].series.push_back(
        Curve(kAttitudeAngles[i], study.trajectory,
              [=](const TrajectorySigma& sigma) { return sigma.rph_rad[i] * kDegPerRad; }));
  }
  return {"trajectory_sigma.svg", study.name + ": standard deviations of the trajectory",
          "time since start [s]", panels};
}

}  // namespace

std::vector<StudyPlot> StudyPlots(const StudyResult& study) {
  return {SigmaPlot(study), CorrelationPlot(study), TrajectoryPlot(study)};
}

}  // namespace dn
