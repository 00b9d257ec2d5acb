#include "lsmvs/test_support/slurm_cluster.h"

#include <array>
#include <cstdio>
#include <cstdlib>

namespace lsmvs {

std::string OutputOf(const std::string& command) {
  std::string text;
  std::FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 4096> part;
  while (const size_t count = std::fread(part.data(), 1, part.size(), pipe)) {
    text.append(part.data(), count);
  }
  ::pclose(pipe);
  return text;
}

SlurmCluster::SlurmCluster(int num_nodes, int cores_of_node) {
  problem_ = Call("start", std::to_string(num_nodes) + " " + std::to_string(cores_of_node));
  while (!problem_.empty() && problem_.back() == '\n') problem_.pop_back();
  if (problem_.empty()) ::setenv("SLURM_CONF", (folder_.path() / "slurm.conf").c_str(), 1);
}

SlurmCluster::~SlurmCluster() {
  Call("stop");
  ::unsetenv("SLURM_CONF");
}

void SlurmCluster::KillNode(const std::string& node) {
  Call("kill_node", node);
  OutputOf("scontrol update nodename=" + node + " state=down reason=test");
}

void SlurmCluster::StartNode(const std::string& node) {
  Call("start_node", node);
  OutputOf("scontrol update nodename=" + node + " state=resume");
}

std::string SlurmCluster::Call(const std::string& action, const std::string& rest) {
  return OutputOf("'" LSMVS_SLURM_CLUSTER "' " + action + " '" + folder_.path().string() + "' " +
                  rest);
}

}  // namespace lsmvs
