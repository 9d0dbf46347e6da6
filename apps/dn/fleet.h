#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "command.h"

namespace dn::apps {

/// Flies `count` flights on several threads, the next one as a thread gets free. `fly(k)` is called
/// from several threads at once; `landed(k)` by one at a time, when fly(k) is done. Throws what the
/// first of them threw, and Interrupted after a signal. The progress counts them as `what`.
void FlyAll(std::size_t count, Run* run, const std::function<void(std::size_t k)>& fly,
            const std::function<void(std::size_t k)>& landed, const std::string& what = "flights");

}  // namespace dn::apps
