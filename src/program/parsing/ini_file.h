#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace lsmvs {

// An option by its full name ("StereoFusion.min_num_pixels") and the text given for it.
using Assignment = std::pair<std::string, std::string>;

// Reads an ini file as COLMAP's --project_path: `key=value`, `[Group]` sections, `#` and `;`
// comments. In file order. Throws InputError when it cannot be read or a line is not of that form.
std::vector<Assignment> ReadIniFile(const std::filesystem::path& path);

}  // namespace lsmvs
