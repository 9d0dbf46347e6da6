#pragma once

#include <filesystem>
#include <string>

namespace dn::apps {

/// True after SIGINT, SIGTERM or SIGHUP.
bool SignalCame();

/// From here on such a signal asks the work to end, and what has not ended 0.4 s later is ended by
/// force, as by a second signal: nothing stays of what was staged, exit code 130. A SIGHUP that the
/// program was started to ignore (nohup) stays ignored. A reader of our output that goes away and a
/// limit of file size are errors of writing, not the end.
void InstallSignalHandlers();

/// What an end by force leaves in the output directory: its staging directory is removed, and this
/// report.json put into it. Empty paths: nothing. The error line says `message`.
void PrepareForcedEnd(const std::string& command, const std::string& message,
                      const std::filesystem::path& directory, const std::filesystem::path& staging,
                      const std::string& report);

/// From here on results are published, which no signal interrupts any more. False when one came
/// before.
bool BeginPublishing();

/// The same after the work has failed: the report of it is published in any case.
void BeginReporting();

}  // namespace dn::apps
