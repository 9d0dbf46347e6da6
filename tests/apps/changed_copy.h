#pragma once

#include <dn/report/json.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "load_json.h"

namespace dn::testing {

/// Copies a results folder to `copy`, replacing an earlier copy, and changes one of its JSON files.
/// Returns `copy`.
inline std::filesystem::path ChangedCopy(const std::filesystem::path& folder,
                                         const std::filesystem::path& copy, const std::string& file,
                                         const std::function<void(Json*)>& change) {
  std::filesystem::remove_all(copy);
  std::filesystem::copy(folder, copy, std::filesystem::copy_options::recursive);
  Json json = LoadJson(copy / file);
  change(&json);
  std::ofstream(copy / file) << json.dump() << "\n";
  return copy;
}

}  // namespace dn::testing
