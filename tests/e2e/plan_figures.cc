#include "plan_figures.h"

#include <gtest/gtest.h>

#include <regex>

namespace lsmvs {

PlanFigures ReadPlanFigures(const std::string& plan, const std::string& stage) {
  const std::regex row("\n  " + stage + "[^\n]* ([0-9.]+) (MB|GB) +([0-9.]+) (MB|GB)\n");
  std::smatch match;
  if (!std::regex_search(plan, match, row)) {
    ADD_FAILURE() << "no row of " << stage << " in\n" << plan;
    return {};
  }
  const auto bytes = [&](size_t value) {
    return std::stod(match[value]) * (match[value + 1] == "GB" ? 1e9 : 1e6);
  };
  return {bytes(1), bytes(3)};
}

}  // namespace lsmvs
