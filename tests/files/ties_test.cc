#include <dn/files/flight.h>
#include <dn/files/ties.h>

#include <set>
#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::files_test {
namespace {

using testing::ExpectInvalid;
using testing::TempFolder;

/// A flight folder with pairs between two flights.
class Ties {
 public:
  Ties() {
    for (const char* file : {"1_1.txt", "1_2.txt"}) Write(file, Rows(60, true), "");
  }

  void Write(const std::string& file, const std::vector<LidarPair>& pairs,
             const std::string& head) {
    folder_.Write("between_a_b/" + file, head + FormatPairs(pairs));
  }

  static std::vector<LidarPair> Rows(int count, bool covariance) {
    std::vector<LidarPair> pairs;
    for (int k = 0; k < count; ++k) {
      LidarPair pair;
      pair.t_i_s = 1000.0 + k;
      pair.t_j_s = 5000.0 - 2.0 * k;
      pair.u_i_s = {1, 2, 300.0 + k};
      pair.u_j_s = {2, 1, 310.0 + k};
      if (covariance) pair.covariance_m2 = 4e-4 * Eigen::Matrix3d::Identity();
      pairs.push_back(pair);
    }
    return pairs;
  }

  FlightConfig Config(const std::string& ties,
                      const std::string& lidar = "{sigma_p_m: 0.05}") const {
    return ParseFlightConfig("lidar: " + lidar + "\nties: " + ties + "\n", folder_.path());
  }

 private:
  TempFolder folder_;
};

constexpr const char* kFirst = "[{p2p: ['between_a_b/*.txt'], end: i, count: 20}]";
constexpr const char* kSecond = "[{p2p: ['between_a_b/*.txt'], end: j, count: 20}]";

TEST(Ties, BothFlightsChooseTheSamePairs) {
  const Ties ties;
  const TieData first = ReadTies(ties.Config(kFirst)), second = ReadTies(ties.Config(kSecond));
  ASSERT_EQ(first.points.points.size(), 20u);
  ASSERT_EQ(second.points.points.size(), 20u);
  std::set<std::string> names;
  for (std::size_t k = 0; k < 20; ++k) {
    const ControlPoint &a = first.points.points[k], &b = second.points.points[k];
    EXPECT_EQ(a.name, b.name);
    EXPECT_TRUE(a.is_check);
    names.insert(a.name);
    ASSERT_EQ(a.returns.size(), 1u);
    // Row k of the file has the epochs 1000 + k and 5000 - 2 k.
    EXPECT_NEAR(b.returns[0].t_s, 5000.0 - 2.0 * (a.returns[0].t_s - 1000.0), 1e-9);
    EXPECT_NEAR(b.returns[0].u_s.z() - a.returns[0].u_s.z(), 10.0, 1e-9);
    ASSERT_TRUE(first.covariance_m2[k]);
    EXPECT_NEAR((*first.covariance_m2[k])(1, 1), 4e-4, 1e-12);
    EXPECT_FALSE(second.covariance_m2[k]);
  }
  EXPECT_EQ(names.size(), 20u);
  EXPECT_TRUE(names.begin()->starts_with("between_a_b/1_1.txt:")) << *names.begin();
}

TEST(Ties, ClockAndNoiseAreThoseOfTheFlight) {
  Ties ties;
  for (const char* file : {"1_1.txt", "1_2.txt"}) ties.Write(file, Ties::Rows(40, false), "");
  const TieData data = ReadTies(ties.Config(kSecond, "{sigma_p_m: 0.05, time_offset_s: 2.5}"));
  EXPECT_LE(data.points.points.front().returns.front().t_s, 4997.5);
  const TieData first = ReadTies(ties.Config(kFirst));
  EXPECT_NEAR((*first.covariance_m2[0])(0, 0), 0.0025, 1e-12);
}

TEST(Ties, AreWrittenAsTheyWereRead) {
  const Ties ties;
  const FlightConfig config = ties.Config(kSecond);
  const FlightConfig again = ParseFlightConfig(FormatFlightConfig(config), config.folder);
  ASSERT_EQ(again.ties.size(), 1u);
  EXPECT_EQ(again.ties[0].p2p, config.ties[0].p2p);
  EXPECT_TRUE(again.ties[0].second);
  EXPECT_EQ(again.ties[0].count, 20);
}

TEST(Ties, BadOnesGetAClearError) {
  const Ties ties;
  ExpectInvalid([&] { ties.Config("[{end: i}]"); }, "needs p2p", 2);
  ExpectInvalid([&] { ties.Config("[{p2p: [a.txt]}]"); }, "needs end", 2);
  ExpectInvalid([&] { ties.Config("[{p2p: [], end: i}]"); }, "at least one file", 2);
  ExpectInvalid([&] { ties.Config("[{p2p: [a.txt], end: k}]"); }, "k", 2);
  ExpectInvalid([&] { ties.Config("[{p2p: [a.txt], end: i, count: 0}]"); }, "1", 2);
  ExpectInvalid([&] { ties.Config("[{p2p: [a.txt], end: i, count: 2000}]"); }, "at most 1000", 2);
  ExpectInvalid([&] { ReadTies(ties.Config("[{p2p: [none.txt], end: i}]")); }, "none.txt", 0);
}

TEST(Ties, ScannersThatTheyCannotHaveAreRefused) {
  const Ties ties;
  EXPECT_THROW(ReadTies(ties.Config(kFirst, "{sigma_p_m: 0.05, beams: {count: 16}}")),
               InvalidConfig);
  EXPECT_THROW(ReadTies(ties.Config(kFirst, "[{name: a, gsd_m: 0.1}, {name: b, gsd_m: 0.1}]")),
               InvalidConfig);
}

TEST(Ties, VectorsOfAnAssumedBoresightAreRefused) {
  Ties ties;
  ties.Write("1_2.txt", Ties::Rows(5, true),
             FormatOriginLine({VectorOrigin::Kind::kAssumed, Eigen::Vector3d::Zero()}));
  ExpectInvalid([&] { ReadTies(ties.Config(kFirst)); }, "assumed boresight", 0);
}

}  // namespace
}  // namespace dn::files_test
