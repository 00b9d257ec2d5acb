#include "lsmvs/colmap_adapter/pmvs_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <string>

#include "lsmvs/colmap_adapter/files/text_reader.h"
#include "lsmvs/colmap_adapter/pmvs_scene.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

using internal::TextReader;

constexpr const char* kRemedy = "run pmvs2 again, or give its .ply";

double FiniteNumber(TextReader* reader) {
  const double value = reader->Double();
  if (!std::isfinite(value)) reader->Fail("has a number that is not finite");
  return value;
}

// The next line of a patch; `what` names it.
void NextPatchLine(TextReader* reader, uint64_t patch, uint64_t num_patches, const char* what) {
  if (reader->NextContentLine()) return;
  reader->Fail(fmt::format("ends before the {} of patch {} of {}", what, patch + 1, num_patches));
}

// A line of four numbers: three and a homogeneous coordinate.
Eigen::Vector3d ReadPoint(TextReader* reader) {
  Eigen::Vector3d x;
  for (int k = 0; k < 3; ++k) x[k] = FiniteNumber(reader);
  if (FiniteNumber(reader) != 1) reader->Fail("has a centre whose fourth coordinate is not 1");
  reader->ExpectEndOfLine();
  return x;
}

Eigen::Vector3d ReadNormal(TextReader* reader) {
  Eigen::Vector3d normal;
  for (int k = 0; k < 3; ++k) normal[k] = FiniteNumber(reader);
  FiniteNumber(reader);
  reader->ExpectEndOfLine();
  return normal;
}

// Reads one list of photos and returns their number.
int ReadPhotos(TextReader* reader, uint64_t patch, uint64_t num_patches, int num_photos) {
  NextPatchLine(reader, patch, num_patches, "photos");
  const int count = static_cast<int>(reader->Unsigned(std::numeric_limits<int>::max()));
  reader->ExpectEndOfLine();
  if (count == 0) return 0;
  NextPatchLine(reader, patch, num_patches, "photos");
  for (int i = 0; i < count; ++i) reader->Unsigned(static_cast<uint64_t>(num_photos) - 1);
  reader->ExpectEndOfLine();
  return count;
}

// PATCHA patches have a type and a direction between score and photos.
void SkipDirection(TextReader* reader, uint64_t patch, uint64_t num_patches) {
  NextPatchLine(reader, patch, num_patches, "direction");
  while (!reader->AtEndOfLine()) FiniteNumber(reader);
  NextPatchLine(reader, patch, num_patches, "direction");
  while (!reader->AtEndOfLine()) FiniteNumber(reader);
}

// A patch: its kind, centre, normal, "score, two scales", the photos that agree about it, and those
// that may show it, each as a number and a line of as many positions.
void ReadPatch(TextReader* reader, uint64_t patch, uint64_t num_patches, int num_photos,
               const Eigen::Vector3d& world_offset, PmvsCloud* cloud) {
  NextPatchLine(reader, patch, num_patches, "start");
  const std::string kind(reader->Word());
  if (kind != "PATCHS" && kind != "PATCHA") {
    reader->Fail(fmt::format("has '{}' where PATCHS should begin patch {} of {}",
                             kind.substr(0, 60), patch + 1, num_patches));
  }
  NextPatchLine(reader, patch, num_patches, "centre");
  cloud->points.vertices.push_back(ReadPoint(reader) - world_offset);
  NextPatchLine(reader, patch, num_patches, "normal");
  cloud->points.vertex_normals.push_back(ReadNormal(reader).cast<float>());
  NextPatchLine(reader, patch, num_patches, "score");
  cloud->scores.push_back(static_cast<float>(FiniteNumber(reader)));
  for (int k = 0; k < 2; ++k) FiniteNumber(reader);
  reader->ExpectEndOfLine();
  if (kind == "PATCHA") SkipDirection(reader, patch, num_patches);
  cloud->num_views.push_back(ReadPhotos(reader, patch, num_patches, num_photos));
  ReadPhotos(reader, patch, num_patches, num_photos);
}

