#include <dn/geo/gps_time.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/named_columns.h>
#include <dn/geo/text_fields.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::geo_test {

using ::testing::ElementsAre;
using testing::ExpectInvalid;
using testing::TempFile;

const std::vector<std::string> kQuantities{"lat", "lon", "h", "vu", "heading"};

TextTable Read(const std::string& text, const ColumnNames& names,
               const std::vector<std::string>& quantities) {
  const TempFile file("table.txt", text);
  return ReadNamedColumns(file.path(), names, quantities);
}

TEST(TextFields, SeparatorsBlanksAndQuotes) {
  EXPECT_THAT(SplitFields(" 1  2\t3\r"), ElementsAre("1", "2", "3"));
  EXPECT_THAT(SplitFields("1, 2,,\"a, b\", 5, "), ElementsAre("1", "2", "", "a, b", "5"));
  EXPECT_THAT(SplitFields("1;2,5;x y;"), ElementsAre("1", "2,5", "x y"));
  EXPECT_TRUE(SplitFields(" \t\r").empty());
  EXPECT_THAT(SplitFields("1.5,$VNIMU,-2.5*5F\r"), ElementsAre("1.5", "$VNIMU", "-2.5"));
  EXPECT_THAT(SplitFields("1 2*3"), ElementsAre("1", "2*3"));
  EXPECT_EQ(FieldNumber("+1.5"), 1.5);
  EXPECT_FALSE(FieldNumber("nan"));
  EXPECT_FALSE(FieldNumber("1.#IND"));
  EXPECT_FALSE(FieldNumber("1x"));
}

TEST(NamedColumns, AnyOrderSignAndUnit) {
  const TextTable t = Read(
      "time (ms),note,height,lon,lat,vd\n"
      "s,,m,deg,deg,m/s\n"
      "1000,\"on, line\",500,0.5,46,-1.5,further\n"
      "# a remark\n"
      "2000,text,501,0.5,47,2\n",
      {"t_ms", "skip", "h", "-lon_rad", "lat", "vd"}, {"lat", "lon", "h", "vu"});
  ASSERT_EQ(t.rows(), 2u);
  ASSERT_EQ(t.columns, 5u);
  EXPECT_EQ(t.row(0)[0], 1.0);
  EXPECT_EQ(t.row(0)[1], 46.0);
  EXPECT_EQ(t.row(0)[2], -0.5 * kDegPerRad);
  EXPECT_EQ(t.row(0)[3], 500.0);
  EXPECT_EQ(t.row(0)[4], 1.5);
  EXPECT_EQ(t.row(1)[4], -2.0);
  EXPECT_EQ(t.lines, (std::vector<long>{3, 5}));
}

TEST(NamedColumns, UnitsOfTimeAndWeeks) {
  for (const auto& [name, text] : {std::pair{"t", "1.5"},
                                   {"t_ms", "1500"},
                                   {"t_us", "1500000"},
                                   {"t_ns", "1500000000"},
                                   {"t_min", "0.025"},
                                   {"t_100us", "15000"}}) {
    EXPECT_DOUBLE_EQ(Read(std::string(text) + " 7\n", {name, "h"}, {"h"}).row(0)[0], 1.5) << name;
  }
  const TextTable t = Read("2280 604799 1\n2281 0 2\n", {"week", "t", "h"}, {"h"});
  EXPECT_EQ(t.row(0)[0], 604799.0);
  EXPECT_EQ(t.row(1)[0], 604800.0);
}

TEST(NamedColumns, OtherNamesOfAQuantity) {
  const std::vector<std::string> quantities{"lat", "lon", "h", "heading"};
  for (const ColumnNames& names : {ColumnNames{"t", "east", "north", "up", "yaw"},
                                   ColumnNames{"t", "x", "y", "z", "heading"}}) {
    EXPECT_EQ(Read("1 2 3 4 5\n", names, quantities).values, (std::vector<double>{1, 2, 3, 4, 5}));
  }
}

TEST(TextFields, MessagesOfAReceiver) {
  EXPECT_THAT(SplitMessage("%RAWIMUSA,2280,381000.0;2280,381000.005,-1,\"a,b\",2*c01b540c\r"),
              ElementsAre("RAWIMUSA", "2280", "381000.0", "2280", "381000.005", "-1", "a,b", "2"));
  EXPECT_THAT(SplitMessage("#A,1;2"), ElementsAre("A", "1", "2"));
  EXPECT_THAT(SplitMessage("$VNIMU,+01.5,-2*5F"), ElementsAre("VNIMU", "+01.5", "-2"));
  EXPECT_THAT(SplitMessage("IMU 1 2"), ElementsAre("IMU", "1", "2"));
  EXPECT_TRUE(SplitMessage("#\r").empty());
}

