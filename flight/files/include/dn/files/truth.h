#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

namespace dn {

/// Returns boresight_deg of FOLDER/truth.yaml, which simulated flights contain, or that of a
/// scanner under `scanners`; nullopt without
/// this file or entry. It is only used to print errors.
std::optional<Eigen::Vector3d> ReadTrueBoresightDeg(const std::filesystem::path& folder,
                                                    const std::string& scanner = "");

}  // namespace dn
