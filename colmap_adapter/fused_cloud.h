#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"
#include "lsmvs/util/atomic_file.h"

namespace lsmvs {

struct FusedCloud {
  VisibilityCloud cloud;
  // Points that were left out because their position is not finite.
  size_t num_dropped = 0;
  // Empty, or what the user should know: the file's images were in another order than expected,
  // points were dropped.
  std::string message;
};

// What the headers of a cloud and of its visibility tell.
struct FusedCloudSize {
  uint64_t num_points = 0;
  uint64_t num_view_entries = 0;  // (point, view) pairs
};

// Without reading the points. Throws InputError where ReadFusedCloud does for what a header shows.
FusedCloudSize ReadFusedCloudSize(const std::filesystem::path& ply_path);

// Reads fused.ply in any dialect of PLY, and <ply_path>.vis. Normals and colours may be missing
// (zero then). scene.world_offset is subtracted.
//
// The indices of .vis are positions in a list of images that depends on the version of COLMAP and
// on the model it read. A sample of points is projected into the images claimed: if another order
// (of the files in `workspace`, of the image ids, of the names) fits clearly better than scene's,
// that one is taken and `message` says so; if most fall outside in any order, the file is refused.
//
// Throws InputError if a file is missing, truncated or malformed, if the two have different numbers
// of points (a cropped fused.ply), or if an index is not below the number of images. 10 M points
// take a few seconds; memory is that of the cloud that is returned.
FusedCloud ReadFusedCloud(const std::filesystem::path& ply_path, const Scene& scene,
                          const DenseWorkspace& workspace);

struct AppendedCloud {
  size_t num_dropped = 0;  // as FusedCloud
  std::string message;
};

// The same behind the points of `cloud`, point by point: beside it nothing is held. The views of
// `scene` are numbered from `first_view` on. If it throws, `cloud` is of no use any more.
AppendedCloud AppendFusedCloud(const std::filesystem::path& ply_path, const Scene& scene,
                               const DenseWorkspace& workspace, uint32_t first_view,
                               VisibilityCloud* cloud);

// Hands over the points of a cloud one after the other, without holding them: position (the
// scene's world_offset subtracted), normal, and views as the file numbers them, which may not be
// those of the scene. Throws what ReadFusedCloud throws for malformed files.
using FusedPointVisitor =
    std::function<void(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                       std::span<const uint32_t> views)>;
void VisitFusedCloud(const std::filesystem::path& ply_path, const Eigen::Vector3d& world_offset,
                     const FusedPointVisitor& visit);

// Writes fused.ply and fused.ply.vis as COLMAP does (binary little endian: float x y z nx ny nz,
// uchar red green blue), with double coordinates if scene.world_offset is not zero, part by part: a
// cloud need not fit into memory. Commit() lets both appear, complete: a cloud that stood there is
// removed before its visibility is replaced, so that a kill never leaves two that do not belong
// together. Without it nothing has happened. Failures throw FileSystemError.
class FusedCloudWriter {
 public:
  // `scene` outlives the writer. `num_points`: of the whole cloud, if it is known beforehand; else
  // a comment in the header leaves room for its digits.
  FusedCloudWriter(const std::filesystem::path& ply_path, const Scene& scene,
                   std::optional<uint64_t> num_points = std::nullopt);

  void Add(const VisibilityCloud& part);
  // Adds a cloud that this class wrote for the same scene, with its number of points unknown
  // beforehand, and the bytes that it has there. Throws InputError if it is cut off.
  void AddFile(const std::filesystem::path& ply_path);
  void Commit();
  // So far.
  const FusedCloudSize& size() const { return size_; }

 private:
  const std::filesystem::path ply_path_;
  const Scene& scene_;
  const bool count_is_known_;
  AtomicFile ply_, vis_;
  FusedCloudSize size_;
};

// The same for a cloud in memory.
void WriteFusedCloud(const std::filesystem::path& ply_path, const VisibilityCloud& cloud,
                     const Scene& scene);

// What sees each point of a cloud, or each vertex of a mesh: views[begin[p] .. begin[p + 1]).
struct PointViews {
  std::vector<uint64_t> begin;
  std::vector<uint32_t> view_idxs;
};

// Reads a file as WriteVisibility() writes it. Throws InputError if it is cut off or malformed, or
// about another number of points.
PointViews ReadVisibility(const std::filesystem::path& vis_path, size_t num_points);

// Writes the views of each point, or of each vertex of a mesh, in the format of fused.ply.vis:
// views[begin[p] .. begin[p + 1]) see p. Atomic.
void WriteVisibility(const std::filesystem::path& vis_path, const std::vector<uint64_t>& begin,
                     const std::vector<uint32_t>& view_idxs);

}  // namespace lsmvs
