#pragma once

#include <filesystem>
#include <string>

namespace dn::apps {

/// Returns true after SIGINT, SIGTERM or SIGHUP.
bool SignalReceived();

/// Installs handlers for SIGINT, SIGTERM and SIGHUP. A signal asks the work to stop. 0.4 s later,
/// or at a second signal, the program is ended by force. The staged files are then removed and the
/// exit code is 130. SIGHUP stays ignored if it was ignored when the program started (nohup).
/// SIGPIPE and SIGXFSZ are ignored, so that a closed pipe or a file-size limit gives a write error.
void InstallSignalHandlers();

/// Sets the actions of a forced end: print the error line `message`, remove the directory
/// `staging` and write `report` to report.json in `directory`. Empty paths: only print.
void PrepareForcedEnd(const std::string& command, const std::string& message,
                      const std::filesystem::path& directory, const std::filesystem::path& staging,
                      const std::string& report);

/// Starts publishing the results; signals no longer interrupt. Returns false if a signal arrived
/// before.
bool BeginPublishing();

/// Starts publishing the report of a failure, even after a signal.
void BeginReporting();

}  // namespace dn::apps
