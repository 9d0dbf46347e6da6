#include <dn/files/flight.h>
#include <dn/geo/text_table.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using testing::ExpectInvalid;
using testing::ExpectInvalidIn;
using ::testing::HasSubstr;
using testing::TempFolder;

const char* const kYaml = R"(
imu: {grade: airins}
gnss: {}
lidar: {gsd_m: 0.2}
trajectory: {}
)";

std::string FormatRow(const std::vector<double>& values) {
  std::string row;
  for (const double value : values) row += (row.empty() ? "" : ", ") + FormatDouble(value);
  return row + "\n";
}

/// Returns IMU data of a level body at rest that faces north, 50 Hz.
std::string StillImu(double t0_s, double t1_s) {
  std::string text;
  for (int i = 0; t0_s + 0.02 * i <= t1_s; ++i) {
    text += FormatRow({t0_s + 0.02 * i, 1e-5, -2e-5, 3e-5, 0.0, 0.0, -9.8});
  }
  return text;
}

std::string StillGnss(double t0_s, double t1_s) {
  std::string text;
  for (double t_s = t0_s; t_s <= t1_s; t_s += 1.0) text += FormatRow({t_s, 46.5, 6.5, 400.0});
  return text;
}

std::string StillTrajectory(double t0_s, double t1_s) {
  std::string text;
  for (double t_s = t0_s; t_s <= t1_s; t_s += 0.5) {
    text += FormatRow({t_s, 46.6, 6.6, 300.0, 1.0, 0.0, 0.0, 0.0});
  }
  return text;
}

std::string Pair(double t_i_s, double t_j_s) {
  return FormatRow({t_i_s, t_j_s, 1, 2, 30, 3, 4, 30});
}

/// Writes a complete small flight: IMU 100..140 s, GNSS 95..145 s, trajectory 100..140 s, two
/// pairs.
void WriteFlight(const TempFolder& folder, const std::string& yaml = kYaml) {
  folder.Write("flight.yaml", yaml);
  folder.Write("IMU.txt", StillImu(100.0, 140.0));
  folder.Write("GPS.txt", StillGnss(95.0, 145.0));
  folder.Write("trajectory.txt", StillTrajectory(100.0, 140.0));
  folder.Write("LiDAR_p2p.txt", Pair(105, 125) + Pair(110, 130));
}

constexpr FlightNeeds kDn{.imu = true, .gnss = true, .pairs = true};
constexpr FlightNeeds kGh{.pairs = true, .trajectory = true};
constexpr FlightNeeds kEverythingThere{
    .imu = true, .gnss = true, .pairs = true, .trajectory = true, .optional = true};

TEST(ReadFlight, ReadsWhatIsNeeded) {
  const TempFolder folder;
  WriteFlight(folder);
  const Flight flight = ReadFlight(folder.path(), kDn);
  ASSERT_TRUE(flight.imu && flight.gnss && flight.pairs);
  EXPECT_FALSE(flight.trajectory || flight.initial_guess || flight.reference);
  EXPECT_EQ(flight.pairs->pairs.size(), 2u);
  EXPECT_EQ(flight.counts.at("pairs"), 2);
  EXPECT_EQ(flight.counts.at("imu samples"), static_cast<long>(flight.imu->samples.size()));
  EXPECT_GE(flight.read_time_s, 0.0);
}

TEST(ReadFlight, NeedsOnlyTheFilesItReads) {
  const TempFolder folder;
  folder.Write("flight.yaml", "lidar: {gsd_m: 0.2}\n");
  folder.Write("trajectory.txt", StillTrajectory(100.0, 140.0));
  folder.Write("lidar/1_2.txt", Pair(105, 125));
  const Flight flight = ReadFlight(folder.path(), kGh);
  EXPECT_EQ(flight.config.trajectory->file, "trajectory.txt");
  EXPECT_EQ(flight.config.lidar->p2p, std::vector<std::string>{"lidar/*.txt"});
  EXPECT_EQ(flight.pairs->pairs.size(), 1u);
}

