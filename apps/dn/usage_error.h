#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace dn::apps {

/// Returns the error line for an invalid command line: "dn COMMAND: error: ...".
std::string UsageError(const CLI::App& program, const CLI::ParseError& error);

}  // namespace dn::apps
