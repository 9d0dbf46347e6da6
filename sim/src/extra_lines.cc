#include <dn/sim/extra_lines.h>

#include <utility>

namespace dn {
namespace {

constexpr double kHigherByHeight = 0.4;
constexpr double kFasterBySpeed = 1.3;

}  // namespace

PlannedLine CrossLine(const std::vector<PlannedLine>& lines) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const PlannedLine& line : lines) middle += 0.5 * (line.start_en_m + line.end_en_m);
  middle /= static_cast<double>(lines.size());
  PlannedLine cross = lines.front();
  const Eigen::Vector2d along = cross.end_en_m - cross.start_en_m;
  const Eigen::Vector2d across(-along.y(), along.x());
  cross.start_en_m = middle - 0.5 * across;
  cross.end_en_m = middle + 0.5 * across;
  return cross;
}

PlannedLine Reversed(PlannedLine line) {
  std::swap(line.start_en_m, line.end_en_m);
  return line;
}

PlannedLine Higher(PlannedLine line, double height_above_ground_m) {
  line.height_m += kHigherByHeight * height_above_ground_m;
  return line;
}

PlannedLine Faster(PlannedLine line) {
  line.speed_mps *= kFasterBySpeed;
  return line;
}

}  // namespace dn
