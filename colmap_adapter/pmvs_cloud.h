#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "lsmvs/mesh/triangle_mesh.h"

namespace lsmvs {

// The points of PMVS-2 (Furukawa and Ponce, "Accurate, dense, and robust multi-view stereopsis",
// PAMI 2010), as it writes them into models/: NAME.patch, the patches with all that it knows about
// them, and NAME.ply, their centres with normals and colours.
struct PmvsCloud {
  std::vector<std::filesystem::path> files;  // that it was read from
  // Points without faces, with outward normals; with colours if they come from a .ply.
  TriangleMesh points;
  // Per point the mean correlation of the photos in its window, at most 1; empty if from a .ply.
  std::vector<float> scores;
  // Per point the number of photos that see it; empty if from a .ply.
  std::vector<int> num_views;
};

// Whether `path` is a folder that `colmap image_undistorter --output_type PMVS` prepared (pmvs/,
// with txt/ and visualize/). Looks at the disk.
bool IsPmvsFolder(const std::filesystem::path& path);
// The same, or a file whose name ends in .patch.
bool IsPmvsResult(const std::filesystem::path& path);

// Whether models/ of such a folder holds results.
bool HasPmvsFiles(const std::filesystem::path& folder);

// The files of points that `path` stands for. Of a folder all of models/: the .patch files or, if
// there are none, the .ply files; several are joined if they are those of CMVS's clusters
// (option-0000, option-0001, ...). Throws InputError if there are none, or several others.
std::vector<std::filesystem::path> PmvsFiles(const std::filesystem::path& path);

// Number of points, from the headers of the files. Throws InputError.
uint64_t CountPmvsPoints(const std::filesystem::path& path);

// Reads a .patch file, or the results in a folder. `world_offset` is subtracted. Photos are
// numbered as in visualize/; in a folder their numbers are checked against it. Throws InputError
// with file and line if a file is missing, cut off or malformed, has more or fewer patches than it
// claims, or holds numbers that are not finite.
PmvsCloud ReadPmvsCloud(const std::filesystem::path& path,
                        const Eigen::Vector3d& world_offset = Eigen::Vector3d::Zero());

}  // namespace lsmvs
