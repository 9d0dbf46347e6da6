#include <dn/fleet/reduced_ties.h>

#include <cmath>
#include <cstddef>

#include "reduced_numbers.h"

namespace dn {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fleet_internal::ReadNumber;

constexpr std::size_t kMostPoints = 10'000, kMostNumbers = 3 * kMostPoints;

/// Returns a number with nine digits. Covariances of many points need most of the file.
double Rounded(double value) {
  if (value == 0.0 || !std::isfinite(value)) return value;
  const double unit = std::pow(10.0, 8.0 - std::floor(std::log10(std::abs(value))));
  return std::round(value * unit) / unit;
}

/// Returns the first `columns(row)` numbers of each row.
template <class Columns>
Json RowsJson(const MatrixXd& matrix, const Columns& columns) {
  Json rows = Json::array();
  for (Index r = 0; r < matrix.rows(); ++r) {
    Json row = Json::array();
    for (Index c = 0; c < columns(r); ++c) row.push_back(Rounded(matrix(r, c)));
    rows.push_back(std::move(row));
  }
  return rows;
}

Json MomentsJson(const TieMoments& moments) {
  return {
      {"position_ecef_m", ToJson(moments.mean_e_m)},
      {"covariance_rows_up_to_diagonal",
       RowsJson(moments.covariance_m2, [](Index row) { return row + 1; })},
      {"cross_covariance", RowsJson(moments.cross, [&](Index) { return moments.cross.cols(); })}};
}

std::vector<JsonPlace> ExpectSize(const JsonPlace& list, Index size) {
  std::vector<JsonPlace> elements = list.Elements(kMostNumbers);
  if (static_cast<Index>(elements.size()) != size) {
    list.Fail("must have " + std::to_string(size) + " elements");
  }
  return elements;
}

MatrixXd ReadTriangle(const JsonPlace& list, Index size) {
  const std::vector<JsonPlace> rows = ExpectSize(list, size);
  MatrixXd C(size, size);
  for (Index r = 0; r < size; ++r) {
    const std::vector<JsonPlace> row = ExpectSize(rows[static_cast<std::size_t>(r)], r + 1);
    for (Index c = 0; c <= r; ++c) {
      C(r, c) = C(c, r) = ReadNumber(row[static_cast<std::size_t>(c)]);
    }
  }
  fleet_internal::ExpectCovariance(C, list);
  return C;
}

TieMoments ReadMoments(const JsonPlace& json, Index points, Index unknowns) {
  const Index size = 3 * points;
  TieMoments moments{VectorXd(size), MatrixXd(size, size), MatrixXd(size, unknowns)};
  const auto position = ExpectSize(json.At("position_ecef_m"), size);
  const auto cross = ExpectSize(json.At("cross_covariance"), size);
  for (Index r = 0; r < size; ++r) {
    const auto k = static_cast<std::size_t>(r);
    moments.mean_e_m[r] = ReadNumber(position[k]);
    const auto row = ExpectSize(cross[k], unknowns);
    for (Index c = 0; c < unknowns; ++c) {
      moments.cross(r, c) = ReadNumber(row[static_cast<std::size_t>(c)]);
    }
  }
  moments.covariance_m2 = ReadTriangle(json.At("covariance_rows_up_to_diagonal"), size);
  return moments;
}

std::optional<Matrix3d> ReadNoise(const JsonPlace& place) {
  if (place.is_null()) return std::nullopt;
  return ReadTriangle(place, 3);
}

}  // namespace

Json ReducedTiesJson(const ReducedTies& ties) {
  Json noise = Json::array();
  for (const auto& one : ties.noise_m2) {
    noise.push_back(one ? RowsJson(*one, [](Index row) { return row + 1; }) : Json(nullptr));
  }
  return {{"names", ties.names},
          {"noise_m2", noise},
          {"moments", MomentsJson(ties.moments)},
          {"as_modelled", MomentsJson(ties.as_modelled)}};
}

ReducedTies ReadReducedTies(const JsonPlace& json, Index unknowns) {
  ReducedTies ties;
  for (const JsonPlace& name : json.At("names").Elements(kMostPoints)) {
    ties.names.push_back(name.Text());
  }
  for (const JsonPlace& one : ExpectSize(json.At("noise_m2"), ties.size())) {
    ties.noise_m2.push_back(ReadNoise(one));
  }
  ties.moments = ReadMoments(json.At("moments"), ties.size(), unknowns);
  ties.as_modelled = ReadMoments(json.At("as_modelled"), ties.size(), 3);
  return ties;
}

}  // namespace dn
