#pragma once

#include <filesystem>
#include <string>

#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {

// A real Slurm of some nodes on this machine (slurm_cluster.sh), as long as it lives. Programs that
// are started meanwhile submit to it: SLURM_CONF is set.
class SlurmCluster {
 public:
  explicit SlurmCluster(int num_nodes = 2, int cores_of_node = 1);
  ~SlurmCluster();
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;

  // Why it could not be started; empty if it runs.
  const std::string& problem() const { return problem_; }
  // The daemon of the node and its jobs die, and Slurm is told that the node is down, as it finds
  // out by itself half a minute later.
  void KillNode(const std::string& node);
  void StartNode(const std::string& node);

 private:
  std::string Call(const std::string& action, const std::string& rest = "");

  TemporaryFolder folder_;
  std::string problem_;
};

// What a command of the shell prints.
std::string OutputOf(const std::string& command);

}  // namespace lsmvs

// Starts a cluster `name` with these arguments, or skips the test and says why.
#define LSMVS_REQUIRE_SLURM(name, ...)     \
  ::lsmvs::SlurmCluster name{__VA_ARGS__}; \
  if (!name.problem().empty()) GTEST_SKIP() << "no Slurm: " << name.problem()
