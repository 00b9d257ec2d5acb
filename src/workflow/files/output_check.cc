#include "lsmvs/workflow/files/output_check.h"

#include <algorithm>

#include "lsmvs/util/error.h"

namespace lsmvs {

void RefuseToReplace(const std::vector<std::filesystem::path>& files, bool overwrite) {
  for (const std::filesystem::path& file : files) {
    if (overwrite || !std::filesystem::exists(file)) continue;
    throw Error(ExitCode::kOverwrite,
                file.string() + ": is there already; give --overwrite or another --output_path");
  }
}

void RefuseToReplaceInputs(const std::string& output, const std::vector<std::string>& inputs) {
  if (output.empty()) return;
  const std::filesystem::path target = std::filesystem::weakly_canonical(output);
  for (const std::string& input : inputs) {
    if (input.empty()) continue;
    const std::filesystem::path source = std::filesystem::weakly_canonical(input);
    const auto [source_end, target_end] =
        std::mismatch(source.begin(), source.end(), target.begin(), target.end());
    if (source_end != source.end()) continue;
    throw Error(ExitCode::kOverwrite,
                output + ": would replace an input of this command; give another path");
  }
}

}  // namespace lsmvs
