#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <dn/matching/match.h>
#include <dn/matching/match_output.h>
#include <dn/rotation.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "testing/expect_invalid.h"
#include "testing/las_bytes.h"
#include "testing/rough_town.h"
#include "testing/temp_folder.h"

namespace dn::matching_test {

using Eigen::Vector3d;
using testing::RoughTown;
using testing::TempFolder;

constexpr double kEdge_m = 150.0;
constexpr int kPoints = 80000;
const Vector3d kShift_m(1.31, -0.87, 0.42);

constexpr double kInterval_s = 1e-4;

/// Returns the text of a strip; with several beams, they measure the points in turn.
std::string Strip(const std::vector<Vector3d>& points_m, double t0_s, std::size_t beams = 1) {
  std::string text;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    text += FormatDouble(t0_s + kInterval_s * static_cast<double>(i));
    for (int axis = 0; axis < 3; ++axis) text += ", " + FormatDouble(points_m[i][axis]);
    text += ", 0, 0, 100";
    if (beams > 1) text += ", " + std::to_string(i % beams);
    text += "\n";
  }
  return text;
}

/// A source of a strip on a straight path, in a map frame with this origin.
FlightMatchSource StraightFlight(const Geodetic& origin) {
  NavPoint begin, end;
  begin.position = {0.8, 0.1, 900.0};
  begin.q_nb = Exp(Vector3d(0.05, -0.02, 0.7));
  end = begin;
  end.t_s = 10.0;
  end.position.lat_rad += 1e-4;
  StripSourceOptions options;
  options.trajectory = Trajectory({begin, end});
  options.made_with.mounting.boresight_rad = Vector3d(0.01, 0.02, -0.03);
  return FlightMatchSource(options, LocalFrame(origin), "map", {{"1", {}}});
}

TEST(ScannersMatchSource, FlightsMayHaveDifferentMapFrames) {
  FlightMatchSource first = StraightFlight({0.8, 0.1, 400.0});
  FlightMatchSource second = StraightFlight({0.801, 0.099, 0.0});
  const ScannersMatchSource source({{"first", &first}, {"second", &second}});
  const Vector3d u_s(20.0, -300.0, 400.0);
  const Vector3d p_m = source.Position(0, 4.0, u_s);
  constexpr double kRounding_m = 1e-6;
  EXPECT_LT((source.Position(1, 4.0, u_s) - p_m).norm(), kRounding_m);
  EXPECT_LT((source.RawAt(1, 4.0, p_m) - u_s).norm(), kRounding_m);
  EXPECT_LT((*source.BodyPosition(1, 4.0) - *source.BodyPosition(0, 4.0)).norm(), kRounding_m);
  EXPECT_GT((second.Position(0, 4.0, u_s) - p_m).norm(), 1e3);
}

class BareStrips : public ::testing::Test {
 protected:
  void Write(const RoughTown& town) const {
    folder_.Write("1.txt", Strip(town.Points(kPoints, kEdge_m, 0.02, Vector3d::Zero(), 1), 1000.0));
    folder_.Write("2.txt", Strip(town.Points(kPoints, kEdge_m, 0.02, kShift_m, 2), 2000.0));
  }

  BareMatchSource Source() const {
    return BareMatchSource(FindMatchStrips({folder_.path() / "1.txt", folder_.path() / "2.txt"}));
  }

  TempFolder folder_;
};

using BareStripsManyRuns = BareStrips;

TEST_F(BareStrips, ADistanceFarBelowThatOfThePointsIsRefused) {
  Write(RoughTown());
  for (const double gsd_m : {1e-12, 1e-9, 1e-3, 0.04}) {
    BareMatchSource source = Source();
    MatchOptions options;
    options.gsd_m = gsd_m;
    EXPECT_THROW(MatchBareStrips(&source, options), InvalidConfig) << gsd_m;
    testing::ExpectInvalidIn([&] { MatchBareStrips(&source, options); },
                             "has one point per 0.54 m by 0.54 m", "1.txt");
  }
}

TEST_F(BareStrips, PairsAreTheSamePointOfTheGroundWithinTheirSigmas) {
  Write(RoughTown());
  BareMatchSource source = Source();
  MatchOptions options;
  options.search_m = 5.0;
  const MatchResult result = MatchBareStrips(&source, options);
  ASSERT_EQ(result.strip_pairs.size(), 1u);
  const std::vector<MatchedPair>& pairs = result.strip_pairs[0].pairs;
  ASSERT_GE(pairs.size(), 10u);
  EXPECT_NEAR(result.gsd_m, kEdge_m / std::sqrt(kPoints), 0.1);
  double squares_m2 = 0.0, normalised = 0.0;
  for (const MatchedPair& pair : pairs) {
    const Vector3d error_m = pair.p_j_m - pair.p_i_m - kShift_m;
    squares_m2 += error_m.squaredNorm();
    normalised += error_m.dot(pair.pair.covariance_m2->inverse() * error_m) / 3.0;
  }
  const auto n = static_cast<double>(pairs.size());
  EXPECT_LT(std::sqrt(squares_m2 / n), 0.5 * result.gsd_m);
  EXPECT_GT(normalised / n, 0.2);
  EXPECT_LT(normalised / n, 3.0);
  EXPECT_LT((source.shift_m(1) + kShift_m).norm(), 0.1);
}

