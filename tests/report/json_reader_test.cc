#include <dn/error.h>
#include <dn/report/json_reader.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace dn::report_test {

using ::testing::HasSubstr;
using ::testing::Not;

std::string Repeated(const std::string& text, std::size_t times) {
  std::string all;
  for (std::size_t k = 0; k < times; ++k) all += text;
  return all;
}

/// Returns the message and the location of the rejection.
std::string Refusal(const std::function<void()>& read) {
  try {
    read();
  } catch (const InvalidInput& error) {
    return std::string(error.what()) + " (" + error.where().ToString() + ")";
  }
  return "read";
}

std::string ReadRefusal(const std::string& text, const JsonLimits& limits = {}) {
  return Refusal([&] { ParseJson(text, "x.json", limits); });
}

TEST(JsonReader, ReadsWhatIsWritten) {
  const Json json = {
      {"b", {1, -2, 0.1, nullptr, true, "a\nü"}}, {"a", Json::object()}, {"c", {{}}}};
  const Json back = ParseJson(FormatJson(json), "x.json");
  EXPECT_EQ(back.dump(), json.dump());
  EXPECT_EQ(CountValues(back), 11U);
  EXPECT_EQ(ParseJson("3", "x.json"), 3);
}

TEST(JsonReader, NamesLineAndColumnOfWhatIsNoJson) {
  EXPECT_EQ(ReadRefusal(""), "this is not JSON (x.json:1:1)");
  EXPECT_EQ(ReadRefusal("{\"a\": 1,\n \"b\": x}"), "this is not JSON (x.json:2:7)");
  EXPECT_EQ(ReadRefusal("[1, 1e999]"), "a number is too large for JSON (x.json:1:9)");
  for (const std::string text :
       {"[1, 2", "[1] 2", "nan", "{'a': 1}", "[1,]", "\"\xff\"", "[\x01]"}) {
    EXPECT_THAT(ReadRefusal(text), HasSubstr("this is not JSON (x.json:1:")) << text;
  }
}

TEST(JsonReader, AZeroByteIsNotTheEndOfAText) {
  const std::string zero(1, '\0');
  for (const std::string& text : {"{}" + zero, "{}" + zero + "}", zero + "{}", "[" + zero + "]"}) {
    EXPECT_THAT(ReadRefusal(text), HasSubstr("this is not JSON (x.json:1:"));
  }
}

TEST(JsonReader, NestingIsBounded) {
  const JsonLimits limits;
  const auto nested = [](std::size_t depth) { return Repeated("[", depth) + Repeated("]", depth); };
  EXPECT_EQ(ReadRefusal(nested(limits.depth)), "read");
  EXPECT_THAT(ReadRefusal(nested(limits.depth + 1)), HasSubstr("nested deeper than 64 levels"));
  for (const char* open : {"[", "{\"a\":", "[{\"a\":", "[[],"}) {
    EXPECT_THAT(ReadRefusal(Repeated(open, 1'000'000)), HasSubstr("nested deeper")) << open;
  }
}

TEST(JsonReader, BytesValuesAndKeysAreBounded) {
  JsonLimits limits;
  limits.values = 5;
  EXPECT_EQ(ReadRefusal("[1, 2, 3, 4]", limits), "read");
  EXPECT_EQ(ReadRefusal("{\"a/b\": [1, 2, 3, 4]}", limits), "/a~1b: more than 5 values (x.json)");
  EXPECT_EQ(ReadRefusal("[{\"a/b\": [1, 2, 3]}]", limits), "/0/a~1b: more than 5 values (x.json)");
  limits.keys = 1;
  EXPECT_EQ(ReadRefusal("[0, {\"a\": 1, \"b\": 2}]", limits), "/1: more than 1 keys (x.json)");
  limits.bytes = 3;
  EXPECT_EQ(ReadRefusal("[1, 2]", limits), "JSON of 6 bytes; at most 3 are read (x.json)");
}

TEST(JsonReader, AKeyIsThereOnce) {
  EXPECT_EQ(ReadRefusal("{\"a\": 1, \"b\": 1, \"a\": 2}"), "the key 'a' is given twice (x.json)");
  EXPECT_EQ(ReadRefusal("{\"a\": {\"b\": 1}, \"b\": 1}"), "read");
}

