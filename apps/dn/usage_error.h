#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace dn::apps {

/// The error line for a command line that cannot be parsed: "dn COMMAND: error: ...".
std::string UsageError(const CLI::App& program, const CLI::ParseError& error);

}  // namespace dn::apps
