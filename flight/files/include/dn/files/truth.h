#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

namespace dn {

/// boresight_deg of FOLDER/truth.yaml, which a simulated flight carries; only ever used to print
/// errors. Nothing where there is no such file or no such entry.
std::optional<Eigen::Vector3d> ReadTrueBoresightDeg(const std::filesystem::path& folder);

}  // namespace dn
