#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace dn::apps {

std::vector<std::string> CommandNames(const CLI::App& program);

/// Of a command, or of the program itself, each with its two dashes.
std::vector<std::string> OptionNames(const CLI::App& app);

}  // namespace dn::apps
