#pragma once

#include <string>
#include <vector>

namespace lsmvs {

// Edits (insert, delete, replace a character, case ignored) that turn `a` into `b`. O(|a| |b|).
int EditDistance(const std::string& a, const std::string& b);

// The candidate that the user most likely meant by `name`, or empty if none is near: at most a
// third of the letters edited; an option may also be named without its group.
std::string NearestName(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace lsmvs
