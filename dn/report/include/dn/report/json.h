#pragma once

#include <dn/eigen_alignment.h>
#include <dn/report/json_fwd.h>

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace dn {

/// Returns a vector as an array, and a matrix as an array of rows. Non-finite values become null,
/// because JSON cannot represent them.
Json ToJson(const Eigen::Ref<const Eigen::VectorXd>& vector);
Json ToJsonMatrix(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

/// Returns the text of a result file: two spaces of indentation, the shortest digits that read back
/// to the same value, and a final newline. Bytes that are not UTF-8 become the replacement
/// character.
std::string FormatJson(const Json& json);

}  // namespace dn
