#pragma once

#include <dn/report/json.h>

#include <filesystem>

#include "run_program.h"

namespace dn::testing {

/// Returns the content of a JSON file that the program wrote.
inline Json LoadJson(const std::filesystem::path& file) { return Json::parse(FileContent(file)); }

}  // namespace dn::testing
