#include <dn/files/flight.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TempFolder;
namespace fs = std::filesystem;

constexpr const char* kTwo = R"(
lidar:
  - {name: front, sigma_p_m: 0.03, lever_arm_m: [1, 2, 3], boresight_deg: [0.1, 0.2, 0.3]}
  - {gsd_m: 0.1, p2p: [], time_offset_s: 0.5, robust: none}
pairs_between:
  - {scanners: [front, "2"], p2p: [both.txt]}
)";

FlightConfig ParseScanners(const std::string& text) {
  return ParseFlightConfig(text, "/flights/one");
}

std::vector<std::string> Unknowns(const FlightConfig& config) {
  std::vector<std::string> names;
  for (const EstimateEntry& entry : config.estimate) names.push_back(entry.unknown);
  return names;
}

TEST(Scanners, AListHasNamesPairFilesAndNoise) {
  const FlightConfig config = ParseScanners(kTwo);
  ASSERT_EQ(NumScanners(config), 2u);
  EXPECT_THAT(ScannerNames(config), ElementsAre("front", "2"));
  EXPECT_THAT(config.lidar->p2p, ElementsAre("lidar_front/*.txt"));
  EXPECT_THAT(ScannerAt(config, 1).p2p, ElementsAre());
  const PairsBetween& between = config.pairs_between.front();
  EXPECT_EQ(between.scanner_j, 1u);
  const double second_m = 0.1 / 2.0 / std::sqrt(3.0);
  EXPECT_NEAR(between.sigma_p_m, std::sqrt(0.5 * (0.03 * 0.03 + second_m * second_m)), 1e-15);
  LidarPair pair;
  EXPECT_EQ(PairSigma(config, pair), 0.03);
  pair.scanner_i = 1;
  EXPECT_EQ(PairSigma(config, pair), between.sigma_p_m);
  pair.scanner_j = 1;
  EXPECT_EQ(PairSigma(config, pair), second_m);
}

TEST(Scanners, OneMappingIsOneScannerWithoutAName) {
  const FlightConfig config = ParseScanners("lidar: {sigma_p_m: 0.03}\n");
  EXPECT_EQ(NumScanners(config), 1u);
  EXPECT_EQ(ScannerName(config, "boresight", 0), "boresight");
  EXPECT_THAT(Unknowns(config), ElementsAre("boresight"));
  EXPECT_EQ(NumScanners(ParseScanners("name: x\n")), 0u);
}

TEST(Scanners, EachHasItsOwnUnknowns) {
  const FlightConfig config =
      ParseScanners(std::string(kTwo) +
                    "estimate: [boresight, gnss_lever_arm, lidar_lever_arm,\n"
                    "           {unknown: lidar_range_offset, scanner: '2', sigma: 0.1}]\n");
  EXPECT_THAT(Unknowns(config),
              ElementsAre("boresight", "boresight/2", "gnss_lever_arm", "lidar_lever_arm",
                          "lidar_lever_arm/2", "lidar_range_offset/2"));
  EXPECT_EQ(FindScanner(config, "lidar_range_offset/2"), 1u);
  EXPECT_EQ(FindScanner(config, "lidar_range_offset"), 0u);
  EXPECT_TRUE(IsBoresight(config.estimate[1]));
  EXPECT_FALSE(IsBoresight(config.estimate[4]));
}

TEST(Scanners, ReadAsWritten) {
  const FlightConfig config = ParseScanners(
      std::string(kTwo) + "estimate: [boresight, {unknown: lidar_lever_arm, scanner: front}]\n");
  const std::string text = FormatFlightConfig(config);
  const FlightConfig again = ParseScanners(text);
  EXPECT_EQ(FormatFlightConfig(again), text);
  EXPECT_EQ(Unknowns(again), Unknowns(config));
  EXPECT_EQ(ScannerAt(again, 1).time_offset_s, 0.5);
  EXPECT_EQ(again.pairs_between.front().sigma_p_m, config.pairs_between.front().sigma_p_m);
}

TEST(Scanners, OneOfThemCanBeSelected) {
  const FlightConfig config = ParseScanners(
      std::string(kTwo) +
      "scanner: '2'\nestimate: [boresight, {unknown: lidar_lever_arm, scanner: front}]\n");
  EXPECT_THAT(ScannerNames(config), ElementsAre("2"));
  EXPECT_TRUE(config.pairs_between.empty());
  EXPECT_THAT(Unknowns(config), ElementsAre("boresight"));
  EXPECT_NO_THROW(ExpectOneScanner(config, "this"));
  testing::InvalidInputLocation(
      [] { ExpectOneScanner(ParseScanners(kTwo), "dn gap"); },
      "the flight has 2 scanners (front, 2), and dn gap takes one: add --scanner front");
}

