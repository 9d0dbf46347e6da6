#include <dn/report/json.h>

#include <cmath>

namespace dn {

Json ToJson(const Eigen::Ref<const Eigen::VectorXd>& vector) {
  Json array = Json::array();
  for (Eigen::Index i = 0; i < vector.size(); ++i) {
    array.push_back(std::isfinite(vector[i]) ? Json(vector[i]) : Json(nullptr));
  }
  return array;
}

Json ToJsonMatrix(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    rows.push_back(ToJson(Eigen::VectorXd(matrix.row(r).transpose())));
  }
  return rows;
}

std::string FormatJson(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace dn
