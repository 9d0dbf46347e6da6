#include <dn/adjustment/map_layers.h>
#include <dn/report/json.h>
#include <gtest/gtest.h>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kToleranceDeg = 2e-9;

const LocalFrame& Frame() {
  static const LocalFrame frame({46.5 * kRadPerDeg, 6.5 * kRadPerDeg, 400.0});
  return frame;
}

void ExpectAt(const Json& position, const Vector3d& p_m, const LocalFrame& frame = Frame()) {
  const Geodetic place = frame.ToGeodetic(p_m);
  EXPECT_NEAR(position[0].get<double>(), place.lon_rad * kDegPerRad, kToleranceDeg);
  EXPECT_NEAR(position[1].get<double>(), place.lat_rad * kDegPerRad, kToleranceDeg);
  EXPECT_NEAR(position[2].get<double>(), place.h_m, 1e-3);
}

Swath ClockwiseSwath() {
  return {"north", {{0, -50, 900}, {10, 60, 910}}, {{-99, -50}, {-90, 60}, {95, 60}}, 12.0};
}

Json Features(const std::string& text) { return Json::parse(text)["features"]; }

TEST(MapLayers, ASwathIsAPolygonOnTheGroundAndAPath) {
  const Json features = Features(FormatSwathLayer({ClockwiseSwath()}, Frame()));
  ASSERT_EQ(features.size(), 2u);
  const Json& area = features[0]["geometry"];
  EXPECT_EQ(area["type"], "Polygon");
  const Json& ring = area["coordinates"][0];
  ASSERT_EQ(ring.size(), 4u);
  EXPECT_EQ(ring.front(), ring.back());
  ExpectAt(ring[1], {-90, 60, 12});
  ExpectAt(ring[2], {-99, -50, 12});  // counterclockwise
  EXPECT_EQ(features[1]["properties"]["strip"], "north");
  ExpectAt(features[1]["geometry"]["coordinates"][1], {10, 60, 910});
}

TEST(MapLayers, AStripWithoutPairsHasAPathOnly) {
  Swath swath = ClockwiseSwath();
  swath.outline_en_m.clear();
  const Json features = Features(FormatSwathLayer({swath}, Frame()));
  ASSERT_EQ(features.size(), 1u);
  EXPECT_EQ(features[0]["properties"]["shows"], "path");
}

TEST(MapLayers, LinesContinueBeyondTheAntimeridian) {
  const LocalFrame frame({-17.0 * kRadPerDeg, 179.9995 * kRadPerDeg, 0.0});
  Swath swath = ClockwiseSwath();
  swath.line_m = {{-40, 0, 500}, {90, 0, 500}};
  const Json line = Features(FormatSwathLayer({swath}, frame))[1]["geometry"]["coordinates"];
  EXPECT_LT(line[0][0].get<double>(), 180.0);
  EXPECT_GT(line[1][0].get<double>(), 180.0);
}

TEST(MapLayers, APairHasItsDifferencesAndManyPairsAreThinned) {
  PairResidual pair{};
  pair.strips = "1-2";
  pair.ground_m = {100, 200, 5};
  pair.before_enu_m = {1, 2, 3};
  pair.after_enu_m = {0.1, 0.2, 0.3};
  const Json one = Features(FormatPairLayer({pair}, Frame()))[0];
  ExpectAt(one["geometry"]["coordinates"], {100, 200, 5});
  EXPECT_EQ(one["properties"]["strips"], "1-2");
  EXPECT_EQ(one["properties"]["after_enu_m"][2], 0.3);
  EXPECT_EQ(Features(FormatPairLayer(std::vector(20'000, pair), Frame())).size(), 20'000u);
  EXPECT_EQ(Features(FormatPairLayer(std::vector(20'001, pair), Frame())).size(), 10'001u);
}

TEST(MapLayers, ControlIsAtItsSurveyedPlace) {
  ControlData control;
  control.points.resize(2);
  control.points[0].name = "unused";
  control.points[1].name = "roof";
  control.points[1].p_m = {7, 8, 9};
  ControlPointCheck roof;
  roof.name = "roof";
  roof.role = ControlPointCheck::Role::kCheck;
  roof.directions_enu = Eigen::Vector3d::UnitZ();
  roof.residual_m = Eigen::VectorXd::Constant(1, 0.02);
  roof.covariance_m2 = Eigen::MatrixXd::Constant(1, 1, 0.0004);
  ControlCheck check;
  check.points = {roof};
  const Json features = Features(FormatControlLayer(check, control, Frame()));
  ASSERT_EQ(features.size(), 1u);
  ExpectAt(features[0]["geometry"]["coordinates"], {7, 8, 9});
  EXPECT_EQ(features[0]["properties"]["role"], "check");
  EXPECT_DOUBLE_EQ(features[0]["properties"]["sigma_m"][0].get<double>(), 0.02);
}

}  // namespace
}  // namespace dn