TEST(JsonReader, AnObjectOfManyKeysTakesNoSquareOfThem) {
  std::string text = "{";
  JsonLimits limits;
  limits.keys = 300'000;
  for (std::size_t k = 0; k < limits.keys; ++k) text += "\"" + std::to_string(k) + "\":0,";
  EXPECT_EQ(ReadRefusal(text + "\"\":0}", limits), "more than 300000 keys (x.json)");
}

TEST(JsonPlace, ReadsKindsWithinTheirRanges) {
  const Json json = ParseJson(
      R"({"n": 2.5, "i": -3, "u": 18446744073709551615, "t": "x", "b": true, "v": [1, 2, null],
          "m": [[1, 2, 3], [4, 5, 6], [7, 8, 9]], "l": ["p", "q"]})",
      "x.json");
  const JsonPlace place(json, "x.json");
  EXPECT_EQ(place.At("n").Number(0.0, 3.0), 2.5);
  EXPECT_EQ(place.At("i").Integer(-3, 3), -3);
  EXPECT_EQ(place.At("u").Unsigned(), 18446744073709551615U);
  EXPECT_EQ(place.At("t").Text(), "x");
  EXPECT_TRUE(place.At("b").Flag());
  EXPECT_TRUE(std::isnan(ReadVector3(place.At("v")).z()));
  EXPECT_EQ(ReadMatrix3(place.At("m"))(1, 2), 6.0);
  EXPECT_EQ(ReadTexts(place.At("l")), (std::vector<std::string>{"p", "q"}));
  EXPECT_EQ(place.At("l").At(1).Text(), "q");
  EXPECT_TRUE(place.Has("l"));
  EXPECT_FALSE(place.Has("absent"));
}

TEST(JsonPlace, NamesFileAndPlaceOfWhatItDoesNotExpect) {
  const Json json = ParseJson(
      R"({"a/b": {"x": [1, "t", null]}, "big": 1e308, "half": 0.5, "u": 18446744073709551615})",
      "f");
  const JsonPlace root(json, "f");
  const JsonPlace list = root.At("a/b").At("x");
  EXPECT_EQ(Refusal([&] { list.At(1).Number(); }), "/a~1b/x/1 is not a number (f)");
  EXPECT_EQ(Refusal([&] { list.At(2).Number(); }), "/a~1b/x/2 is not a number (f)");
  EXPECT_EQ(Refusal([&] { list.At(3); }), "/a~1b/x has 3 elements, too few (f)");
  EXPECT_EQ(Refusal([&] { root.At("c"); }), "/c is missing (f)");
  EXPECT_EQ(Refusal([&] { list.At("c"); }), "/a~1b/x is not an object (f)");
  EXPECT_EQ(Refusal([&] { root.Elements(); }), "the file is not a list (f)");
  EXPECT_EQ(Refusal([&] { list.Elements(2); }), "/a~1b/x has 3 elements, at most 2 (f)");
  EXPECT_EQ(Refusal([&] { root.At("big").Number(0.0, 1e9); }),
            "/big is 1e+308, not within 0 and 1e+09 (f)");
  for (const char* key : {"big", "half", "u", "a/b"}) {
    EXPECT_THAT(Refusal([&] { root.At(key).Integer(0, 9); }),
                HasSubstr("is not an integer within 0 and 9"))
        << key;
  }
  EXPECT_THAT(Refusal([&] { ReadFiniteVector3(list); }), Not(HasSubstr("read")));
  EXPECT_THAT(Refusal([&] { root.At("a/b").Text(); }), HasSubstr("is not a string"));
  EXPECT_THAT(Refusal([&] { list.At(1).Text(0); }), HasSubstr("longer than 0 bytes"));
  EXPECT_THAT(Refusal([&] { root.At("half").Flag(); }), HasSubstr("is neither true nor false"));
  EXPECT_THAT(Refusal([&] { root.At("half").Unsigned(); }), HasSubstr("is not an integer"));
  EXPECT_THAT(Refusal([&] { ReadVector3(root.At("half")); }), HasSubstr("is not a list of three"));
  EXPECT_THAT(Refusal([&] { ReadMatrix3(root.At("half")); }), HasSubstr("is not a list of three"));
}

}  // namespace dn::report_test