TEST(ReadFlight, ReadsInitialGuessAndReferenceWhereTheyAre) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("reference.txt", StillTrajectory(100.0, 102.0));
  folder.Write("initial_guess.out",
               FormatSbet(ReadFlight(folder.path(), kGh).trajectory->points()));
  const Flight flight = ReadFlight(folder.path(), {.imu = true});
  ASSERT_TRUE(flight.reference && flight.initial_guess);
  EXPECT_EQ(flight.reference->points().size(), 5u);
  EXPECT_EQ(flight.initial_guess->points().size(), 81u);
}

TEST(ReadFlight, ReadsTheReferenceBesideTheRest) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("reference.txt", StillTrajectory(100.0, 140.0));
  FlightNeeds needs = kDn;
  needs.threads = 2;
  EXPECT_EQ(ReadFlight(folder.path(), needs).reference->points().size(),
            ReadFlight(folder.path(), kDn).reference->points().size());
  folder.Write("reference.txt", "100, 46.6\n");
  ExpectInvalidIn([&] { ReadFlight(folder.path(), needs); }, "columns", "reference.txt");
  folder.Write("IMU.txt", "1 2 3\n");  // this error is reported first
  ExpectInvalidIn([&] { ReadFlight(folder.path(), needs); }, "columns", "IMU.txt");
}

TEST(ReadFlight, RemovesKnownOffsetsOfTheTags) {
  const TempFolder folder;
  WriteFlight(folder,
              "imu: {grade: airins, time_offset_s: 0.5}\ngnss: {time_offset_s: -18}\n"
              "lidar: {gsd_m: 0.2, time_offset_s: 2}\n");
  const Flight flight = ReadFlight(folder.path(), kDn);
  EXPECT_NEAR(flight.imu->t_end_s(), 139.5, 1e-9);
  EXPECT_EQ(flight.gnss->epochs.front().t_s, 113.0);  // the first tag is 95
  EXPECT_EQ(flight.pairs->pairs[0].t_i_s, 103.0);
  EXPECT_EQ(flight.pairs->pairs[0].t_j_s, 123.0);
}

TEST(ReadFlight, TimeSince1980IsBroughtToSecondsOfWeekByItsOffset) {
  const TempFolder folder;
  WriteFlight(folder, "imu: {grade: airins}\ngnss: {time_offset_s: 1419465600}\n");
  folder.Write("GPS.txt", StillGnss(1419465700.0, 1419465730.0));
  const Flight flight = ReadFlight(folder.path(), {.imu = true, .gnss = true});
  EXPECT_EQ(flight.gnss->epochs.front().t_s, 100.0);
  EXPECT_EQ(flight.gnss->epochs.size(), 31u);
}

TEST(ReadFlight, DropsAndCountsGnssOutsideTheImuData) {
  const TempFolder folder;
  WriteFlight(folder);
  const Flight flight = ReadFlight(folder.path(), kDn);
  EXPECT_EQ(flight.gnss->epochs.size(), 41u);
  EXPECT_EQ(flight.gnss->epochs.front().t_s, 100.0);
  EXPECT_EQ(flight.counts.at("gnss rows outside imu data"), 10);
}

TEST(ReadFlight, DropsAndCountsWhatIsOutsideTheTimeSpan) {
  const TempFolder folder;
  WriteFlight(folder, std::string(kYaml) + "time_span_s: [104, 128]\n");
  const Flight flight = ReadFlight(folder.path(), kDn);
  EXPECT_EQ(flight.counts.at("pairs outside time span"), 1);
  EXPECT_EQ(flight.pairs->pairs.size(), 1u);
  EXPECT_EQ(flight.counts.at("gnss rows outside time span"), 26);
  EXPECT_GE(flight.imu->t_begin_s(), 103.9);
  EXPECT_LE(flight.imu->t_end_s(), 128.0);
}

TEST(ReadFlight, TheOriginIsTheFirstGnssPositionForEveryCommand) {
  const TempFolder folder;
  WriteFlight(folder);
  const double lat_rad = ReadFlight(folder.path(), kDn).frame.origin().lat_rad;
  EXPECT_NEAR(lat_rad, 46.5 * 3.14159265358979323846 / 180.0, 1e-14);  // one rounding of 0.8
  EXPECT_EQ(ReadFlight(folder.path(), kGh).frame.origin().lat_rad, lat_rad);
}

