#pragma once

namespace lsmvs {

// Of a TCP connection, by its descriptor: sends at once, and notices when the other machine is
// gone.
void SetConnectionOptions(int descriptor);

}  // namespace lsmvs
