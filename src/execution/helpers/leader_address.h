#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace lsmvs {

// Where a process waits for its helpers.
struct LeaderAddress {
  std::vector<std::string> hosts;  // names and numbers of its machine, to be tried in this order
  uint16_t port = 0;
  std::string token;
};

// Of this machine: its name, and the addresses of its network interfaces.
std::vector<std::string> HostsOfThisMachine();
// 32 random hexadecimal digits.
std::string MakeToken();
// With which a helper shows that it may help: it knows the token, and is the same program, to the
// byte.
std::string HelloText(const std::string& token);
// Readable for the user alone.
void WriteLeaderAddress(const std::filesystem::path& path, const LeaderAddress& address);
// Nothing if it is not there (yet). Lists the folder, so that file systems that cache names show
// new ones.
std::optional<LeaderAddress> ReadLeaderAddress(const std::filesystem::path& path);

}  // namespace lsmvs