TEST_F(BareStripsManyRuns, TheResultDoesNotDependOnTheThreads) {
  Write(RoughTown());
  std::string text[2];
  for (int threads = 1; threads <= 2; ++threads) {
    BareMatchSource source = Source();
    MatchOptions options;
    options.search_m = 5.0;
    options.threads = threads;
    const MatchResult result = MatchBareStrips(&source, options);
    text[threads - 1] =
        FormatJson(MatchJson("", result, source)) + FormatMatches(result.strip_pairs[0]);
  }
  EXPECT_EQ(text[0], text[1]);
}

TEST_F(BareStrips, EachEndOfAPairHasOneBeam) {
  constexpr int kBeams = 4;
  const RoughTown town;
  const auto write = [&](const char* name, const Vector3d& shift_m, double t0_s, unsigned seed) {
    folder_.Write(name, Strip(town.Points(kPoints, kEdge_m, 0.02, shift_m, seed), t0_s, kBeams));
  };
  write("1.txt", Vector3d::Zero(), 1000.0, 1);
  write("2.txt", kShift_m, 2000.0, 2);
  BareMatchSource source = Source();
  MatchOptions options;
  options.search_m = 5.0;
  options.beams = kBeams;
  const MatchResult result = MatchBareStrips(&source, options);
  EXPECT_NEAR(result.gsd_m, 2.0 * kEdge_m / std::sqrt(kPoints), 0.2);
  const auto measured = [&](double t_s, double t0_s) {
    return static_cast<int>(std::lround((t_s - t0_s) / kInterval_s)) % kBeams;
  };
  std::set<std::pair<int, int>> beams;
  for (const MatchedPair& pair : result.strip_pairs.at(0).pairs) {
    EXPECT_EQ(pair.pair.beam_i, measured(pair.pair.t_i_s, 1000.0));
    EXPECT_EQ(pair.pair.beam_j, measured(pair.pair.t_j_s, 2000.0));
    EXPECT_LT((pair.p_j_m - pair.p_i_m - kShift_m).norm(), result.gsd_m);
    beams.insert({pair.pair.beam_i, pair.pair.beam_j});
  }
  EXPECT_GE(beams.size(), 4u);
}

TEST_F(BareStrips, PointsWithoutBeamsAreRefusedWhereTheScannerHasSome) {
  Write(RoughTown());
  BareMatchSource source = Source();
  MatchOptions options;
  options.search_m = 5.0;
  options.beams = 4;
  testing::ExpectInvalidIn([&] { MatchBareStrips(&source, options); }, "the points have no beam",
                           "1.txt");
}

TEST_F(BareStrips, FlatGroundGivesNoPairs) {
  Write(RoughTown(true));
  BareMatchSource source = Source();
  const MatchResult result = MatchBareStrips(&source, {});
  EXPECT_EQ(result.pairs(), 0u);
}

TEST_F(BareStrips, StripsOfDifferentPlacesAreRefused) {
  const RoughTown town;
  folder_.Write("1.txt", Strip(town.Points(2000, 50.0, 0.02, Vector3d::Zero(), 1), 1000.0));
  folder_.Write("2.txt", Strip(town.Points(2000, 50.0, 0.02, Vector3d(900.0, 0, 0), 2), 2000.0));
  BareMatchSource source = Source();
  testing::ExpectInvalidIn([&] { MatchBareStrips(&source, {}); }, "no two strips overlap", "1.txt");
}

TEST_F(BareStrips, AStrayPointIsNamedAndNoRasterOfItsSizeMade) {
  const RoughTown town;
  const std::vector<Vector3d> stray{Vector3d(4e5, 4e5, 0.0)};
  for (const char* name : {"1.txt", "2.txt"}) {
    folder_.Write(name, Strip(town.Points(20000, 60.0, 0.02, Vector3d::Zero(), 1), 1000.0) +
                            Strip(stray, 1500.0));
  }
  BareMatchSource source = Source();
  MatchOptions options;
  options.gsd_m = 0.4;
  testing::ExpectInvalidIn([&] { MatchBareStrips(&source, options); }, "remove stray points", "");
}

