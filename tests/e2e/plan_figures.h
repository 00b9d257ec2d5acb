#pragma once

#include <string>

namespace lsmvs {

// What a printed plan says of a stage.
struct PlanFigures {
  double memory_bytes = 0, disk_bytes = 0;
};

// `stage`: what its row begins with, "all" for the last one. Fails the test if there is no such
// row.
PlanFigures ReadPlanFigures(const std::string& plan, const std::string& stage);

}  // namespace lsmvs
