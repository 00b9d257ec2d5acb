// run_task ROOT --task NUMBER: a job of the runs of jobs_test.cc and slurm_test.cc, as `lsmvs
// run_task` is one of a reconstruction. The order's first argument is the word of the tasks.

#include <cstdio>

#include "job_tasks.h"
#include "lsmvs/execution/job_order.h"
#include "lsmvs/util/error.h"

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  try {
    const std::filesystem::path root = argv[2];
    const lsmvs::JobNumber job = lsmvs::ParseJobNumber(argv[4]);
    const lsmvs::JobOrder order = lsmvs::ReadJobOrder(lsmvs::JobsFolder(root) / job.batch);
    lsmvs::RunContext context(order.num_threads);
    context.memory_budget_bytes = order.memory_bytes;
    lsmvs::RunJob(root, job, lsmvs::MakeJobTasks(root, order.arguments.at(0)), context);
    return 0;
  } catch (const lsmvs::Error& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}
