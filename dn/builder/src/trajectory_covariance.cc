#include <dn/builder/node_grid.h>
#include <dn/builder/trajectory_covariance.h>
#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace dn {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kMostEpochs = 64;
constexpr std::size_t kMostStrips = kMostEpochs / 2;
constexpr std::size_t kColumns = 4 + 36;
constexpr double kStripNumbers = 1e6;

struct StripNode {
  std::size_t node;
  int strip;
};

std::vector<StripNode> Spread(const std::vector<double>& node_t_s,
                              const std::vector<StripInterval>& strips, double spacing_s) {
  std::vector<StripNode> chosen;
  for (std::size_t s = 0; s < strips.size(); ++s) {
    const double length_s = strips[s].t1_s - strips[s].t0_s;
    const int steps = std::max(1, static_cast<int>(std::lround(length_s / spacing_s)));
    for (int k = 0; k <= steps; ++k) {
      const std::size_t node = NodeNear(node_t_s, strips[s].t0_s + k * length_s / steps);
      if (chosen.empty() || node > chosen.back().node)
        chosen.push_back({node, static_cast<int>(s)});
    }
  }
  return chosen;
}

std::vector<StripNode> Choose(const std::vector<double>& node_t_s,
                              const std::vector<StripInterval>& strips) {
  constexpr double kGrowth = 1.1;
  double spacing_s = 1.0;
  std::vector<StripNode> chosen = Spread(node_t_s, strips, spacing_s);
  while (chosen.size() > kMostEpochs) {
    spacing_s *= kGrowth;
    chosen = Spread(node_t_s, strips, spacing_s);
  }
  return chosen;
}

// From the tangent coordinates of a node (map, body) to east, north, up and body.
Matrix6d EnuFromNode(const FlightNetwork& network, std::size_t node) {
  Matrix6d T = Matrix6d::Identity();
  T.topLeftCorner<3, 3>() = network.flight().frame.R_m_enu(network.NodePose(node).p_mb).transpose();
  return T;
}

Matrix6d Units() {
  Eigen::Matrix<double, 6, 1> units;
  units << 1.0, 1.0, 1.0, Eigen::Vector3d::Constant(kDegPerRad);
  return units.asDiagonal();
}

}  // namespace

PoseCovariance ExtractPoseCovariance(const Adjustment& adjustment, const Marginals& marginals,
                                     const std::vector<StripInterval>& strips) {
  PoseCovariance out;
  if (strips.empty() || strips.size() > kMostStrips) return out;
  const FlightNetwork& network = *adjustment.network;
  const std::vector<StripNode> chosen = Choose(network.node_times(), strips);
  const auto T = static_cast<Eigen::Index>(chosen.size());
  out.covariance.resize(6 * T, 6 * T);
  for (Eigen::Index j = 0; j < T; ++j) {
    const StripNode& at = chosen[static_cast<std::size_t>(j)];
    const NodeBlocks& node = network.nodes[at.node];
    out.t_s.push_back(node.t_s);
    out.strip.push_back(at.strip);
    const Marginals::Columns columns = marginals.SolveColumns({node.p_mb.id, node.q_mb.id});
    const Matrix6d T_j = EnuFromNode(network, at.node);
    for (Eigen::Index i = 0; i < T; ++i) {
      const std::size_t other = chosen[static_cast<std::size_t>(i)].node;
      Matrix6d C;
      C << columns.Rows(network.nodes[other].p_mb.id), columns.Rows(network.nodes[other].q_mb.id);
      out.covariance.block<6, 6>(6 * i, 6 * j) = EnuFromNode(network, other) * C * T_j.transpose();
    }
  }
  out.covariance = (0.5 * (out.covariance + out.covariance.transpose())).eval();
  return out;
}

std::string FormatPoseCovariance(const PoseCovariance& covariance) {
  std::string text =
      "# covariance between two epochs of the trajectory: t_i, strip_i, t_j, strip_j, then row by "
      "row\n# that of pose i with pose j: position E, N, U [m], attitude about body x, y, z "
      "[deg]\n";
  const Matrix6d units = Units();
  for (std::size_t i = 0; i < covariance.t_s.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      fmt::format_to(std::back_inserter(text), "{} {} {} {}", FormatDouble(covariance.t_s[i]),
                     covariance.strip[i], FormatDouble(covariance.t_s[j]), covariance.strip[j]);
      const Matrix6d C = units *
                         covariance.covariance.block<6, 6>(6 * static_cast<Eigen::Index>(i),
                                                           6 * static_cast<Eigen::Index>(j)) *
                         units;
      for (int row = 0; row < 6; ++row) {
        for (int column = 0; column < 6; ++column) {
          fmt::format_to(std::back_inserter(text), " {:.9g}", C(row, column));
        }
      }
      text += '\n';
    }
  }
  return text;
}

PoseCovariance ReadPoseCovariance(const std::filesystem::path& file) {
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
  PoseCovariance out;
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
  try {
    out.Validate();
  } catch (const InvalidConfig& error) {
    fail(error.what(), 0);
  }
  return out;
}

}  // namespace dn
