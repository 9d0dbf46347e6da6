#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace dn {

/// Keys keep the order in which they are written.
using Json = nlohmann::ordered_json;

/// A vector as an array, a matrix as an array of rows. NaN becomes null, as JSON has no other word
/// for it.
Json ToJson(const Eigen::Ref<const Eigen::VectorXd>& vector);
Json ToJsonMatrix(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

/// Text of a result file: two blanks of indent, shortest digits that read back to the same value,
/// final newline. Bytes that are not UTF-8 become the replacement character.
std::string FormatJson(const Json& json);

}  // namespace dn