TEST(Scanners, MistakesAreNamed) {
  const std::pair<const char*, const char*> mistakes[] = {
      {"lidar: [{name: a, gsd_m: 1}, {name: a, gsd_m: 1}]", "two scanners have the name 'a'"},
      {"lidar: [{name: a_b, gsd_m: 1}]", "must consist of letters, digits and '-'"},
      {"lidar: []", "must have at least one scanner"},
      {"lidar: {name: a, gsd_m: 1}", "unknown key 'name'"},
      {"lidar: [{gsd_m: 1}, {gsd_m: 1, robust: huber}]", "the same robust loss"},
      {"lidar: {gsd_m: 1}\nscanner: a", "needs a list of scanners"},
      {"lidar: [{name: up, gsd_m: 1}]\nscanner: ip", "did you mean 'up'?"},
      {"lidar: {gsd_m: 1}\npairs_between: []", "needs a list of scanners"},
      {"lidar: [{gsd_m: 1}]\npairs_between: [{scanners: ['1', '1']}]", "must be another scanner"},
      {"lidar: [{gsd_m: 1}]\npairs_between: [{scanners: ['1']}]", "must name two scanners"},
      {"lidar: [{gsd_m: 1}, {gsd_m: 1}]\npairs_between: [{scanners: ['1', '2'], p2p: a.txt},"
       " {scanners: ['2', '1'], p2p: b.txt}]",
       "these two scanners are given twice"},
      {"lidar: [{gsd_m: 1}]\nestimate: [{unknown: gnss_lever_arm, scanner: '1'}]",
       "is not an unknown of a scanner"},
      {"lidar: [{gsd_m: 1}]\nestimate: [{unknown: boresight, scanner: '2'}]",
       "unknown scanner '2'; did you mean '1'?"},
      {"lidar: {gsd_m: 1}\nestimate: [{unknown: boresight, scanner: '1'}]",
       "lidar is not a list of scanners"},
      {"lidar: [{gsd_m: 1}]\nestimate: [lidar_range_offset/1]", "unknown name"},
  };
  for (const auto& [text, message] : mistakes) {
    SCOPED_TRACE(text);
    testing::InvalidInputLocation([text = text] { ParseScanners(text); }, message);
  }
}

/// A folder with pairs of two scanners and pairs between them.
class ScannerFolder : public ::testing::Test {
 protected:
  ScannerFolder() {
    Write("flight.yaml", kTwo);
    Write("lidar_front/1_2.txt", "100, 200, 0, 0, 9, 0, 1, 9\n");
    Write("both.txt", "# between\n101, 201.5, 0, 0, 8, 0, 1, 8\n102, 202.5, 0, 0, 8, 0, 1, 8\n");
    Write("strips_front/a.las", "");
  }
  void Write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name) << text;
  }
  TempFolder folder_;
};

TEST_F(ScannerFolder, PairsNameTheScannersOfTheirEnds) {
  const Flight flight = ReadFlight(folder_.path(), {.pairs = true});
  ASSERT_EQ(flight.pairs->pairs.size(), 3u);
  EXPECT_FALSE(flight.pairs->pairs[0].covariance_m2);
  const LidarPair& between = flight.pairs->pairs[2];
  EXPECT_EQ(between.scanner_i, 0);
  EXPECT_EQ(between.scanner_j, 1);
  EXPECT_EQ(between.t_i_s, 102.0);
  EXPECT_EQ(between.t_j_s, 202.0);  // the second scanner tags half a second late
  EXPECT_EQ(between.file, 1);
  EXPECT_EQ(flight.pairs->files[1].filename(), "both.txt");
  const double sigma_m = flight.config.pairs_between.front().sigma_p_m;
  EXPECT_NEAR((*between.covariance_m2)(1, 1), sigma_m * sigma_m, 1e-18);
  EXPECT_EQ((*between.covariance_m2)(0, 1), 0.0);
}

TEST_F(ScannerFolder, StripsAreThoseOfTheScanner) {
  const FlightConfig config = ReadFlightConfig(folder_.path());
  EXPECT_EQ(FindStripFiles(config, 0).size(), 1u);
  EXPECT_EQ(FindStripFiles(config, 1).size(), 0u);
  EXPECT_EQ(FindStripFiles(config).size(), 1u);
}

}  // namespace dn::files_test
