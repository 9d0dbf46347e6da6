#include <dn/error.h>
#include <dn/report/json_reader.h>
#include <dn/report/network_file.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "testing/temp_folder.h"

namespace dn::report_test {

using ::testing::HasSubstr;

NetworkState MakeState() {
  NetworkState state;
  state.blocks.push_back({"bore sight \"1\"", Parametrisation::kRotationLeft,
                          Eigen::Vector4d(0.0, 0.1, 0.2, 1.0 / 3.0),
                          1e-9 * Eigen::Matrix3d::Ones()});
  state.blocks.push_back({"p", Parametrisation::kVector, Eigen::Vector3d(1e-300, -5e8, 0.1), {}});
  state.priors.push_back(
      {"eliminated",
       {"p"},
       Eigen::Vector3d(1.0, 2.0, 3.0),
       (Eigen::MatrixXd(2, 3) << 0.1, 1.0 / 3.0, -2e-9, 4.0, 5e9, 0.7).finished(),
       Eigen::Vector2d(0.1, 0.7),
       std::numeric_limits<double>::infinity()});
  return state;
}

void ExpectEqual(const NetworkState& a, const NetworkState& b) {
  ASSERT_EQ(a.blocks.size(), b.blocks.size());
  for (std::size_t k = 0; k < a.blocks.size(); ++k) {
    EXPECT_EQ(a.blocks[k].name, b.blocks[k].name);
    EXPECT_EQ(a.blocks[k].parametrisation, b.blocks[k].parametrisation);
    EXPECT_EQ(a.blocks[k].value, b.blocks[k].value);
    ASSERT_EQ(a.blocks[k].covariance.size(), b.blocks[k].covariance.size());
    EXPECT_EQ(a.blocks[k].covariance, b.blocks[k].covariance);
  }
  ASSERT_EQ(a.priors.size(), b.priors.size());
  for (std::size_t k = 0; k < a.priors.size(); ++k) {
    EXPECT_EQ(a.priors[k].group, b.priors[k].group);
    EXPECT_EQ(a.priors[k].blocks, b.priors[k].blocks);
    EXPECT_EQ(a.priors[k].center, b.priors[k].center);
    EXPECT_EQ(a.priors[k].R, b.priors[k].R);
    EXPECT_EQ(a.priors[k].d, b.priors[k].d);
    EXPECT_EQ(a.priors[k].nonlinearity, b.priors[k].nonlinearity);
  }
}

TEST(NetworkFile, ReadsBackExactly) {
  const testing::TempFolder folder;
  for (const StateFormat format : {StateFormat::kJson, StateFormat::kBinary}) {
    const auto path = folder.path() / "state";
    WriteState(path, MakeState(), format);
    ExpectEqual(ReadState(path), MakeState());
    ExpectEqual(ParseState(FormatState({}, format), "empty"), {});
  }
}

TEST(NetworkFile, IsJsonForOtherTools) {
  const Json json = ParseJson(FormatState(MakeState(), StateFormat::kJson), "state");
  EXPECT_EQ(json["schema"], "dn.network/1");
  EXPECT_EQ(json["blocks"][0]["parametrisation"], "rotation_left");
  EXPECT_EQ(json["blocks"][0]["value"].size(), 4U);
  EXPECT_EQ(json["blocks"][1]["covariance"], Json());
  EXPECT_EQ(json["priors"][0]["R"].size(), 2U);
}

// Every truncation, and every changed byte of the sizes, is an error or another valid state.
TEST(NetworkFile, NamesTheFileIfItIsDamaged) {
  for (const StateFormat format : {StateFormat::kJson, StateFormat::kBinary}) {
    const std::string whole = FormatState(MakeState(), format);
    for (std::size_t length = 0; length + 1 < whole.size(); ++length) {
      try {
        ParseState(whole.substr(0, length), "my.state");
        FAIL() << length;
      } catch (const InvalidInput& error) {
        EXPECT_EQ(error.where().file, "my.state");
      }
    }
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 0x7F);
      try {
        ParseState(damaged, "my.state");
      } catch (const InvalidInput& error) {
        EXPECT_EQ(error.where().file, "my.state");
      }
    }
  }
  EXPECT_THROW(ReadState("/no/such/state"), InvalidInput);
  EXPECT_THROW(WriteState("/no/such/state", {}, StateFormat::kJson), InvalidInput);
}

TEST(NetworkFile, NamesThePlaceOfAWrongValue) {
  std::string text = FormatState(MakeState(), StateFormat::kJson);
  text.replace(text.find("rotation_left"), 13, "rotation_lift");
  try {
    ParseState(text, "my.state");
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("/blocks/0/parametrisation"));
  }
}

}  // namespace dn::report_test
