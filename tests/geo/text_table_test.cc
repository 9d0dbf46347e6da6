#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::geo_test {

using testing::ExpectInvalid;
using testing::TempFile;

TextTable ReadTable(const std::string& text, const std::vector<std::size_t>& columns = {}) {
  const TempFile file("table.txt", text);
  return ReadTextTable(file.path(), columns);
}

TEST(TextTable, TakesEverySeparatorCommentAndLineEnd) {
  const TextTable t = ReadTable(
      "\xEF\xBB\xBF# header, with 1 2 3\r\n"
      "1,2,3\r\n"
      "\n"
      "   \t \n"
      "4 5\t6   # remark\n"
      " +7 , -8.5e-1,\t.9 \n"
      "#10, 11\n"
      "1e3 , 2  3");
  ASSERT_EQ(t.columns, 3u);
  EXPECT_EQ(t.values, (std::vector<double>{1, 2, 3, 4, 5, 6, 7, -0.85, 0.9, 1000, 2, 3}));
  EXPECT_EQ(t.lines, (std::vector<long>{2, 5, 6, 8}));
  EXPECT_EQ(t.row(1)[2], 6.0);
}

TEST(TextTable, TakesASecondCommentCharacter) {
  const TempFile file("table.txt", "% a\n1 2 % b\n# c\n");
  EXPECT_EQ(ReadTextTable(file.path(), {2}, '%').values, (std::vector<double>{1, 2}));
}

TEST(TextTable, NamesLineAndColumnOfABadValue) {
  const TempFile file("table.txt", "1, 2\n3, 4x\n");
  try {
    ReadTextTable(file.path(), {});
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.where().ToString(), file.path().string() + ":2:4");
    EXPECT_THAT(e.what(), ::testing::HasSubstr("'4x' is not a number"));
  }
}

TEST(TextTable, RejectsWhatIsNoFiniteNumber) {
  ExpectInvalid([] { ReadTable("1 2\n1 nan\n"); }, "'nan' is not a finite number", 2);
  ExpectInvalid([] { ReadTable("-inf\n"); }, "'-inf' is not a finite number", 1);
  ExpectInvalid([] { ReadTable("1e999\n"); }, "'1e999' is out of the range", 1);
  ExpectInvalid([] { ReadTable("t, lat\n1, 2\n"); }, "'t' is not a number", 1);
  ExpectInvalid([] { ReadTable("+-1\n"); }, "'+-1' is not a number", 1);
  ExpectInvalid([] { ReadTable("0x10\n"); }, "is not a number", 1);
  ExpectInvalid([] { ReadTable(std::string("1\0002", 3)); }, "'1?2' is not a number", 1);
  ExpectInvalid([] { ReadTable(std::string(1000, 'x')); }, std::string(40, 'x') + "...' is not", 1);
}

// Windows programs print NaN with a '#', which otherwise starts a comment.
TEST(TextTable, AHashInsideAValueIsNoComment) {
  for (const char* nan :
       {"-1.#IND", "1.#IND", "1.#QNAN", "-1.#QNAN00", "1.#INF", "-1.#INF000", "1.#SNAN", "nan",
        "NaN", "-nan(ind)", "nan(snan)", "NAN", "#N/A", "N/A", "null", "Inf", "-Infinity"}) {
    SCOPED_TRACE(nan);
    const std::string value = nan;
    const bool comment = value[0] == '#';
    const std::string what = comment ? "1 columns" : "'" + value + "' is not a finite number";
    ExpectInvalid([&] { ReadTable("1 2\n1 " + value + "\n"); }, what, 2);
    ExpectInvalid([&] { ReadTable("1,2,3\n1," + value + ",3\n"); },
                  comment ? "a value is missing" : what, 2);
    if (!comment) ExpectInvalid([&] { ReadTable(value + " 2\n"); }, what, 1);
  }
  ExpectInvalid([] { ReadTable("1 2#two\n"); }, "'2#two' is not a number", 1);
  EXPECT_EQ(ReadTable("1,2 #two\n3 4\t#four\n").rows(), 2u);
}

TEST(TextTable, NamesTextInUtf16) {
  const auto wide = [](const std::string& text, bool little, bool mark) {
    std::string bytes = mark ? (little ? "\xFF\xFE" : "\xFE\xFF") : "";
    for (const char c : text) {
      if (!little) bytes += '\0';
      bytes += c;
      if (little) bytes += '\0';
    }
    return bytes;
  };
  for (const bool little : {true, false}) {
    for (const bool mark : {true, false}) {
      ExpectInvalid([&] { ReadTable(wide("1, 2, 3\n4, 5, 6\n", little, mark)); },
                    "UTF-16; save it as UTF-8", 0);
    }
  }
}

