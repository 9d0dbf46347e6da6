#pragma once

namespace dn::apps {

/// From this call on, all output to stdout passes through a PrintableStream, so that control
/// characters in files or names do not reach the terminal. The output is buffered until it is
/// flushed. If stdout cannot be written, the command therefore still completes its work.
void GuardStandardOutput();

}  // namespace dn::apps
