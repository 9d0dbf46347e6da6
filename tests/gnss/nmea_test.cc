#include <dn/gnss/gnss_data.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::gnss_test {

using testing::ExpectInvalid;
using testing::TempFile;

GnssData ReadNmea(const std::string& text) {
  const TempFile file("GPS.nmea", text);
  return ReadGnss(file.path(), GnssFormat::kNmea);
}

/// Returns the sentence with '$' and checksum.
std::string Sentence(const std::string& text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", sum);
  return "$" + text + end;
}

std::string Gga(const std::string& time, const std::string& fix = "1") {
  return Sentence("GPGGA," + time + ",4807.038,N,01131.000,W," + fix + ",08,0.9,545.4,M,46.9,M,,");
}

std::string Rmc(const std::string& time, const std::string& date) {
  return Sentence("GPRMC," + time + ",A,4807.038,N,01131.000,W,022.4,084.4," + date + ",003.1,W");
}

// This sentence appears in most descriptions of the format; its date is a Wednesday with 9 leap
// seconds.
TEST(Nmea, ReadsAPosition) {
  const GnssData data = ReadNmea(
      "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\n"
      "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\n");
  ASSERT_EQ(data.epochs.size(), 1u);
  const GnssEpoch& epoch = data.epochs[0];
  EXPECT_EQ(epoch.t_s, 3 * 86400 + 12 * 3600 + 35 * 60 + 19 + 9);
  EXPECT_NEAR(epoch.antenna.lat_rad * kDegPerRad, 48.0 + 7.038 / 60.0, 1e-12);
  EXPECT_NEAR(epoch.antenna.lon_rad * kDegPerRad, 11.0 + 31.0 / 60.0, 1e-12);
  EXPECT_NEAR(epoch.antenna.h_m, 545.4 + 46.9, 1e-9);
  EXPECT_FALSE(epoch.covariance_enu_m2 || epoch.velocity_enu_mps);
}

// Midnight from Saturday to Sunday is also the end of a GPS week.
TEST(Nmea, CrossesMidnightAndTheEndOfAWeek) {
  const GnssData data = ReadNmea(Gga("235930.00") + Gga("235959.50") + Rmc("235959.50", "220625") +
                                 Gga("000000.50") + Gga("000001.50"));
  ASSERT_EQ(data.epochs.size(), 4u);
  EXPECT_LT(data.epochs[0].antenna.lon_rad, 0.0);
  EXPECT_EQ(data.epochs[0].t_s, 86400 - 30 + 18);  // 22 June 2025 is a Sunday
  EXPECT_EQ(data.epochs[2].t_s - data.epochs[1].t_s, 1.0);
  const GnssData week = ReadNmea(Rmc("235940", "210625") + Gga("235940") + Gga("235943"));
  EXPECT_EQ(week.epochs[1].t_s - week.epochs[0].t_s, 3.0);
}

TEST(Nmea, CountsSentencesWithoutPosition) {
  std::string damaged = Gga("120002");
  damaged[20] = '9';
  const GnssData data = ReadNmea(Rmc("120000", "220625") + Gga("120000") + Gga("120001", "0") +
                                 damaged + Gga("120003") + "garbage\n" + Sentence("GPGSV,1,1,00"));
  EXPECT_EQ(data.epochs.size(), 2u);
  EXPECT_EQ(data.unusable_sentences, 2);
}

std::string Zda(const std::string& time, const std::string& date) {
  return Sentence("GPZDA," + time + "," + date + ",00,00");
}

// 22 June 2025 is a Sunday: the seconds of the week are those of the day, plus 18.
TEST(Nmea, OnlyValidSentencesGiveTheDate) {
  const std::string good = Rmc("120000", "220625") + Gga("120000") + Gga("120001");
  const auto first_s = [](const std::string& text) { return ReadNmea(text).epochs.at(0).t_s; };
  const auto empty = [](const std::string& time, const std::string& date) {
    return Sentence("GPRMC," + time + ",V,,,,,,," + date + ",,,N");
  };
  for (const std::string& before :
       {empty("000012.00", "060180"), empty("094930", "190923"), empty("", "210923"), empty("", ""),
        Sentence("GPZDA,,,,,00,00"), Sentence("GPZDA,094935.00,,,,00,00"),
        Sentence("GPZDA,,21,09,2023,00,00"), Zda("000012", "00,00,0000"),
        Zda("000012", "06,01,1980"), Sentence("GPGGA,000012.00,,,,,0,00,99.99,,,,,,")}) {
    SCOPED_TRACE(before);
    EXPECT_EQ(first_s(before + good), 43218.0);
  }
  const std::string zda = Zda("120001", "22,06,2025");
  EXPECT_EQ(first_s(Gga("120000") + zda), 43218.0);
  EXPECT_EQ(first_s(zda + Gga("120000")), 43218.0);
  EXPECT_EQ(first_s(Zda("000012", "06,01,1980") + Gga("120000") + zda), 43218.0);
  ExpectInvalid([&] { first_s(empty("120000", "220625") + Gga("120000")); }, "no valid RMC", 0);
}