/// Returns the heights of the used points of a strip and the counts of dropped points.
std::pair<std::vector<double>, StripCounts> UsedHeights(const std::filesystem::path& file,
                                                        const PointFilter& filter) {
  const BareMatchSource source(FindMatchStrips({file}), filter);
  std::vector<double> heights_m;
  const StripCounts counts = source.Read(0, [&](const RawPoints& points) {
    for (const Vector3d& p_m : points.x) heights_m.push_back(source.ToFile(p_m).z());
  });
  return {heights_m, counts};
}

TEST_F(BareStrips, PointsInFeetAreConverted) {
  testing::LasBytes las;
  las.points = {{0, 0, 0, 1.0, 0, 1, 1, "", 1, 2}, {10000, 0, 20000, 2.0, 0, 1, 1, "", 1, 2}};
  las.vlrs = {{"LASF_Projection", 2112,
               R"(PROJCS["x",GEOGCS["NAD83",DATUM["x",SPHEROID["GRS 1980",6378137,298.257222101]],)"
               R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],)"
               R"(PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],)"
               R"(PARAMETER["central_meridian",-117],PARAMETER["scale_factor",0.9996],)"
               R"(PARAMETER["false_easting",1640416.67],PARAMETER["false_northing",0],)"
               R"(UNIT["US survey foot",0.3048006096012192]])"}};
  folder_.Write("1.las", las.Build());
  const BareMatchSource source(FindMatchStrips({folder_.path() / "1.las"}));
  std::vector<Vector3d> p_m;
  source.Read(0, [&](const RawPoints& points) { p_m = points.x; });
  ASSERT_EQ(p_m.size(), 2u);
  constexpr double kFootM = 0.3048006096012192;
  const Vector3d in_file = source.ToFile(p_m[1]) - source.ToFile(p_m[0]);
  EXPECT_GT(in_file.x(), 1.0);
  EXPECT_NEAR((p_m[1] - p_m[0]).x(), kFootM * in_file.x(), 1e-9);
  // The header states no unit of the heights: they are metres.
  EXPECT_NEAR((p_m[1] - p_m[0]).z(), in_file.z(), 1e-9);
  las.vlrs.clear();
  folder_.Write("2.las", las.Build());
  testing::ExpectInvalidIn(
      [&] {
        BareMatchSource(FindMatchStrips({folder_.path() / "1.las", folder_.path() / "2.las"}));
      },
      "other units", "2.las");
}

TEST_F(BareStrips, ReturnsAndClassesAreChosen) {
  testing::LasBytes las;
  las.points = {{0, 0, 20000, 1.0, 0, 1, 1, "", 2, 5},
                {10, 0, 1000, 1.0, 0, 1, 2, "", 2, 2},
                {5000, 0, 3000, 2.0, 0, 1, 1, "", 1, 6}};
  folder_.Write("1.las", las.Build());
  const auto file = folder_.path() / "1.las";
  EXPECT_EQ(UsedHeights(file, {}).first, (std::vector<double>{20.0, 1.0, 3.0}));
  const auto [last, counts] = UsedHeights(file, {.last_returns = true, .classes = {}});
  EXPECT_EQ(last, (std::vector<double>{1.0, 3.0}));
  EXPECT_EQ(counts.points, 3u);
  EXPECT_EQ(counts.kept, 2u);
  EXPECT_EQ(counts.dropped.at("not the last return of its pulse"), 1u);
  const auto [ground, by_class] = UsedHeights(file, {.last_returns = true, .classes = {2}});
  EXPECT_EQ(ground, (std::vector<double>{1.0}));
  EXPECT_EQ(by_class.dropped.at("of another class"), 1u);
}

TEST_F(BareStrips, OneStripIsTooFew) {
  folder_.Write("1.txt", Strip(RoughTown().Points(100, 20.0, 0.02, Vector3d::Zero(), 1), 1000.0));
  BareMatchSource source(FindMatchStrips({folder_.path() / "1.txt"}));
  EXPECT_THROW(MatchBareStrips(&source, {}), InvalidInput);
}

TEST(ComputeMisalignment, HasTheDirectionOfTheDifferences) {
  const Misalignment east =
      ComputeMisalignment({Vector3d(2, 0, 0), Vector3d(4, 0, 0), Vector3d(3, 0, 1)});
  EXPECT_NEAR(east.heading_deg, 90.0, 1e-12);
  EXPECT_NEAR(east.same_direction, 1.0, 1e-12);
  EXPECT_NEAR(east.mean_enu_m.x(), 3.0, 1e-12);
  EXPECT_NEAR(east.rms_m, std::sqrt((4.0 + 16.0 + 10.0) / 3.0), 1e-12);
  const Misalignment none = ComputeMisalignment({Vector3d(1, 0, 0), Vector3d(-1, 0, 0)});
  EXPECT_NEAR(none.same_direction, 0.0, 1e-12);
}

}  // namespace dn::matching_test
