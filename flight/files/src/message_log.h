#pragma once

#include <dn/files/file_content.h>

#include <filesystem>
#include <string_view>
#include <vector>

namespace dn::files_internal {

/// Returns the contents of an ASCII log of a NovAtel receiver. There is one for each kind of data,
/// with the columns of the message that has them. Returns nothing if `beginning`, the first lines,
/// has none of the known messages.
///
///   inertial data   RAWIMU, RAWIMUX: increments in counts; their size follows from gravity
///   GNSS            BESTGNSSPOS, BESTGPSPOS, BESTPOS without inertial data
///   trajectory      INSPVA, INSPVAX
std::vector<FileContent> FindMessages(const std::filesystem::path& file,
                                      std::string_view beginning);

}  // namespace dn::files_internal