TEST(Nmea, HemisphereLettersAreRequired) {
  const auto read = [](const std::string& ns, const std::string& ew, const std::string& sign = "") {
    return ReadNmea(Rmc("120000", "220625") +
                    Sentence("GPGGA,120000," + sign + "4807.038," + ns + ",01131.000," + ew +
                             ",1,08,0.9,545.4,M,46.9,M,,"))
        .epochs.at(0)
        .antenna;
  };
  EXPECT_LT(read("S", "E").lat_rad, 0.0);
  EXPECT_LT(read("s", "w").lat_rad, 0.0);
  EXPECT_LT(read("n", "w").lon_rad, 0.0);
  EXPECT_GT(read("n", "e").lon_rad, 0.0);
  ExpectInvalid([&] { read("", "E"); }, "no hemisphere N or S after '4807.038'", 2);
  ExpectInvalid([&] { read("N", ""); }, "no hemisphere E or W after '01131.000'", 2);
  ExpectInvalid([&] { read("E", "N"); }, "no hemisphere N or S", 2);
  ExpectInvalid([&] { read("N", "E", "-"); }, "no hemisphere N or S after '-4807.038'", 2);
}

TEST(Nmea, HeightsWithoutGeoidSeparationAreNotUsed) {
  const auto gga = [](const std::string& time, const std::string& separation) {
    return Sentence("GPGGA," + time + ",4807.038,N,01131.000,E,1,08,0.9,545.4,M," + separation +
                    ",M,,");
  };
  const std::string date = Rmc("120000", "220625");
  const GnssData some = ReadNmea(date + gga("120000", "") + gga("120001", "46.9"));
  ASSERT_EQ(some.epochs.size(), 1u);
  EXPECT_NEAR(some.epochs[0].antenna.h_m, 592.3, 1e-9);
  EXPECT_EQ(some.counts.at("gnss sentences without geoid separation, left out"), 1);
  ExpectInvalid([&] { ReadNmea(date + gga("120000", "") + gga("120001", "")); },
                "no GGA sentence states the geoid separation", 2);
  EXPECT_EQ(ReadNmea(date + gga("120000", "0.0")).epochs.size(), 1u);
  EXPECT_NEAR(ReadNmea(date + gga("120000", "-33.5")).epochs[0].antenna.h_m, 511.9, 1e-9);
}

TEST(Nmea, PositionsThatAreNotMeasured) {
  const std::string date = Rmc("120000", "220625");
  for (const char* quality : {"6", "7", "8"}) {
    const GnssData data = ReadNmea(date + Gga("120000", "4") + Gga("120001", quality));
    EXPECT_EQ(data.epochs.size(), 1u);
    EXPECT_EQ(data.counts.at("gnss positions of dead reckoning, manual or simulated, left out"), 1);
  }
  for (const char* quality : {"1", "2", "3", "4", "5", "9"}) {
    EXPECT_EQ(ReadNmea(date + Gga("120000", quality)).epochs.size(), 1u) << quality;
  }
}

// Two receivers, or one that also reports the solutions of single systems.
TEST(Nmea, OneTalkerIsUsed) {
  const auto gga = [](const std::string& talker, const std::string& time) {
    return Sentence(talker + "GGA," + time + ",4807.038,N,01131.000,E,1,08,0.9," +
                    (talker == "GN" ? "500.0" : "501.0") + ",M,46.9,M,,");
  };
  const std::string date = Rmc("120000", "220625");
  const std::string both = gga("GP", "120000") + gga("GN", "120000") + gga("GN", "120001");
  const GnssData most = ReadNmea(date + both);
  ASSERT_EQ(most.epochs.size(), 2u);
  EXPECT_NEAR(most.epochs[0].antenna.h_m, 546.9, 1e-9);
  EXPECT_EQ(most.counts.at("gnss sentences of another talker, left out"), 1);
  const GnssData equal = ReadNmea(date + gga("GP", "120000") + gga("GN", "120000"));
  ASSERT_EQ(equal.epochs.size(), 1u);
  EXPECT_NEAR(equal.epochs[0].antenna.h_m, 546.9, 1e-9);
  EXPECT_EQ(ReadNmea(date + gga("GL", "120000")).epochs.size(), 1u);
}

