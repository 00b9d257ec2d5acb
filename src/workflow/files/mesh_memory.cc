#include "lsmvs/workflow/files/mesh_memory.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <cstdint>

#include "lsmvs/colmap_adapter/pmvs_cloud.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/memory.h"
#include "lsmvs/workflow/planning/plan_text.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

// Of a mesh, or half the points of a cloud: a vertex stands for two faces.
double CountFaces(const fs::path& path) {
  if (!fs::exists(path)) return 0;
  try {
    if (IsPmvsResult(path)) return 2 * static_cast<double>(CountPmvsPoints(path));
    const PlyReader reader(path);
    const auto count_of = [&](const char* name) {
      const PlyElement* element = reader.FindElement(name);
      return element == nullptr ? 0 : static_cast<double>(element->count);
    };
    return std::max(count_of("face"), 2 * count_of("vertex"));
  } catch (const InputError&) {
    return 0;
  }
}

}  // namespace

MeshMemory::MeshMemory(const std::string& command, const std::vector<fs::path>& meshes,
                       const MeshMemoryModel& model, const std::string& scratch_path,
                       const CommandContext& context) {
  const fs::path scratch_folder =
      scratch_path.empty() ? fs::temp_directory_path() : fs::path(scratch_path);
  if (!fs::is_directory(scratch_folder)) {
    throw InputError(scratch_folder.string(), "is no folder", "make it, or correct --scratch_path");
  }
  double num_faces = 0;
  for (const fs::path& mesh : meshes) num_faces += CountFaces(mesh);
  const size_t needed = static_cast<size_t>(model.all * num_faces) + model.fixed;
  if (num_faces == 0 || needed <= context.run.memory_budget_bytes) return;
  constexpr size_t kWorkingBytes = 16 << 20;  // chunks that are worked on
  const size_t least =
      static_cast<size_t>(model.in_memory * num_faces) + model.fixed + kWorkingBytes;
  const size_t allowed = context.AllowedBytes();
  const std::string needs = fmt::format(
      "{}: {:.1f} million faces need about {} of memory, but {} may be used", command,
      num_faces / 1e6, FormatBytes(context.process_bytes + needed), FormatBytes(allowed));
  if (least > context.run.memory_budget_bytes || !ScratchMemory::IsAvailable()) {
    throw MemoryError(
        fmt::format("{}, and about {} with a scratch file; allow more with --max_memory, or give a "
                    "smaller mesh",
                    needs, FormatBytes(context.process_bytes + least)));
  }
  if (const std::optional<Disk> disk = DiskOf(scratch_folder); disk && disk->free_bytes < needed) {
    throw Error(
        ExitCode::kFileSystem,
        fmt::format("{}: the scratch file needs about {} of disk, but {} are free; make "
                    "room, or name another folder by --scratch_path",
                    scratch_folder.string(), FormatBytes(needed), FormatBytes(disk->free_bytes)));
  }
  LOG(WARNING) << needs << "; works with a scratch file in " << scratch_folder.string()
               << (model.in_any_order
                       ? ", many times slower: it goes through the mesh in any order; "
                         "allow more with --max_memory if you can"
                       : "");
  scratch_.emplace(ScratchMemoryOptions{scratch_folder, allowed});
}

void DescribeMeshScratch(std::string* scratch_path, OptionSet* options) {
  options->Add("scratch_path", scratch_path,
               "Folder for the scratch file of a mesh that does not fit into --max_memory; "
               "without it the system's folder for temporary files. It should lie on a fast local "
               "disk.");
}

}  // namespace lsmvs