uint64_t ReadPatchCount(TextReader* reader) {
  if (!reader->NextContentLine() || reader->Word() != "PATCHES") {
    reader->Fail("does not begin with PATCHES, as PMVS's .patch files do");
  }
  reader->ExpectEndOfLine();
  if (!reader->NextContentLine()) reader->Fail("ends before the number of patches");
  const uint64_t count = reader->Unsigned(std::numeric_limits<uint32_t>::max());
  reader->ExpectEndOfLine();
  return count;
}

void ReadPatches(const fs::path& path, int num_photos, const Eigen::Vector3d& world_offset,
                 PmvsCloud* cloud) {
  TextReader reader(path, kRemedy);
  const uint64_t count = ReadPatchCount(&reader);
  for (uint64_t p = 0; p < count; ++p) {
    ReadPatch(&reader, p, count, num_photos, world_offset, cloud);
  }
  if (reader.NextContentLine()) {
    reader.Fail(fmt::format("goes on after the {} patches that the file claims", count));
  }
}

template <class T>
void Append(const std::vector<T>& from, std::vector<T>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

void ReadPoints(const fs::path& path, const Eigen::Vector3d& world_offset, PmvsCloud* cloud) {
  const TriangleMesh points = ReadMeshPly(path, world_offset, NotFinite::kRefuse);
  Append(points.vertices, &cloud->points.vertices);
  Append(points.vertex_normals, &cloud->points.vertex_normals);
  Append(points.vertex_colors, &cloud->points.vertex_colors);
}

bool IsPatchFile(const fs::path& path) { return path.extension() == ".patch"; }

// option-0000, as genOption numbers CMVS's clusters.
bool IsCluster(const fs::path& path) {
  const std::string name = path.stem().string();
  constexpr std::string_view kPrefix = "option-";
  return name.starts_with(kPrefix) && name.size() > kPrefix.size() &&
         std::all_of(name.begin() + kPrefix.size(), name.end(),
                     [](unsigned char c) { return std::isdigit(c); });
}

std::vector<fs::path> FilesIn(const fs::path& folder, const std::string& extension) {
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<fs::path> ResultsIn(const fs::path& models) {
  const std::vector<fs::path> patches = FilesIn(models, ".patch");
  return patches.empty() ? FilesIn(models, ".ply") : patches;
}

}  // namespace

bool IsPmvsFolder(const fs::path& path) {
  return fs::is_directory(path / "txt") && fs::is_directory(path / "visualize");
}

bool IsPmvsResult(const fs::path& path) { return IsPatchFile(path) || IsPmvsFolder(path); }

bool HasPmvsFiles(const fs::path& folder) { return !ResultsIn(folder / "models").empty(); }

std::vector<fs::path> PmvsFiles(const fs::path& path) {
  if (!IsPmvsFolder(path)) return {path};
  const fs::path models = path / "models";
  const std::vector<fs::path> files = ResultsIn(models);
  if (files.empty()) {
    throw InputError(models.string(), "holds no points of PMVS (.patch or .ply)",
                     fmt::format("run `pmvs2 {}/ option-all` first", path.string()));
  }
  if (files.size() > 1 && !std::all_of(files.begin(), files.end(), IsCluster)) {
    throw InputError(models.string(),
                     fmt::format("holds several results, such as {} and {}",
                                 files[0].filename().string(), files[1].filename().string()),
                     "give one of the files");
  }
  return files;
}

uint64_t CountPmvsPoints(const fs::path& path) {
  uint64_t count = 0;
  for (const fs::path& file : PmvsFiles(path)) {
    if (IsPatchFile(file)) {
      TextReader reader(file, kRemedy);
      count += ReadPatchCount(&reader);
    } else if (const PlyReader ply(file); const PlyElement* vertex = ply.FindElement("vertex")) {
      count += vertex->count;
    }
  }
  return count;
}

PmvsCloud ReadPmvsCloud(const fs::path& path, const Eigen::Vector3d& world_offset) {
  PmvsCloud cloud;
  cloud.files = PmvsFiles(path);
  const int num_photos =
      IsPmvsFolder(path) ? CountPmvsPhotos(path) : std::numeric_limits<int>::max();
  for (const fs::path& file : cloud.files) {
    if (IsPatchFile(file)) {
      ReadPatches(file, num_photos, world_offset, &cloud);
    } else {
      ReadPoints(file, world_offset, &cloud);
    }
  }
  return cloud;
}

}  // namespace lsmvs