TEST(ReadFlight, TheOriginIsElseTheFirstTrajectoryPosition) {
  const TempFolder folder;
  WriteFlight(folder, "lidar: {gsd_m: 0.2}\n");
  const Flight flight = ReadFlight(folder.path(), kGh);
  EXPECT_EQ(flight.frame.origin().lat_rad, flight.trajectory->points()[0].position.lat_rad);
}

TEST(ReadFlight, TheConfiguredOriginWins) {
  const TempFolder folder;
  WriteFlight(folder, std::string(kYaml) + "frame: {origin_deg_m: [10, 20, 30]}\n");
  EXPECT_EQ(ReadFlight(folder.path(), kDn).frame.origin().h_m, 30.0);
}

TEST(ReadFlight, SelectsPairsAndCountsTheRestButFindsStripsInAll) {
  const TempFolder folder;
  WriteFlight(folder);
  std::string text;
  for (int i = 0; i < 100; ++i) text += Pair(101 + 0.1 * i, 121 + 0.1 * i);
  folder.Write("LiDAR_p2p.txt", text);
  FlightConfig config = ReadFlightConfig(folder.path());
  config.lidar->pairs.strategy = PairSelection::Strategy::kMax;
  config.lidar->pairs.count = 2;
  const Flight flight = ReadFlight(config, kDn);
  EXPECT_EQ(flight.pairs->pairs.size(), 2u);
  EXPECT_EQ(flight.counts.at("pairs not selected"), 98);
  EXPECT_EQ(FindStrips(flight).size(), 2u);
}

TEST(ReadFlight, BringsPairsAndGnssAcrossAWeekRollover) {
  const TempFolder folder;
  WriteFlight(folder);
  std::string imu = StillImu(604780.0, 604799.99);
  imu += StillImu(0.0, 20.0);
  folder.Write("IMU.txt", imu);
  folder.Write("GPS.txt", StillGnss(5.0, 15.0));
  folder.Write("LiDAR_p2p.txt", Pair(604790.0, 10.0));
  const Flight flight = ReadFlight(folder.path(), kDn);
  EXPECT_EQ(flight.pairs->pairs[0].t_i_s, 604790.0);
  EXPECT_EQ(flight.pairs->pairs[0].t_j_s, 604810.0);
  EXPECT_EQ(flight.gnss->epochs.front().t_s, 604805.0);
}

TEST(ReadFlight, BringsStripsAcrossAWeekRollover) {
  const TempFolder folder;
  WriteFlight(folder,
              std::string(kYaml) +
                  "strips: [{name: a, t0: 604785, t1: 604795}, {name: b, t0: 5, t1: 25}]\n");
  folder.Write("IMU.txt", StillImu(604780.0, 604799.99) + StillImu(0.0, 20.0));
  folder.Write("GPS.txt", StillGnss(5.0, 15.0));
  folder.Write("LiDAR_p2p.txt", Pair(604790.0, 10.0));
  const std::vector<StripInterval> strips = FindStrips(ReadFlight(folder.path(), kDn));
  ASSERT_EQ(strips.size(), 2u);
  EXPECT_EQ(strips[0].t0_s, 604785.0);
  EXPECT_EQ(strips[0].t1_s, 604795.0);
  EXPECT_EQ(strips[1].t0_s, 604805.0);
  EXPECT_EQ(strips[1].t1_s, 604825.0);  // later than the data, but the strip stays in one piece
}

TEST(ReadFlight, OptionalLeavesOutWhatIsNotThere) {
  const TempFolder folder;
  folder.Write("flight.yaml", "{imu: {grade: airins}, lidar: {gsd_m: 1, p2p: absent/*.txt}}");
  folder.Write("IMU.txt", StillImu(100.0, 140.0));
  const Flight flight = ReadFlight(folder.path(), kEverythingThere);
  EXPECT_TRUE(flight.imu);
  EXPECT_FALSE(flight.gnss || flight.pairs || flight.trajectory);
}

TEST(ReadFlight, OptionalWantsPairsInsideOneSourceAndCountsThoseOutsideTheOther) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("trajectory.txt", StillTrajectory(100.0, 128.0));
  const Flight flight = ReadFlight(folder.path(), kEverythingThere);
  EXPECT_EQ(flight.counts.at("pairs outside the trajectory"), 1);
  folder.Write("IMU.txt", StillImu(100.0, 128.0));
  ExpectInvalid([&] { ReadFlight(folder.path(), kEverythingThere); }, "outside the IMU data", 2);
}

