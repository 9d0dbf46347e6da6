#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory_covariance.h>

#include <cmath>
#include <cstdio>

namespace dn {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kCovarianceColumns = 4 + 36;
constexpr double kStripNumbers = 1e6;

Matrix6d Units(double attitude) {
  Eigen::Matrix<double, 6, 1> units;
  units << 1.0, 1.0, 1.0, Eigen::Vector3d::Constant(attitude);
  return units.asDiagonal();
}

std::size_t FormatRow(std::size_t i, std::size_t j) { return i * (i + 1) / 2 + j; }

[[noreturn]] void Fail(const std::string& what, const TextTable& table, std::size_t row) {
  throw InvalidInput(what + "; write the file again with dn smooth, or remove it",
                     FileLocation{table.file.string(), table.lines[row], 0});
}

TrajectoryCovariance ReadEpochs(const TextTable& table) {
  const auto T = static_cast<std::size_t>(
      std::lround(0.5 * (std::sqrt(8.0 * static_cast<double>(table.rows()) + 1.0) - 1.0)));
  if (FormatRow(T, 0) != table.rows()) {
    Fail("rows are missing: each pair of epochs needs one row", table, table.rows() - 1);
  }
  TrajectoryCovariance out;
  for (std::size_t i = 0; i < T; ++i) {
    const std::size_t row = FormatRow(i, i);
    const double t_s = table.row(row)[0], strip = table.row(row)[1];
    if (!(strip >= 0.0 && strip < kStripNumbers && strip == std::floor(strip))) {
      Fail("the strip is not an integer of at least 0", table, row);
    }
    if (i > 0 && (t_s <= out.t_s.back() || strip < out.strip.back())) {
      Fail("times and strips must increase", table, row);
    }
    out.t_s.push_back(t_s);
    out.strip.push_back(static_cast<int>(strip));
  }
  return out;
}

void ReadBlock(const TextTable& table, std::size_t i, std::size_t j, TrajectoryCovariance* out) {
  const std::size_t row = FormatRow(i, j);
  const double* values = table.row(row);
  if (values[0] != out->t_s[i] || values[1] != out->strip[i] || values[2] != out->t_s[j] ||
      values[3] != out->strip[j]) {
    Fail("the epochs do not follow the required order of the rows", table, row);
  }
  const Matrix6d si = Units(kRadPerDeg);
  const Matrix6d C =
      si * Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values + 4) * si;
  if (i == j && !(C.diagonal().minCoeff() > 0.0)) Fail("a variance is not positive", table, row);
  const auto at_i = static_cast<Eigen::Index>(6 * i), at_j = static_cast<Eigen::Index>(6 * j);
  out->covariance.block<6, 6>(at_i, at_j) = C;
  out->covariance.block<6, 6>(at_j, at_i) = C.transpose();
}

}  // namespace

std::string FormatTrajectoryCovariance(const TrajectoryCovariance& covariance) {
  std::string text =
      "# covariance between two epochs of the trajectory: t_i, strip_i, t_j, strip_j, then row by "
      "row\n# that of pose i with pose j: position E, N, U [m], attitude about body x, y, z "
      "[deg]\n";
  const Matrix6d units = Units(kDegPerRad);
  for (std::size_t i = 0; i < covariance.t_s.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      text += FormatDouble(covariance.t_s[i]) + ' ' + std::to_string(covariance.strip[i]) + ' ' +
              FormatDouble(covariance.t_s[j]) + ' ' + std::to_string(covariance.strip[j]);
      const Matrix6d C = units *
                         covariance.covariance.block<6, 6>(6 * static_cast<Eigen::Index>(i),
                                                           6 * static_cast<Eigen::Index>(j)) *
                         units;
      for (int row = 0; row < 6; ++row) {
        for (int column = 0; column < 6; ++column) {
          char number[32];
          std::snprintf(number, sizeof(number), " %.9g", C(row, column));
          text += number;
        }
      }
      text += '\n';
    }
  }
  return text;
}

TrajectoryCovariance ReadTrajectoryCovariance(const std::filesystem::path& file) {
  const TextTable table = ReadTextTable(file, {kCovarianceColumns});
  TrajectoryCovariance out = ReadEpochs(table);
  const std::size_t T = out.t_s.size();
  const auto order = static_cast<Eigen::Index>(6 * T);
  out.covariance.resize(order, order);
  for (std::size_t i = 0; i < T; ++i) {
    for (std::size_t j = 0; j <= i; ++j) ReadBlock(table, i, j, &out);
  }
  return out;
}

}  // namespace dn