TEST(TextTable, NamesSemicolonsAndDecimalCommas) {
  ExpectInvalid([] { ReadTable("1;2\n"); }, "not by semicolons", 1);
  ExpectInvalid([] { ReadTable("381000,5;46,57;6,52\n"); }, "decimal commas by points", 1);
  ExpectInvalid([] { ReadTable("381000,5 46,57\t6,52\n"); }, "decimal commas; write decimal points",
                1);
  ExpectInvalid([] { ReadTable("381000 46 6 500\n381001 46,57 6 500\n"); }, "decimal commas", 2);
  EXPECT_EQ(ReadTable("381000.5,46 6\n").columns, 3u);
  EXPECT_EQ(ReadTable("381000,46, 6\n").columns, 3u);
}

TEST(TextTable, RejectsMissingValues) {
  ExpectInvalid([] { ReadTable("1,2\n3,,4\n"); }, "a value is missing", 2);
  ExpectInvalid([] { ReadTable("1,2,\n"); }, "a value is missing", 1);
  ExpectInvalid([] { ReadTable(",1\n"); }, "a value is missing", 1);
}

TEST(TextTable, RejectsWrongNumbersOfColumns) {
  ExpectInvalid(
      [] {
        ReadTable("# x\n1 2 3 4 5\n", {4, 7, 10, 13});
      },
      "5 columns, must have 4, 7, 10 or 13", 2);
  ExpectInvalid([] { ReadTable("1 2\n1 2\n1 2 3\n"); }, "3 columns, but the rows before it have 2",
                3);
}

TEST(TextTable, RejectsWhatIsNoFileOfNumbers) {
  ExpectInvalid([] { ReadTable(""); }, "no rows of numbers", 0);
  ExpectInvalid([] { ReadTable("# only\n\n"); }, "no rows of numbers", 0);
  ExpectInvalid([] { ReadTextTable("/no/such/file.txt", {}); }, "does not exist", 0);
  ExpectInvalid([] { ReadTextTable(::testing::TempDir(), {}); }, "is a folder, not a regular", 0);
  ExpectInvalid([] { ReadTextTable("/dev/zero", {}); }, "is a device, not a regular file", 0);
}

TEST(TextTable, RejectsANamedPipeAtOnce) {
  const TempFile place("pipe.txt", "");
  std::filesystem::remove(place.path());
  ASSERT_EQ(mkfifo(place.path().c_str(), 0600), 0);
  ExpectInvalid([&] { ReadTextTable(place.path(), {}); }, "is a named pipe, not a regular file", 0);
}

TEST(TextTable, RejectsLinesAndFilesOfAbsurdLength) {
  const std::string digits(3000000, '1');
  ExpectInvalid([&] { ReadTable("1 2\n" + digits); }, "line is longer than 65536 bytes", 2);
  ExpectInvalid([&] { ReadTable(std::string(3000000, '\0')); }, "this is not a text file", 1);
  const TempFile file("table.txt", "1 2\n");
  std::filesystem::resize_file(file.path(), std::uintmax_t{1} << 40);
  ExpectInvalid([&] { ReadTextTable(file.path(), {}); }, "file has 1099511627776 bytes", 0);
}

TEST(TextTable, ReadsLinesAcrossChunks) {
  std::string text;
  for (int i = 0; i < 300000; ++i) text += std::to_string(i) + ", 0.5\n";
  const TextTable t = ReadTable(text + "300000, 0.5");
  ASSERT_EQ(t.rows(), 300001u);
  for (int i = 0; i <= 300000; ++i) ASSERT_EQ(t.row(static_cast<std::size_t>(i))[0], i);
  EXPECT_EQ(t.lines.back(), 300001);
}

TEST(ContinueAndCheckTimes, DropsIdenticalRepeats) {
  TextTable t = ReadTable("1 5\n1 5\n1 5\n2 5\n");
  std::vector<std::size_t> keep;
  EXPECT_EQ(ContinueAndCheckTimes(t, keep), 2);
  EXPECT_EQ(keep, (std::vector<std::size_t>{0, 3}));
}

TEST(ContinueAndCheckTimes, ContinuesOverWeeks) {
  TextTable t = ReadTable("604799.5 1\n604799.5 1\n0.25 2\n0.25 2\n604799.75 3\n1 4\n");
  std::vector<std::size_t> keep;
  EXPECT_EQ(ContinueAndCheckTimes(t, keep), 2);
  ASSERT_EQ(keep, (std::vector<std::size_t>{0, 2, 4, 5}));
  EXPECT_EQ(t.row(2)[0], 604800.25);
  EXPECT_EQ(t.row(4)[0], 1209599.75);
  EXPECT_EQ(t.row(5)[0], 1209601.0);
}

