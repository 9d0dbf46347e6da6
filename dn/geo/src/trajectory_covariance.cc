#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory_covariance.h>

#include <cmath>
#include <cstdio>

namespace dn {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kColumns = 4 + 36;
constexpr double kStripNumbers = 1e6;

Matrix6d Units() {
  Eigen::Matrix<double, 6, 1> units;
  units << 1.0, 1.0, 1.0, Eigen::Vector3d::Constant(kDegPerRad);
  return units.asDiagonal();
}

}  // namespace

std::string FormatTrajectoryCovariance(const TrajectoryCovariance& covariance) {
  std::string text =
      "# covariance between two epochs of the trajectory: t_i, strip_i, t_j, strip_j, then row by "
      "row\n# that of pose i with pose j: position E, N, U [m], attitude about body x, y, z "
      "[deg]\n";
  const Matrix6d units = Units();
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
  const TextTable table = ReadTextTable(file, {kColumns});
  const auto fail = [&](const std::string& what, std::size_t row) {
    throw InvalidInput(what + "; let dn smooth write the file again, or remove it",
                       FileLocation{file.string(), table.lines[row], 0});
  };
  const auto T = static_cast<std::size_t>(
      std::lround(0.5 * (std::sqrt(8.0 * static_cast<double>(table.rows()) + 1.0) - 1.0)));
  if (T * (T + 1) / 2 != table.rows()) {
    fail("rows are missing: not one for each two epochs", table.rows() - 1);
  }
  TrajectoryCovariance out;
  const auto order = static_cast<Eigen::Index>(6 * T);
  out.covariance.resize(order, order);
  const Matrix6d si = Units().inverse();
  std::size_t row = 0;
  for (std::size_t i = 0; i < T; ++i) {
    const std::size_t diagonal = i * (i + 1) / 2 + i;
    const double strip = table.row(diagonal)[1];
    if (!(strip >= 0.0 && strip < kStripNumbers && strip == std::floor(strip))) {
      fail("the strip is no whole number from 0", diagonal);
    }
    out.t_s.push_back(table.row(diagonal)[0]);
    out.strip.push_back(static_cast<int>(strip));
  }
  for (std::size_t i = 0; i < T; ++i) {
    for (std::size_t j = 0; j <= i; ++j, ++row) {
      const double* values = table.row(row);
      if (values[0] != out.t_s[i] || values[1] != out.strip[i] || values[2] != out.t_s[j] ||
          values[3] != out.strip[j]) {
        fail("the epochs are not those that the order of the rows asks for", row);
      }
      const Matrix6d C =
          si * Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values + 4) * si;
      const auto at_i = static_cast<Eigen::Index>(6 * i), at_j = static_cast<Eigen::Index>(6 * j);
      out.covariance.block<6, 6>(at_i, at_j) = C;
      out.covariance.block<6, 6>(at_j, at_i) = C.transpose();
    }
  }
  for (std::size_t i = 0; i < T; ++i) {
    const std::size_t diagonal = i * (i + 1) / 2 + i;
    if (i > 0 && (out.t_s[i] <= out.t_s[i - 1] || out.strip[i] < out.strip[i - 1])) {
      fail("times and strips must increase", diagonal);
    }
    const auto at = static_cast<Eigen::Index>(6 * i);
    if (!(out.covariance.diagonal().segment<6>(at).minCoeff() > 0.0)) {
      fail("a variance is not positive", diagonal);
    }
  }
  return out;
}

}  // namespace dn