TEST(ReadFlightErrors, MissingFolderOrConfiguration) {
  const TempFolder folder;
  EXPECT_THROW(ReadFlight(folder.path() / "absent", kDn), InvalidConfig);
  EXPECT_THROW(ReadFlight(folder.path(), kDn), InvalidConfig);
}

TEST(ReadFlightErrors, MissingSection) {
  const TempFolder folder;
  folder.Write("flight.yaml", "name: a\n");
  for (const auto& [wanted, section] :
       std::vector<std::pair<FlightNeeds, std::string>>{{{.imu = true}, "'imu'"},
                                                        {{.gnss = true}, "'gnss'"},
                                                        {{.pairs = true}, "'lidar'"},
                                                        {{.trajectory = true}, "'trajectory'"}}) {
    SCOPED_TRACE(section);
    const FlightNeeds& needs = wanted;  // a structured binding cannot be captured
    EXPECT_THROW(ReadFlight(folder.path(), needs), InvalidConfig);
    ExpectInvalid([&] { ReadFlight(folder.path(), needs); }, section, 0);
  }
}

TEST(ReadFlightErrors, MissingDataFileNamesPathAndKey) {
  const TempFolder folder;
  folder.Write("flight.yaml", kYaml);
  const auto expect = [&](const FlightNeeds& needs, const char* file, const char* key) {
    SCOPED_TRACE(key);
    ExpectInvalid([&] { ReadFlight(folder.path(), needs); }, file, 0);
    ExpectInvalid([&] { ReadFlight(folder.path(), needs); }, key, 0);
  };
  expect({.imu = true}, "/IMU.txt", "imu.file");
  expect({.gnss = true}, "/GPS.txt", "gnss.file");
  expect({.trajectory = true}, "/trajectory.out", "trajectory.file");
  expect({.pairs = true}, "LiDAR_p2p.txt", "lidar.p2p");
}

TEST(ReadFlightErrors, NoOverlapOfImuAndGnssNamesBothSpans) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("GPS.txt", StillGnss(500.0, 510.0));
  const auto read = [&] { ReadFlight(folder.path(), kDn); };
  ExpectInvalid(read, "500 .. 510 s", 0);
  ExpectInvalid(read, ".. 140 s", 0);
}

TEST(ReadFlightErrors, NothingInsideTheTimeSpan) {
  const TempFolder folder;
  WriteFlight(folder, std::string(kYaml) + "time_span_s: [500, 600]\n");
  EXPECT_THROW(ReadFlight(folder.path(), {.imu = true}), InvalidInput);
  ExpectInvalid([&] { ReadFlight(folder.path(), {.gnss = true}); }, "inside time_span_s", 0);
  ExpectInvalid([&] { ReadFlight(folder.path(), {.pairs = true}); }, "inside time_span_s", 0);
}

TEST(ReadFlightErrors, PairOutsideTheImuDataNamesEpochLineAndSpan) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("LiDAR_p2p.txt", Pair(105, 125) + "# note\n" + Pair(110, 150.5));
  const auto read = [&] { ReadFlight(folder.path(), kDn); };
  ExpectInvalid(read, "t_j = 150.5 s lies outside the IMU data (", 3);
  ExpectInvalid(read, ".. 140 s)", 3);
}

TEST(ReadFlightErrors, PairsFarFromAnyGnssPosition) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("IMU.txt", StillImu(100.0, 240.0));
  folder.Write("LiDAR_p2p.txt", Pair(190, 210) + Pair(195, 215));
  ExpectInvalid([&] { ReadFlight(folder.path(), kDn); },
                "GNSS covers 100 .. 145 s, but the pairs lie at 190 .. 195 s", 0);
  folder.Write("LiDAR_p2p.txt", Pair(105, 125) + Pair(195, 215));
  EXPECT_EQ(ReadFlight(folder.path(), kDn).counts.at("pairs far from GNSS"), 1);
}

TEST(ReadFlightErrors, PairOutsideTheTrajectory) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("LiDAR_p2p.txt", Pair(99, 125));
  ExpectInvalid([&] { ReadFlight(folder.path(), kGh); },
                "t_i = 99 s lies outside the trajectory (100 .. 140 s)", 1);
}

