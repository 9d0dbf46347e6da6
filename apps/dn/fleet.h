#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "command.h"

namespace dn::apps {

/// Simulates `count` flights on several threads; a free thread takes the next flight.
/// `fly(k)` is called from several threads at once. `landed(k)` is called after fly(k), by one
/// thread at a time. The progress counts the flights under the name `what`. Rethrows the first
/// exception of a flight; throws Interrupted after a signal.
void SimulateAll(std::size_t count, Run* run, const std::function<void(std::size_t k)>& fly,
                 const std::function<void(std::size_t k)>& on_finished,
                 const std::string& what = "flights");

}  // namespace dn::apps
