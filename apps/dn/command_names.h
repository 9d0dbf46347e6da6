#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace dn::apps {

std::vector<std::string> CommandNames(const CLI::App& program);

/// Returns the option names of a command or of the program itself, with the two dashes.
std::vector<std::string> OptionNames(const CLI::App& app);

}  // namespace dn::apps
