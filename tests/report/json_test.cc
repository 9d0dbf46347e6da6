#include <dn/report/json.h>
#include <gtest/gtest.h>

#include <limits>

namespace dn::report_test {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Json, VectorBecomesArrayAndNonFiniteBecomesNull) {
  const Json json = ToJson(Eigen::Vector4d(1.5, kNan, -kInfinity, 0.0));
  EXPECT_EQ(json.dump(), "[1.5,null,null,0.0]");
  EXPECT_EQ(ToJson(Eigen::VectorXd()).dump(), "[]");
}

TEST(Json, MatrixBecomesRows) {
  Eigen::Matrix<double, 2, 3> m;
  m << 1.0, 2.0, 3.0, 4.0, kNan, 6.0;
  EXPECT_EQ(ToJsonMatrix(m).dump(), "[[1.0,2.0,3.0],[4.0,null,6.0]]");
  EXPECT_EQ(ToJsonMatrix(Eigen::MatrixXd(0, 3)).dump(), "[]");
}

TEST(Json, KeysKeepTheirOrder) {
  Json json;
  json["zeta"] = 1;
  json["alpha"] = {{"m", 2}, {"b", 3}};
  EXPECT_EQ(FormatJson(json),
            "{\n  \"zeta\": 1,\n  \"alpha\": {\n    \"m\": 2,\n    \"b\": 3\n  }\n}\n");
}

TEST(Json, NumbersReadBackToTheSameValue) {
  for (const double value :
       {0.1, 1.0 / 3.0, 6378137.123456789, 4.9e-324, -1.7976931348623157e308, 381000.00500000001}) {
    const Json back = Json::parse(FormatJson(ToJson(Eigen::Matrix<double, 1, 1>(value))));
    EXPECT_EQ(back[0].get<double>(), value);
  }
}

}  // namespace dn::report_test
