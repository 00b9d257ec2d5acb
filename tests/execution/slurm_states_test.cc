#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>

#include "job_run.h"
#include "job_tasks.h"
#include "lsmvs/util/error.h"

// What the driver makes of each state of Slurm's jobs, with programs in the place of Slurm's that
// say what a test wants to hear; slurm_test.cc has the real ones.

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

// The first batch ends at once in the state that the file `state` names, as squeue or sacct says;
// the jobs of further ones are run.
constexpr const char* kSbatch = R"(#!/bin/sh
d=$(dirname "$0")
n=$(($(cat "$d/count" 2>/dev/null || echo 0) + 1))
echo $n > "$d/count"
echo "$*" >> "$d/arguments"
for word; do
  case $word in
    --array=*) last=${word#--array=0-}; last=${last%%%*} ;;
    --job-name=*) name=${word#--job-name=} ;;
  esac
done
state=COMPLETED
[ $n = 1 ] && state=$(cat "$d/state")
for i in $(seq 0 $last); do
  if [ $n != 1 ]; then SLURM_ARRAY_TASK_ID=$i sh "$word" > /dev/null 2>&1; fi
  echo "$n|$i|$state|n1|None" >> "$d/queue-$name"
  echo "${n}_$i|$state|n1" >> "$d/accounts-$n"
done
echo $n
)";
constexpr const char* kSqueue = R"(#!/bin/sh
d=$(dirname "$0")
[ -e "$d/forgets" ] && exit 0
while [ $# -gt 0 ]; do [ "$1" = -n ] && cat "$d/queue-$2"; shift; done
exit 0
)";
constexpr const char* kSacct = R"(#!/bin/sh
d=$(dirname "$0")
while [ $# -gt 0 ]; do [ "$1" = -j ] && cat "$d/accounts-$2"; shift; done
exit 0
)";

class FakeSlurm : public testing::Test {
 protected:
  FakeSlurm() : path_(std::getenv("PATH")) {
    Write("sbatch", kSbatch);
    Write("squeue", kSqueue);
    Write("sacct", kSacct);
    Write("scancel", "#!/bin/sh\n");
    Write("sinfo", "#!/bin/sh\necho '2|4000|3'\n");
    ::setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
  }
  ~FakeSlurm() override { ::setenv("PATH", path_.c_str(), 1); }

  static EngineOptions Options() {
    EngineOptions options;
    options.kind = EngineKind::kSlurm;
    options.job_minutes = 0;
    return options;
  }

  void RunWithState(const std::string& state, const EngineOptions& options = Options()) {
    WriteText(folder_.path() / "state", state);
    run_.Run(options);
    EXPECT_EQ(run_.Results(), LocalResults()) << state;
  }

  // Value of an argument of the submission that is given.
  std::string Argument(size_t submission, const std::string& name) const {
    std::ifstream file(folder_.path() / "arguments");
    std::string line;
    for (size_t i = 0; i <= submission; ++i) std::getline(file, line);
    const size_t at = line.find(name);
    if (at == std::string::npos) return "";
    const size_t begin = at + name.size();
    return line.substr(begin, line.find(' ', begin) - begin);
  }

  void Write(const std::string& name, const std::string& text) {
    WriteText(folder_.path() / name, text);
    fs::permissions(folder_.path() / name, fs::perms::owner_all);
  }

  TemporaryFolder folder_;
  JobRun run_;

 private:
  const std::string path_;
};

TEST_F(FakeSlurm, MemoryIsDoubledWhereItWasTooShort) {
  RunWithState("OUT_OF_MEMORY");
  EXPECT_THAT(run_.observer.Notes(), HasSubstr("took more memory than it had asked for on n1"));
  EXPECT_THAT(run_.observer.Notes(), HasSubstr("submitted again, with more memory"));
  EXPECT_EQ(Argument(0, "--mem="), "245M");
  EXPECT_EQ(Argument(1, "--mem="), "489M");
  EXPECT_EQ(Argument(1, "--time="), Argument(0, "--time="));
  EXPECT_EQ(Argument(2, "--mem="), "245M") << "of other tasks";
}

