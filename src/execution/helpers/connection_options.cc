#include "lsmvs/execution/helpers/connection_options.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace lsmvs {

namespace {

// What is sent may wait for an item that takes long.
constexpr int kLostAfterSeconds = 300, kProbeSeconds = 10, kNumProbes = 3;

void Set(int descriptor, int level, int option, int value) {
  ::setsockopt(descriptor, level, option, &value, sizeof value);
}

}  // namespace

void SetConnectionOptions(int descriptor) {
  Set(descriptor, IPPROTO_TCP, TCP_NODELAY, 1);
  // Of what was sent and is not acknowledged, and of a connection on which nothing is sent.
  Set(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT, 1000 * kLostAfterSeconds);
  Set(descriptor, SOL_SOCKET, SO_KEEPALIVE, 1);
  Set(descriptor, IPPROTO_TCP, TCP_KEEPIDLE, kProbeSeconds);
  Set(descriptor, IPPROTO_TCP, TCP_KEEPINTVL, kProbeSeconds);
  Set(descriptor, IPPROTO_TCP, TCP_KEEPCNT, kNumProbes);
}

}  // namespace lsmvs
