#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace dn::apps {

/// Validators of option values. Each message quotes the value (shortened) and the bound.
CLI::Validator PositiveNumber();
CLI::Validator WholeNumber(std::uint64_t least,
                           std::uint64_t most = std::numeric_limits<std::uint64_t>::max());
/// Accepts numbers from 0 on, below 1.
CLI::Validator Probability();
CLI::Validator AllowedValues(std::vector<std::string> words);

}  // namespace dn::apps
