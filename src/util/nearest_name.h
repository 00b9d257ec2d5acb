#pragma once

#include <string>
#include <vector>

namespace lsmvs {

// Edits (insert, delete, replace a character, case ignored) that turn `a` into `b`. O(|a| |b|).
int EditDistance(const std::string& a, const std::string& b);

// The candidate that the user most likely meant by `name`, or empty if none is near: at most a
// third of the letters edited.
std::string NearestName(const std::string& name, const std::vector<std::string>& candidates);
// The same for names of options, "Group.field", which may also be given without their group or with
// a wrong one.
std::string NearestOption(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace lsmvs
