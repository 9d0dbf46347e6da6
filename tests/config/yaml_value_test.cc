#include <dn/config/yaml_value.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace dn::config_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const char* const kText =
    "a: 1.5\n"
    "b: {c: [1, 2, 3], d: ~}\n"
    "list:\n"
    "  - {x: +2}\n"
    "  - word\n"
    "yes: true\n";

YamlValue Root() { return ParseYaml(kText, "file.yaml"); }

/// Returns "line:column message" of the exception that `act` throws; empty if it throws nothing.
std::string Fault(const std::function<void()>& act) {
  try {
    act();
  } catch (const InvalidConfig& e) {
    EXPECT_EQ(e.where().file, "file.yaml");
    return std::to_string(e.where().line) + ":" + std::to_string(e.where().column) + " " + e.what();
  }
  return "";
}

TEST(YamlValue, ReadsValues) {
  const YamlValue root = Root();
  EXPECT_EQ(root["a"].Number(), 1.5);
  EXPECT_EQ(ReadVector3(root["b"]["c"]), Eigen::Vector3d(1, 2, 3));
  EXPECT_THAT(ReadNumberList(root["b"]["c"]), ElementsAre(1, 2, 3));
  EXPECT_THAT(ReadNumberList(root["a"]), ElementsAre(1.5));
  EXPECT_EQ(root["list"].List()[0]["x"].Integer(0), 2);
  EXPECT_EQ(root["list"].List()[1].Text(), "word");
  EXPECT_EQ(root["list"].List()[1].path(), "list[1]");
  EXPECT_TRUE(ReadBoolOr(root["yes"], false));
}

TEST(YamlValue, AbsentValuesHaveTheLocationOfTheirParent) {
  const YamlValue root = Root();
  EXPECT_TRUE(root["z"].absent());
  EXPECT_TRUE(root["b"]["d"].absent());
  EXPECT_TRUE(root["z"]["y"]["x"].absent());
  EXPECT_EQ(ReadNumberOr(root["z"]["y"], 7.0), 7.0);
  EXPECT_EQ(ReadVector3Or(root["z"], {1, 2, 3}), Eigen::Vector3d(1, 2, 3));
  ExpectMapOrAbsent(root["z"], {"y"});
  EXPECT_EQ(Fault([&] { root["b"]["e"].Number(); }), "2:4 b.e: expected a number, found nothing");
  EXPECT_EQ(Fault([&] { root["b"]["e"]["f"].Text(); }),
            "2:4 b.e.f: expected a word, found nothing");
}

TEST(YamlValue, ErrorsNameKeyPathLineAndColumn) {
  const YamlValue root = Root();
  EXPECT_EQ(Fault([&] { root["b"]["c"].Number(); }),
            "2:8 b.c: expected a number, found a list of 3");
  EXPECT_EQ(Fault([&] { root["list"].List()[1].Number(); }),
            "5:5 list[1]: expected a number, found 'word'");
  EXPECT_EQ(Fault([&] {
              root["b"].ExpectMap({"c", "dd"});
            }),
            "2:19 b: unknown key 'd'; did you mean 'c'?");
  EXPECT_EQ(Fault([&] { ExpectMapOrAbsent(root["a"], {"c"}); }),
            "1:4 a: expected a map of keys, found '1.5'");
  EXPECT_EQ(Fault([&] { ReadNumbers(root["b"]["c"], 2); }),
            "2:8 b.c: expected a list of 2 numbers, found a list of 3");
  EXPECT_THAT(Fault([] { ParseYaml("a: [1\nb: 2\n", "file.yaml"); }), HasSubstr("not valid YAML"));
  EXPECT_EQ(Fault([] { ParseYaml("", "file.yaml"); }), "1:0 the configuration is empty");
}

TEST(YamlValue, LooksUpWithoutChangingTheFile) {
  const YamlValue root = Root();
  const YamlValue b = root["b"];
  EXPECT_TRUE(b["new"].absent());
  b.ExpectMap({"c", "d"});
  EXPECT_TRUE(b["new"].absent());
}

TEST(YamlValue, AListLongerThanItsBoundHasItsPlace) {
  const YamlValue root = ParseYaml("a: [1, 2]\nb: 3\nc: {x: 1, y: 2}\n", "file.yaml");
  EXPECT_EQ(root["a"].List(2).size(), 2u);
  EXPECT_EQ(Fault([&] { root["a"].List(1); }), "1:4 a: has 2 elements, at most 1 are read");
  EXPECT_EQ(Fault([&] { root["a"].Items(1); }), "1:4 a: has 2 elements, at most 1 are read");
  EXPECT_EQ(root["b"].Items(1).size(), 1u);
  EXPECT_EQ(root["a"].size(), 2u);
  EXPECT_EQ(root["b"].size(), 0u);
  EXPECT_EQ(root["c"].size(), 2u);
  EXPECT_EQ(root["d"].size(), 0u);
}

TEST(YamlValue, NestingWithoutEndIsNamed) {
  for (const std::string& text : {std::string(100000, '['), "a: " + std::string(100000, '{')}) {
    EXPECT_THAT(Fault([&] { ParseYaml(text, "file.yaml"); }), HasSubstr("more than 500 deep"));
  }
}

std::string ChangeFault(const std::string& change) {
  try {
    WithYamlChanges(kText, {change}, "a=1");
  } catch (const InvalidConfig& e) {
    return e.what();
  }
  return "";
}

TEST(YamlChanges, AreMadeOneAfterTheOther) {
  const YamlValue changed = ParseYaml(
      WithYamlChanges(kText, {"a=2", "new.key=[1]", "new.key=[3, 4]", "b.c=~"}, "a=1"), "x");
  EXPECT_EQ(changed["a"].Number(), 2.0);
  EXPECT_THAT(ReadNumberList(changed["new"]["key"]), ElementsAre(3, 4));
  EXPECT_TRUE(changed["b"]["c"].absent());
  EXPECT_EQ(WithYamlChanges(kText, {}, "a=1"), kText);
}

TEST(YamlChanges, AKeyWithoutEndIsNoKey) {
  std::string deep = "a";
  for (int i = 0; i < 20000; ++i) deep += ".a";
  for (const std::string& key : {deep, std::string(5000, 'x')}) {
    const std::string fault = ChangeFault(key + "=1");
    EXPECT_THAT(fault, HasSubstr("at most 200"));
    EXPECT_LT(fault.size(), 200u);
  }
  EXPECT_EQ(ChangeFault(std::string(200, 'x') + "=1"), "");
}

}  // namespace dn::config_test