TEST(ReadFlight, LeavesOutAndCountsPairsAndGnssInHoles) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("LiDAR_p2p.txt", Pair(105, 125) + Pair(110, 130) + Pair(111, 131));
  folder.Write("IMU.txt", StillImu(100.0, 120.0) + StillImu(128.0, 140.0));
  folder.Write("trajectory.txt", StillTrajectory(100.0, 120.0) + StillTrajectory(128.0, 140.0));
  const Flight dn = ReadFlight(folder.path(), kDn);
  EXPECT_EQ(dn.counts.at("pairs in IMU gaps"), 1);
  EXPECT_EQ(dn.counts.at("gnss rows in IMU gaps"), 7);
  ASSERT_EQ(dn.pairs->pairs.size(), 2u);
  EXPECT_EQ(dn.pairs->pairs[0].t_j_s, 130.0);
  const Flight gh = ReadFlight(folder.path(), kGh);
  EXPECT_EQ(gh.counts.at("pairs in trajectory gaps"), 1);
  EXPECT_EQ(gh.pairs->pairs.size(), 2u);
  const Flight check = ReadFlight(folder.path(), kEverythingThere);
  EXPECT_EQ(check.counts.at("pairs in IMU gaps"), 1);
  EXPECT_EQ(check.pairs->pairs.size(), 3u);
}

TEST(ReadFlight, BridgesALostRowWithAllItsPairs) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("IMU.txt", StillImu(100.0, 109.985) + StillImu(110.02, 140.0));
  folder.Write("LiDAR_p2p.txt", Pair(109.99, 125) + Pair(110.019, 130));
  const Flight flight = ReadFlight(folder.path(), kDn);
  EXPECT_EQ(flight.counts.at("imu holes bridged"), 1);
  EXPECT_EQ(flight.counts.count("imu gaps"), 0u);
  EXPECT_EQ(flight.pairs->pairs.size(), 2u);
  std::string yaml = kYaml;
  yaml.replace(yaml.find("airins"), 6, "airins, max_gap_s: 0.03");
  folder.Write("flight.yaml", yaml);
  folder.Write("LiDAR_p2p.txt", Pair(109.99, 125) + Pair(111, 130));
  const Flight split = ReadFlight(folder.path(), kDn);
  EXPECT_EQ(split.counts.at("imu gaps"), 1);
  EXPECT_EQ(split.counts.at("pairs in IMU gaps"), 1);
  yaml.replace(yaml.find("0.03"), 4, "0.01");
  folder.Write("flight.yaml", yaml);
  ExpectInvalid([&] { ReadFlight(folder.path(), kDn); }, "imu.max_gap_s is 0.01 s, shorter", 2);
}

// Epochs go from a microsecond inside to a microsecond outside. The IMU data begin one interval
// before the first tag.
TEST(ReadFlight, KeepsTheGnssEpochsThatTheImuDataCoverToTheLastBit) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("IMU.txt", StillImu(100.02, 140.0));
  const ImuData imu = *ReadFlight(folder.path(), {.imu = true}).imu;
  const double inside[] = {imu.t_begin_s(), imu.t_begin_s() + 1e-6, imu.t_end_s() - 1e-6,
                           imu.t_end_s()};
  const double outside[] = {imu.t_begin_s() - 1e-6, imu.t_end_s() + 1e-6, imu.t_end_s() + 1e-9};
  const auto kept = [&](double t_s) {
    std::vector<double> t{t_s, 110.0, 120.0};
    std::sort(t.begin(), t.end());
    std::string gnss;
    for (const double x : t) gnss += FormatRow({x, 46.5, 6.5, 400.0});
    folder.Write("GPS.txt", gnss);
    return ReadFlight(folder.path(), kDn).gnss->epochs.size() == 3;
  };
  for (const double t_s : inside) EXPECT_TRUE(kept(t_s)) << FormatDouble(t_s);
  for (const double t_s : outside) EXPECT_FALSE(kept(t_s)) << FormatDouble(t_s);
}

TEST(ReadFlight, CountsRepeatedPairsOnce) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("LiDAR_p2p.txt", Pair(105, 125) + Pair(110, 130) + Pair(105, 125));
  const Flight flight = ReadFlight(folder.path(), kDn);
  EXPECT_EQ(flight.counts.at("repeated pairs"), 1);
  EXPECT_EQ(flight.counts.at("pairs"), 2);
}

