#pragma once

#include <string>

namespace dn::apps {

/// What the user of a command can change to need less memory.
std::string MemoryAdvice(const std::string& command);

}  // namespace dn::apps