TEST(NamedColumns, ConditionsSelectRows) {
  const std::string log =
      "IMU, 1, 9, bad\n"
      "GPS, 1.5, 500, FIX\n"
      "# remark\n"
      "GPS, 2.5, 501, NONE\n"
      "GPS, 3.5, 502, FLOAT\n"
      "GPS, 4.5\n";
  const TextTable t = Read(log, {"=GPS", "t", "h", "=FIX|FLOAT"}, {"h"});
  EXPECT_EQ(t.values, (std::vector<double>{1.5, 500.0, 3.5, 502.0}));
  EXPECT_EQ(t.lines, (std::vector<long>{2, 5}));
  // A condition elsewhere leaves comments as they are.
  EXPECT_EQ(Read("# 1 5 A\n1 5 A\n2 6 B\n", {"t", "h", "=A"}, {"h"}).rows(), 1u);
  ExpectInvalid([&] { Read(log, {"=BARO", "t", "h"}, {"h"}); }, "no rows of numbers", 0);
}

TEST(NamedColumns, ColumnsThatAreAdded) {
  const std::vector<std::string> quantities{"lat", "lon", "h"};
  const TextTable t = Read(
      "100 500000000 46 30 36 -0 7 12 400 48.5\n",
      {"t", "nsec", "lat", "lat_min", "lat_sec", "lon", "lon_min", "lon_sec", "h", "undulation"},
      quantities);
  EXPECT_DOUBLE_EQ(t.row(0)[0], 100.5);
  EXPECT_DOUBLE_EQ(t.row(0)[1], 46.51);
  EXPECT_DOUBLE_EQ(t.row(0)[2], -0.12);
  EXPECT_DOUBLE_EQ(t.row(0)[3], 448.5);
  const TextTable south =
      Read("1 46 30 0 7 5\n", {"t", "-lat", "lat_min", "lat_sec", "lon", "h"}, quantities);
  EXPECT_DOUBLE_EQ(south.row(0)[1], -46.5);
}

TEST(NamedColumns, AHeaderMayBeginWithNumbers) {
  const TextTable t =
      Read("Datum 1984 x\n2020 01 02\n1 2 3 4\n", {"t", "skip", "skip", "h"}, {"h"});
  EXPECT_EQ(t.values, (std::vector<double>{1.0, 4.0}));
}

TEST(NamedColumns, RejectsBadRowsEachByItsOwnMessage) {
  const ColumnNames names{"t", "skip", "lat"};
  const auto read = [&](const std::string& text) { return [=] { Read(text, names, {"lat"}); }; };
  ExpectInvalid(read("1 x 46\n2 x\n"), "row has 2 columns, but `columns` names 3", 2);
  ExpectInvalid(read("1 x 46\n2 x 1.#IND\n"), "'1.#IND' is not a finite number", 2);
  ExpectInvalid(read("1 x 46\ntime x 46\n"), "'time' is not a number", 2);
  ExpectInvalid(read("time a lat\n1 x nan\n"), "'nan' is not a finite number", 2);
  ExpectInvalid(read("time a lat\n"), "no rows of numbers", 0);
  ExpectInvalid([&] { Read("1 2 3\n", names, {"lat", "lon"}); }, "`columns` has no lon", 0);
}

TEST(NamedColumns, ChecksNames) {
  const auto check = [](const ColumnNames& names) {
    return [=] { CheckColumnNames(names, kQuantities); };
  };
  check({"t_ms", "week", "lat", "-lon", "z", "skip", "skip", "vd", "yaw_rad"})();
  check({"=GPS", "t", "lat_min", "undulation", "nsec", "=A|B", "=A"})();
  ExpectInvalid(
      [] {
        CheckColumnNames({"t", "undulation"}, {"wx"});
      },
      "'undulation' is not a column", 0);
  ExpectInvalid(check({"t", "latitude"}), "'latitude' is not a column; the columns are t", 0);
  ExpectInvalid(check({"t", "lat", "-lat"}), "'-lat' is named twice", 0);
  ExpectInvalid(check({"t", "vu", "vd"}), "'vd' is named twice", 0);
  ExpectInvalid(check({"lat", "lon"}), "no column is the time", 0);
  EXPECT_EQ(FormatColumnNames({"t", "-fx", "skip"}), "[t, -fx, skip]");
}