TEST_F(FakeSlurm, TimeIsDoubledWhereItWasTooShort) {
  for (const char* state : {"TIMEOUT", "DEADLINE"}) {
    run_.observer.notes.clear();
    fs::remove(folder_.path() / "count");
    fs::remove(folder_.path() / "arguments");
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      if (entry.path().filename().string().starts_with("accounts")) fs::remove(entry.path());
    }
    fs::remove_all(run_.root() / "lsmvs");
    fs::remove_all(run_.root() / "maps");
    for (const char* file : {"all", "all.vis"}) fs::remove(run_.root() / file);
    RunWithState(state);
    EXPECT_THAT(run_.observer.Notes(), HasSubstr("reached its time limit on n1"));
    EXPECT_THAT(run_.observer.Notes(), HasSubstr("submitted again, with more time"));
    EXPECT_EQ(Argument(0, "--time="), "0-00:11:00");
    EXPECT_EQ(Argument(1, "--time="), "0-00:21:00");
    EXPECT_EQ(Argument(1, "--mem="), Argument(0, "--mem="));
  }
}

TEST_F(FakeSlurm, ATimeThatTheUserGaveStays) {
  EngineOptions options = Options();
  options.time = "2:00:00";
  RunWithState("TIMEOUT", options);
  EXPECT_THAT(run_.observer.Notes(), HasSubstr("reached its time limit"));
  EXPECT_THAT(run_.observer.Notes(), Not(HasSubstr("with more time")));
  EXPECT_EQ(Argument(1, "--time="), "2:00:00");
}

TEST_F(FakeSlurm, WorkOfNodesThatFailIsSubmittedAsItWas) {
  RunWithState("NODE_FAIL");
  EXPECT_THAT(run_.observer.Notes(), HasSubstr("was lost with its node on n1"));
  EXPECT_EQ(Argument(1, "--mem="), Argument(0, "--mem="));
  EXPECT_EQ(Argument(1, "--time="), Argument(0, "--time="));
}

TEST_F(FakeSlurm, SoIsWorkOfNodesThatDoNotBoot) {
  RunWithState("BOOT_FAIL");
  EXPECT_THAT(run_.observer.Notes(), HasSubstr("was lost with its node"));
}

TEST_F(FakeSlurm, SoIsWorkThatOthersTookTheNodesFrom) {
  RunWithState("PREEMPTED");
  EXPECT_THAT(run_.observer.Notes(), HasSubstr("was lost with its node"));
}

TEST_F(FakeSlurm, JobsThatFailAreSubmittedAgain) {
  RunWithState("FAILED");
  EXPECT_THAT(run_.observer.Notes(), HasSubstr("of Slurm failed on n1"));
  EXPECT_THAT(run_.observer.Notes(), Not(HasSubstr("with more")));
}

TEST_F(FakeSlurm, ACancelledJobEndsTheRun) {
  WriteText(folder_.path() / "forgets", "");
  WriteText(folder_.path() / "state", "CANCELLED by 1000");
  try {
    run_.Run(Options());
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kCancelled);
    EXPECT_THAT(error.what(), HasSubstr("cancelled by somebody else on n1"));
  }
}

// squeue forgets jobs after some minutes; accounting knows them.
TEST_F(FakeSlurm, WhatTheQueueHasForgottenIsAskedFromAccounting) {
  WriteText(folder_.path() / "forgets", "");
  RunWithState("OUT_OF_MEMORY");
  EXPECT_THAT(run_.observer.Notes(), HasSubstr("with more memory"));
}

TEST_F(FakeSlurm, LimitsAreOfTheLargestNodeAndOfAll) {
  const std::optional<JobLimits> limits = FindJobLimits(Options());
  ASSERT_TRUE(limits.has_value());
  EXPECT_EQ(limits->num_threads, 2);
  EXPECT_EQ(limits->num_threads_in_all, 6);
}

}  // namespace
}  // namespace lsmvs
