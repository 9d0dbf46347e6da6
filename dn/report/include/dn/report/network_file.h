#pragma once

#include <dn/network_state.h>

#include <filesystem>
#include <string>
#include <string_view>

namespace dn {

/// JSON for other tools; binary for large networks: a tenth of the size, and exact.
enum class StateFormat { kJson, kBinary };

/// Returns the state as the content of a file. JSON:
///
///   {"schema": "dn.network/1",
///    "blocks": [{"name": "boresight", "parametrisation": "rotation_left", "value": [0, 0, 0, 1],
///                "covariance": [[..]]}],
///    "priors": [{"group": "eliminated", "blocks": ["x"], "center": [..], "R": [[..]], "d": [..],
///                "nonlinearity": 0}]}
///
/// with covariance null if it is not known. Numbers read back to the same value. The binary format
/// has the same content with little-endian numbers, after the eight bytes "dn.net1\n".
std::string FormatState(const NetworkState& state, StateFormat format);

/// Reads either format. `file` is the name for messages. Throws InvalidInput naming the file and
/// the place of what is wrong.
NetworkState ParseState(std::string_view content, const std::string& file);

/// Writes or reads a file. Throw InvalidInput naming the file if that fails.
void WriteState(const std::filesystem::path& path, const NetworkState& state, StateFormat format);
NetworkState ReadState(const std::filesystem::path& path);

}  // namespace dn
