#pragma once

namespace dn::apps {

/// Everything that is printed on stdout from here on passes a PrintableStream: no control character
/// of a file or a name reaches the terminal. It waits in a buffer until it is flushed, so that an
/// unwritable stdout does not end the work before its end.
void GuardStandardOutput();

}  // namespace dn::apps