TEST(NamedColumns, UnitsOfLengthsAndAngles) {
  const std::vector<std::string> quantities{"lat", "lon", "h", "sigma_e", "sigma_n", "sigma_u"};
  const TextTable t =
      Read("1 465000000 630.6 5000 20 0.0009\n",
           {"t", "lat_1e7", "lon_ddmm", "h_ft", "sigma_en_mm", "var_u"}, quantities);
  EXPECT_DOUBLE_EQ(t.row(0)[1], 46.5);
  EXPECT_DOUBLE_EQ(t.row(0)[2], 6.51);
  EXPECT_DOUBLE_EQ(t.row(0)[3], 1524.0);
  EXPECT_DOUBLE_EQ(t.row(0)[4], 0.02);
  EXPECT_DOUBLE_EQ(t.row(0)[5], 0.02);
  EXPECT_DOUBLE_EQ(t.row(0)[6], 0.03);
  EXPECT_DOUBLE_EQ(Read("1 -12330.6\n", {"t", "lon_ddmm"}, {"lon"}).row(0)[1], -123.51);
  for (const auto& [name, metres] : {std::pair{"h_mm", 1.5}, {"h_cm", 15.0}, {"z_mm", 1.5}}) {
    EXPECT_DOUBLE_EQ(Read("1 1500\n", {"t", name}, {"h"}).row(0)[1], metres) << name;
  }
  EXPECT_TRUE(HasColumn({"t", "sigma_en"}, "sigma_n"));
  ExpectInvalid(
      [&] {
        CheckColumnNames({"t", "sigma_en", "sigma_n"}, quantities);
      },
      "named twice", 0);
  ExpectInvalid([&] { CheckColumnNames({"t", "lat_mm"}, quantities); }, "is not a column", 0);
  ExpectInvalid([&] { Read("1 -4\n", {"t", "var_u"}, {"sigma_u"}); }, "variance is negative", 1);
}

TEST(NamedColumns, HemispheresGiveTheSign) {
  const ColumnNames names{"t", "lat", "lat_ns", "lon", "lon_ew"};
  const TextTable t = Read("1,46.5,S,6.5,w\n2,46.5,N,6.5,E\n", names, {"lat", "lon"});
  EXPECT_EQ(t.row(0)[1], -46.5);
  EXPECT_EQ(t.row(0)[2], -6.5);
  EXPECT_EQ(t.row(1)[1], 46.5);
  ExpectInvalid([&] { Read("1,46.5,E,6.5,E\n", names, {"lat", "lon"}); }, "is not a hemisphere", 1);
  ExpectInvalid([&] { Read("1,46.5,,6.5,E\n", names, {"lat", "lon"}); }, "is not a hemisphere", 1);
  ExpectInvalid(
      [&] {
        Read("1,-46.5,S,6.5,E\n", names, {"lat", "lon"});
      },
      "sign and a hemisphere", 1);
}

