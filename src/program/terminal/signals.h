#pragma once

#include <atomic>

namespace lsmvs {

// Makes the first Ctrl-C or SIGTERM set the returned flag (and say so on the error stream); a
// second one kills the process as if nothing had been installed. SIGPIPE and SIGXFSZ are ignored,
// so that a failed write is an error with a name.
const std::atomic<bool>* InstallSignalHandlers();

}  // namespace lsmvs
