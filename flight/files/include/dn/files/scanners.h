#pragma once

#include <dn/files/flight_config.h>
#include <dn/lidar/pairs.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// Returns the number of scanners of a flight; 0 without a section `lidar`.
std::size_t NumScanners(const FlightConfig& config);

/// Returns scanner k of a flight, k < NumScanners.
const LidarConfig& ScannerAt(const FlightConfig& config, std::size_t k);
LidarConfig& ScannerAt(FlightConfig& config, std::size_t k);

/// Leaves only scanner k, without pairs between scanners.
void KeepScanner(std::size_t k, FlightConfig* config);

/// Returns the sigma of pairs between two scanners without a stated one: the root mean square of
/// theirs, at least 1e-12 m.
double SigmaBetween(const LidarConfig& i, const LidarConfig& j);

/// Returns the names of the scanners; that of a scanner without a list is empty.
std::vector<std::string> ScannerNames(const FlightConfig& config);

/// Returns the name that an unknown of scanner k has in networks and results: `unknown` for the
/// first scanner, else `unknown/NAME`.
std::string ScannerName(const FlightConfig& config, std::string_view unknown, std::size_t k);

/// Returns the scanner of an unknown with a name of ScannerName; 0 for every other name.
std::size_t FindScanner(const FlightConfig& config, std::string_view name);

/// Gives the entries of `estimate` the names of their scanners (ScannerName). In a list of
/// scanners, an entry of a lidar effect without a scanner becomes one entry for each of them.
/// Entries of scanners that `scanner` of flight.yaml does not select are left out; `all` are the
/// names of all scanners of the list. Throws InvalidConfig for an unknown scanner.
void AssignScanners(const std::vector<std::string>& all, FlightConfig* config);

/// Throws InvalidConfig if the flight has several scanners. The message says that `command` takes
/// one, and how to choose it.
void ExpectOneScanner(const FlightConfig& config, const std::string& command);

/// Returns the standard deviation of each coordinate of the difference of a pair without a
/// covariance of its own, m.
double PairSigma(const FlightConfig& config, const LidarPair& pair);

}  // namespace dn
