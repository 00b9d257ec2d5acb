#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/program/command_context.h"
#include "lsmvs/util/scratch_memory.h"

namespace lsmvs {

// Bytes that a command needs for each face of a mesh with half as many vertices, those of them that
// no scratch file can hold (the ray tracer's own), and what it needs for any mesh. Measured on
// surfaces of 0.5 to 5 million faces.
struct MeshMemoryModel {
  double all = 0, in_memory = 0;
  size_t fixed = 48 << 20;
  // Whether the command goes through the mesh in any order, which a scratch file makes many times
  // slower.
  bool in_any_order = false;
};

// Of a command that casts rays to the mesh, or looks for the nearest places on it.
inline constexpr MeshMemoryModel kTracedMeshMemory = {.all = 150, .in_memory = 100};

// Memory of a command that works on whole meshes, for its life. Where they need more than may be
// used, large arrays lie in a scratch file, and a line says so; where that does not do, the command
// ends before it starts. Results have the same bytes.
class MeshMemory {
 public:
  // `scratch_path`: the folder of the scratch file; empty: the system's for temporary files.
  // `meshes`: that are held at the same time. Reads their headers; those that are no PLY files or
  // are not there count nothing. Throws MemoryError with what is needed, Error(kFileSystem) if the
  // scratch file does not fit on the disk.
  MeshMemory(const std::string& command, const std::vector<std::filesystem::path>& meshes,
             const MeshMemoryModel& model, const std::string& scratch_path,
             const CommandContext& context);

 private:
  std::optional<ScratchMemory> scratch_;
};

// Describes --scratch_path of such a command.
void DescribeMeshScratch(std::string* scratch_path, OptionSet* options);

}  // namespace lsmvs