// 21 September 2023 is week 2280; 1024 weeks before it is 5 February 2004.
TEST(Nmea, DatesOfAMissedRolloverAreNamed) {
  const auto names_it = [](const std::string& date) {
    const GnssData data = ReadNmea(Rmc("120000", date) + Gga("120000"));
    return !data.counts.empty();
  };
  for (const char* early : {"050204", "220899", "010109"}) EXPECT_TRUE(names_it(early)) << early;
  for (const char* good : {"210923", "010112", "230394"}) EXPECT_FALSE(names_it(good)) << good;
}

TEST(Nmea, RejectsFilesWithoutDateOrPosition) {
  ExpectInvalid([] { ReadNmea(Gga("120000")); }, "gives the date of the GGA sentences", 0);
  ExpectInvalid([] { ReadNmea(Rmc("120000", "220625")); }, "no GGA sentence", 0);
  ExpectInvalid([] { ReadNmea(Rmc("120000", "990025") + Gga("120000")); }, "no such date", 1);
  ExpectInvalid([] { ReadNmea(Rmc("120000", "220625") + Gga("12:00")); }, "hhmmss", 2);
}

std::string GgaFrom(const std::string& talker, const std::string& time) {
  return Sentence(talker + "GGA," + time + ",4807.038,N,01131.000,W,1,08,0.9,545.4,M,46.9,M,,");
}

TEST(Nmea, TheCombinedSolutionWinsUnlessItIsRare) {
  std::string both = Rmc("120000", "210625") + GgaFrom("GL", "115959");
  for (const char* time : {"120000", "120001", "120002"}) {
    both += GgaFrom("GL", time) + GgaFrom("GN", time);
  }
  const GnssData combined = ReadNmea(both);
  EXPECT_EQ(combined.epochs.size(), 3u);
  EXPECT_EQ(combined.counts.at("gnss sentences of another talker, left out"), 4);
  const GnssData rare =
      ReadNmea(both + GgaFrom("GL", "120003") + GgaFrom("GL", "120004") + GgaFrom("GL", "120005"));
  EXPECT_EQ(rare.epochs.size(), 7u);
}

TEST(Nmea, OneWrongDateDoesNoHarm) {
  for (const char* wrong : {"060180", "220819", "010199"}) {
    SCOPED_TRACE(wrong);
    const GnssData data = ReadNmea(Rmc("120000", wrong) + Gga("120000") + Rmc("120001", "210625") +
                                   Gga("120001") + Rmc("120002", "210625") + Gga("120002"));
    EXPECT_EQ(data.epochs.front().t_s, 6 * 86400 + 12 * 3600 + 18);
    EXPECT_EQ(data.counts.at("gnss dates that differ from the others by more than a day, left out"),
              1);
  }
  const GnssData midnight =
      ReadNmea(Rmc("235959", "200625") + Gga("235959") + Rmc("000000", "210625") + Gga("000000") +
               Rmc("000001", "210625") + Gga("000001"));
  EXPECT_EQ(midnight.epochs.front().t_s, 6 * 86400 - 1 + 18);
  EXPECT_TRUE(midnight.counts.empty());
}

TEST(Nmea, StatesTheQualityOfPositions) {
  const GnssData data = ReadNmea(Rmc("120000", "210625") + Gga("120000", "4") + Gga("120001", "5") +
                                 Gga("120002", "2") + Gga("120003", "1") + Gga("120004", "9"));
  ASSERT_EQ(data.epochs.size(), 5u);
  for (const auto& [i, quality] : {std::pair{0, 1}, {1, 2}, {2, 4}, {3, 5}, {4, 0}}) {
    EXPECT_EQ(data.epochs[static_cast<std::size_t>(i)].quality, quality);
  }
}

TEST(Nmea, TextBeforeSentencesIsIgnored) {
  const GnssData data = ReadNmea("2025-06-21 12:00:00.1 " + Rmc("120000", "210625") + "[GPS] " +
                                 Gga("120000") + "12.5;" + Gga("120001"));
  EXPECT_EQ(data.epochs.size(), 2u);
}

TEST(Nmea, PositionsThatAreAllNotMeasuredAreNamed) {
  ExpectInvalid([] { ReadNmea(Rmc("120000", "210625") + Gga("120000", "6")); },
                "all 1 positions have quality 6, 7 or 8", 0);
}

}  // namespace dn::gnss_test