TEST(ContinueAndCheckTimes, RejectsOtherStepsBackAndRepeats) {
  std::vector<std::size_t> keep;
  TextTable repeated = ReadTable("1 5\n1 6\n");
  ExpectInvalid([&] { ContinueAndCheckTimes(repeated, keep); }, "time 1 s does not increase", 2);
  TextTable back = ReadTable("10 5\n11 5\n10.5 5\n");
  ExpectInvalid([&] { ContinueAndCheckTimes(back, keep); }, "time 10.5 s does not increase", 3);
  TextTable half_week = ReadTable("300000 1\n100 2\n");
  ExpectInvalid([&] { ContinueAndCheckTimes(half_week, keep); }, "does not increase", 2);
  TextTable nearly_a_week = ReadTable("604799 1\n3700 2\n");  // a pause of more than an hour
  ExpectInvalid([&] { ContinueAndCheckTimes(nearly_a_week, keep); }, "does not increase", 2);
  TextTable most_of_a_week = ReadTable("381000 1\n381001 2\n100 3\n");
  ExpectInvalid([&] { ContinueAndCheckTimes(most_of_a_week, keep); }, "does not increase", 3);
  TextTable whole_week = ReadTable("604800 1\n0 2\n");
  ExpectInvalid([&] { ContinueAndCheckTimes(whole_week, keep); }, "does not increase", 2);
}

TEST(ContinueAndCheckTimes, RejectsWhatIsNoSecondOfWeek) {
  const auto expect = [](const std::string& time, const std::string& what) {
    std::vector<std::size_t> keep;
    TextTable t = ReadTable("# t\n" + time + " 1\n");
    ExpectInvalid([&] { ContinueAndCheckTimes(t, keep); }, what, 2);
  };
  expect("381000250", "milliseconds? Divide it by 1000");
  expect("381000250000", "microseconds? Divide it by 1e6");
  expect("381000250000000", "nanoseconds? Divide it by 1e9");
  expect("1400000000.5", "GPS time since 1980? Subtract 604800 times the GPS week");
  expect("1763700000", "Unix time? Subtract 315964800");
  expect("1763700000123", "milliseconds since 1980 or 1970");
  expect("1763700000123456", "microseconds since 1980 or 1970");
  expect("1763700000123456789", "nanoseconds since 1980 or 1970");
  expect("1e300", "is this column the time?");
  expect("-4000", "is this column the time?");
}

TEST(TimeUnitHint, NamesTheUnitThatFits) {
  EXPECT_EQ(TimeUnitHint(105.0, 100.0, 140.0), "");
  EXPECT_EQ(TimeUnitHint(150.0, 100.0, 140.0), "");
  EXPECT_EQ(TimeUnitHint(105000.0, 100.0, 140.0),
            "; is the time in milliseconds? Divide it by 1000");
  EXPECT_EQ(TimeUnitHint(1.05e11, 100.0, 140.0), "; is the time in nanoseconds? Divide it by 1e9");
}

TEST(FormatDouble, ReadsBackToTheSameBits) {
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> exponent(-300, 300), mantissa(-10, 10);
  for (int i = 0; i < 1000; ++i) {
    const double value = mantissa(rng) * std::pow(10.0, exponent(rng));
    EXPECT_EQ(ParseNumber(FormatDouble(value), {}), value);
  }
  EXPECT_EQ(FormatDouble(0.1), "0.1");
  EXPECT_EQ(FormatDouble(-3.0), "-3");
  EXPECT_EQ(ParseNumber(FormatDouble(std::numeric_limits<double>::denorm_min()), {}),
            std::numeric_limits<double>::denorm_min());
}

TEST(TextTableReader, GivesTheRowsInParts) {
  const TempFile file("table.txt", "# a\n1, 2\n3, 4\n\n5, 6\n");
  TextTableReader reader(file.path(), {2});
  ASSERT_TRUE(reader.Next(2));
  EXPECT_EQ(reader.table().values, (std::vector<double>{1, 2, 3, 4}));
  ASSERT_TRUE(reader.Next(2));
  EXPECT_EQ(reader.table().values, (std::vector<double>{5, 6}));
  EXPECT_EQ(reader.table().lines, std::vector<long>{5});
  EXPECT_FALSE(reader.Next(2));
}

TEST(TextTableReader, ExpectsTheColumnsOfThePartBefore) {
  const TempFile file("table.txt", "1, 2\n3, 4, 5\n");
  TextTableReader reader(file.path(), {2, 3});
  ASSERT_TRUE(reader.Next(1));
  ExpectInvalid([&] { reader.Next(1); }, "row has 3 columns, but the rows before it have 2", 2);
}

}  // namespace dn::geo_test