TEST(NamedColumns, DatesAndTimesOfDay) {
  constexpr DateOrder kYear = DateOrder::kYearFirst, kDay = DateOrder::kDayFirst,
                      kMonth = DateOrder::kMonthFirst;
  const double day_s = 2280 * 604800.0 + 4 * 86400.0 + 18.0;
  for (const auto& [text, order] : {std::pair{"2023-09-21", kYear},
                                    {"2023/9/21", kYear},
                                    {"20230921", kYear},
                                    {"230921", kYear},
                                    {"21.09.2023", kYear},
                                    {"21.9.2023", kMonth},
                                    {"21/09/2023", kDay},
                                    {"21-9-23", kDay},
                                    {"210923", kDay},
                                    {"21092023", kDay},
                                    {"09/21/2023", kMonth},
                                    {"9/21/23", kMonth}}) {
    EXPECT_EQ(DateSeconds(text, order), day_s) << text;
  }
  for (const auto& [text, order] : {std::pair{"21/09/2023", kYear},
                                    {"09/21/2023", kDay},
                                    {"2023-13-01", kYear},
                                    {"2023-02-30", kYear},
                                    {"23-09-21", kYear},
                                    {"2023-09", kYear},
                                    {"2023:09:21", kYear},
                                    {"2023-09/21", kYear},
                                    {"20230921.5", kYear},
                                    {"", kYear},
                                    {"1/2/3/4", kDay},
                                    {"99999999", kYear},
                                    {"//", kDay}}) {
    EXPECT_FALSE(DateSeconds(text, order)) << text;
  }
  EXPECT_EQ(SecondsIntoDay("09:49:42.5"), 35382.5);
  EXPECT_EQ(SecondsIntoDay("094942.5"), 35382.5);
  EXPECT_EQ(SecondsIntoDay("094942"), 35382.0);
  // Spreadsheets leave out zeros at the beginning.
  EXPECT_EQ(SecondsIntoDay("9:49:42"), 35382.0);
  EXPECT_EQ(SecondsIntoDay("94942.5"), 35382.5);
  EXPECT_EQ(SecondsIntoDay("5.25"), 5.25);
  EXPECT_EQ(DateSeconds("50923", kDay), DateSeconds("050923", kDay));
  EXPECT_EQ(DateSeconds("5092023", kDay), DateSeconds("05092023", kDay));
  for (const char* text :
       {"24:00:00", "09:60:00", "09:49:61", "09:49", "09:4942", "9:4942:00", "09:49:42Z", "0949425",
        "09:49:4.5", "", "x", "95942x", "250000", ".5", "-5", "-1:00:00"}) {
    EXPECT_FALSE(SecondsIntoDay(text)) << text;
  }
}

TEST(NamedColumns, ADateMayStandApartFromTheTimeOfDay) {
  const double t_s = 2280 * 604800.0 + 381000.0;
  const TextTable iso =
      Read("date,time,h\n2023-09-21,09:49:42.0,500\n", {"date_utc", "time_of_day", "h"}, {"h"});
  EXPECT_EQ(iso.row(0)[0], t_s);
  const TextTable nmea = Read("094942.00 210923 500\n235959.50 210923 500\n000000.50 220923 500\n",
                              {"time_of_day", "date_utc_dmy", "h"}, {"h"});
  EXPECT_EQ(nmea.row(0)[0], t_s);
  EXPECT_EQ(nmea.row(2)[0] - nmea.row(1)[0], 1.0);
  const TextTable gps =
      Read("09/21/2023,09:50:00,500\n", {"date_gps_mdy", "time_of_day", "h"}, {"h"});
  EXPECT_EQ(gps.row(0)[0], t_s);
  const auto read = [](const char* text) {
    return [text] { Read(text, {"date_utc_mdy", "time_of_day", "h"}, {"h"}); };
  };
  const char* good = "09/21/2023,09:49:42,500\n";
  ExpectInvalid(read((std::string(good) + "21/09/2023,09:49:43,500\n").c_str()),
                "'21/09/2023' is not a date with the month first", 2);
  ExpectInvalid(read((std::string(good) + "09/21/2023,9h49,500\n").c_str()),
                "'9h49' is not a time of day", 2);
}

TEST(NamedColumns, CalendarTimesAreGpsSeconds) {
  const double week_s = 2280 * 604800.0;
  for (const char* text :
       {"2023-09-21T09:49:42.5Z", "2023-09-21 09:49:42.5", "2023/09/21T09:49:42.5",
        "2023-09-21T11:49:42.5+02:00", "2023-09-21T04:19:42.5-0530", "21.09.2023 09:49:42.5"}) {
    EXPECT_EQ(CalendarSeconds(text), week_s + 381000.5) << text;
  }
  // Leap seconds are those of the date.
  EXPECT_EQ(CalendarSeconds("2016-12-31T00:00:00Z"), 1929 * 604800.0 + 6 * 86400 + 17);
  for (const char* text : {"2023-09-21", "2023-13-21T09:49:42", "21/09/2023 09:49:42", "1.5",
                           "2023-09-21T09:49:42x", "2023-09-21T09:49"}) {
    EXPECT_FALSE(CalendarSeconds(text)) << text;
  }
  const TextTable t = Read("time,h\n2023-09-21T09:49:42Z,500\n", {"t_utc", "h"}, {"h"});
  EXPECT_EQ(t.row(0)[0], week_s + 381000.0);
  ExpectInvalid(
      [] {
        Read("2023-09-21T09:49:42Z,5\nlater,5\n", {"t_utc", "h"}, {"h"});
      },
      "is not a calendar time", 2);
}

}  // namespace dn::geo_test
