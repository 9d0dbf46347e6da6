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
  for (const auto& [name, text] :
       {std::pair{"t", "1.5"}, {"t_ms", "1500"}, {"t_us", "1500000"}, {"t_ns", "1500000000"}}) {
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
  ExpectInvalid(check({"t", "latitude"}), "'latitude' is not a column; the columns are t", 0);
  ExpectInvalid(check({"t", "lat", "-lat"}), "'-lat' is named twice", 0);
  ExpectInvalid(check({"t", "vu", "vd"}), "'vd' is named twice", 0);
  ExpectInvalid(check({"lat", "lon"}), "no column is the time", 0);
  EXPECT_EQ(FormatColumnNames({"t", "-fx", "skip"}), "[t, -fx, skip]");
}

}  // namespace dn::geo_test