TEST(ReadFlightErrors, MostPairsInHoles) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("LiDAR_p2p.txt", Pair(105, 115) + Pair(105, 125) + Pair(106, 126));
  folder.Write("IMU.txt", StillImu(100.0, 120.0) + StillImu(128.0, 140.0));
  ExpectInvalid([&] { ReadFlight(folder.path(), kDn); },
                "2 of 3 pairs have an epoch in a gap of the IMU data", 2);
  folder.Write("trajectory.txt", StillTrajectory(100.0, 120.0) + StillTrajectory(128.0, 140.0));
  ExpectInvalid([&] { ReadFlight(folder.path(), kGh); },
                "in a gap of the trajectory, the first in 120 .. 128 s", 2);
}

TEST(ReadFlightErrors, AFileInMillisecondsIsNamed) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("LiDAR_p2p.txt", Pair(105000, 125000));
  ExpectInvalidIn([&] { ReadFlight(folder.path(), kDn); },
                  "outside the IMU data (99.98 .. 140 s); is the time in milliseconds? "
                  "Divide it by 1000",
                  "LiDAR_p2p.txt");
  WriteFlight(folder);
  std::string gnss = FormatRow({0, 46.5, 6.5, 400.0});
  for (int i = 95; i < 145; ++i) gnss += FormatRow({1000.0 * i, 46.5, 6.5, 400.0});
  folder.Write("GPS.txt", gnss);
  ExpectInvalidIn([&] { ReadFlight(folder.path(), kDn); }, "is the time in milliseconds?",
                  "GPS.txt");
}

TEST(ReadFlightErrors, AnotherTimeZoneOrDayIsNamed) {
  const auto pairs = [](double shift_s, const std::string& what) {
    const TempFolder folder;
    WriteFlight(folder);
    folder.Write("LiDAR_p2p.txt", Pair(105 + shift_s, 125 + shift_s));
    ExpectInvalidIn([&] { ReadFlight(folder.path(), kDn); }, what, "LiDAR_p2p.txt");
  };
  pairs(7200,
        "inside 2 hours earlier: check the time zone and the day, or set "
        "lidar.time_offset_s: 7200");
  pairs(3 * 86400.0, "inside 3 days earlier");
  const TempFolder folder;
  WriteFlight(folder);
  std::string gnss;
  for (int i = 100; i < 140; ++i) gnss += FormatRow({86400.0 + i, 46.5, 6.5, 400.0});
  folder.Write("GPS.txt", gnss);
  ExpectInvalidIn([&] { ReadFlight(folder.path(), kDn); },
                  "inside 24 hours earlier: check the time zone and the day, or set "
                  "gnss.time_offset_s: 86400",
                  "GPS.txt");
}

TEST(ReadFlightErrors, WhatIsNoRegularFileIsNamed) {
  for (const char* name : {"IMU.txt", "GPS.txt", "LiDAR_p2p.txt", "reference.out", "flight.yaml"}) {
    const TempFolder folder;
    WriteFlight(folder);
    const std::filesystem::path path = folder.path() / name;
    std::filesystem::remove(path);
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    const auto read = [&] { ReadFlight(folder.path(), kDn); };
    ExpectInvalidIn(read, "this is a named pipe, not a regular file", name);
    std::filesystem::remove(path);
    std::filesystem::create_directory(path);
    ExpectInvalidIn(read, "this is a folder, not a regular file", name);
    std::filesystem::remove(path);
    std::filesystem::create_symlink("/dev/zero", path);
    ExpectInvalidIn(read, "this is a device, not a regular file", name);
  }
}

TEST(ReadFlightErrors, BadDataNamesFileAndLine) {
  const TempFolder folder;
  WriteFlight(folder);
  folder.Write("GPS.txt", "100, 46.5, 6.5, 400\n101, 46.5, 6.5, x\n");
  try {
    ReadFlight(folder.path(), kDn);
    FAIL() << "no InvalidInput";
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.where().file, HasSubstr("GPS.txt"));
    EXPECT_EQ(e.where().line, 2);
  }
}

}  // namespace dn::files_test
