#pragma once

#include <dn/report/json.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "run_program.h"

namespace dn::testing {

/// A copy of a results folder, made again at `copy`, in which a JSON file is changed.
inline std::filesystem::path ChangedCopy(const std::filesystem::path& folder,
                                         const std::filesystem::path& copy, const std::string& file,
                                         const std::function<void(Json*)>& change) {
  std::filesystem::remove_all(copy);
  std::filesystem::copy(folder, copy, std::filesystem::copy_options::recursive);
  Json json = Json::parse(FileContent(copy / file));
  change(&json);
  std::ofstream(copy / file) << json.dump() << "\n";
  return copy;
}

}  // namespace dn::testing
