#pragma once

#include <dn/files/file_content.h>
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "testing/temp_folder.h"

namespace dn::files_test {

inline FileContent Inspect(const std::string& text, const std::string& name = "data.csv") {
  const testing::TempFolder folder;
  folder.Write(name, text);
  return InspectFile(folder.path() / name);
}

using Row = std::vector<double>;

inline std::string Join(const Row& row, const char* separator) {
  std::string text;
  for (const double x : row) text += (text.empty() ? "" : separator) + fmt::format("{:.12g}", x);
  return text + "\n";
}

/// Returns rows at 50 Hz of a body that flies curves: time, then rates and forces as `order` puts
/// them.
inline std::string Inertial(const std::function<Row(double t, const Row& w, const Row& f)>& order,
                            const char* separator = ",") {
  std::string text;
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.02 * i, s = std::sin(0.7 * t), c = std::cos(0.3 * t);
    const double shake = std::sin(11.3 * i), beat = std::cos(7.1 * i);
    text += Join(order(t, {0.1 * s + 0.02 * shake, 0.05 * c - 0.02 * beat, 0.08 * s * c},
                       {0.5 * c + 0.3 * beat, 0.8 * s + 0.3 * shake, -9.81 + 0.4 * s}),
                 separator);
  }
  return text;
}

inline Row Plus(Row a, const Row& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline Row Times(Row a, double factor) {
  for (double& x : a) x *= factor;
  return a;
}

}  // namespace dn::files_test
