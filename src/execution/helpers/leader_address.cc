#include "lsmvs/execution/helpers/leader_address.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <random>
#include <sstream>
#include <system_error>

#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/hash.h"
#include "lsmvs/util/host_name.h"

namespace lsmvs {

namespace fs = std::filesystem;

std::vector<std::string> HostsOfThisMachine() {
  std::vector<std::string> hosts = {HostName()};
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0) return hosts;
  for (const ifaddrs* entry = first; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    if ((entry->ifa_flags & IFF_UP) == 0 || (entry->ifa_flags & IFF_LOOPBACK) != 0) continue;
    char text[INET_ADDRSTRLEN] = "";
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    if (::inet_ntop(AF_INET, &address->sin_addr, text, sizeof text) != nullptr) {
      hosts.emplace_back(text);
    }
  }
  ::freeifaddrs(first);
  return hosts;
}

std::string MakeToken() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", random());
  return token;
}

std::string HelloText(const std::string& token) {
  static const std::string program = HashFile("/proc/self/exe");
  return token + " " + program;
}

void WriteLeaderAddress(const fs::path& path, const LeaderAddress& address) {
  std::string text = fmt::format("{} {}", address.port, address.token);
  for (const std::string& host : address.hosts) text += " " + host;
  const fs::path written = path.string() + std::string(AtomicFile::kTemporarySuffix);
  ::unlink(written.c_str());
  const int descriptor =
      ::open(written.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  const bool is_written = descriptor >= 0 && ::write(descriptor, text.data(), text.size()) ==
                                                 static_cast<ssize_t>(text.size());
  if (descriptor >= 0) ::close(descriptor);
  if (!is_written || ::rename(written.c_str(), path.c_str()) != 0) {
    throw FileSystemError(path.string(), "write the file", errno);
  }
}

std::optional<LeaderAddress> ReadLeaderAddress(const fs::path& path) {
  std::error_code error;
  bool is_there = false;
  for (const auto& entry : fs::directory_iterator(path.parent_path(), error)) {
    is_there = is_there || entry.path().filename() == path.filename();
  }
  if (!is_there) return std::nullopt;
  std::ifstream file(path);
  LeaderAddress address;
  if (!(file >> address.port >> address.token)) return std::nullopt;
  for (std::string host; file >> host;) address.hosts.push_back(host);
  return address;
}

}  // namespace lsmvs
