#pragma once

#include <string>

namespace dn::apps {

/// Returns advice on how the user of a command can reduce its memory.
std::string MemoryAdvice(const std::string& command);

}  // namespace dn::apps
