#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "lsmvs/scene/cloud_sample.h"
#include "lsmvs/scene/depth_map.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/source_rules.h"
#include "lsmvs/scene/visibility_cloud.h"

namespace lsmvs {

// How depth maps are written: exactly, with 16 bytes per pixel, or within a 40th of a pixel's
// size of the depth and a third of a degree of the normal, with 1.2 to 2. Either is read.
enum class MapPrecision { kExact, kCompact };

// Of a cloud.
struct CloudCounts {
  uint64_t num_points = 0;
  uint64_t num_observations = 0;  // (point, view) pairs
};

// The files of one dense workspace, as the pipeline needs them. Whoever knows the formats
// implements this (colmap_adapter does); the stages never see it.
//
// Writers take the paths to write to (Task's staged outputs, of the same file names as the real
// ones) in the order in which the functions that name the files return them.
class WorkspaceFiles {
 public:
  virtual ~WorkspaceFiles() = default;

  // Files of the sparse model: inputs of every stage.
  virtual std::vector<std::filesystem::path> ModelFiles() const = 0;
  // The one that holds the sparse points, for messages.
  virtual std::filesystem::path PointsFile() const = 0;

  // Where neighbours come from if the user says so, one rule per view; none if nothing says so.
  // Throws InputError.
  virtual std::vector<SourceRule> ReadSourceRules(const Scene& /*scene*/) const { return {}; }
  // The file that says so.
  virtual std::filesystem::path SourceRulesFile() const { return {}; }

  // Depth and normal map of a view.
  virtual std::array<std::filesystem::path, 2> DepthMapFiles(const View& view,
                                                             DepthMapKind kind) const = 0;
  // Throws InputError if the view's maps are there but cut off or malformed.
  virtual void CheckDepthMap(const View& view, DepthMapKind kind) const = 0;
  virtual void WriteDepthMap(const View& view, DepthMapKind kind, const DepthMap& map,
                             MapPrecision precision,
                             const std::vector<std::filesystem::path>& outputs) const = 0;
  // `scene` outlives the source.
  virtual std::unique_ptr<DepthMapSource> OpenDepthMaps(const Scene& scene, DepthMapKind kind,
                                                        size_t budget_bytes) const = 0;

  // The workspace's cloud (fused.ply).
  virtual std::filesystem::path CloudFile() const = 0;
  // A cloud's file and that of its visibility.
  virtual std::vector<std::filesystem::path> CloudFiles(
      const std::filesystem::path& cloud) const = 0;
  virtual VisibilityCloud ReadCloud(const std::filesystem::path& cloud,
                                    const Scene& scene) const = 0;
  // Adds the cloud's points to a sample. Throws InputError.
  virtual void SampleCloud(const std::filesystem::path& cloud, const Scene& scene,
                           CloudSampler* sampler) const = 0;
  // `write` hands the cloud over part by part. If it throws, no file appears.
  virtual void WriteCloud(const Scene& scene, const std::vector<std::filesystem::path>& outputs,
                          const std::function<void(const CloudSink&)>& write) const = 0;
  // Where a part of a cloud waits until all are there.
  virtual std::filesystem::path CloudPartFile(const std::filesystem::path& cloud,
                                              int part) const = 0;
  // Joins clouds that WriteCloud wrote: the bytes are those of one cloud with their points in this
  // order. Throws InputError if one is cut off.
  virtual CloudCounts JoinClouds(const Scene& scene,
                                 const std::vector<std::filesystem::path>& parts,
                                 const std::vector<std::filesystem::path>& outputs) const = 0;

  // The file that holds features of the photos that may join the interest points; empty if none.
  virtual std::filesystem::path KeypointFile() const = 0;
  // Their image coordinates, one list per view; none if there is no such file or it is about other
  // photos.
  virtual std::vector<std::vector<Eigen::Vector2f>> ReadKeypoints(const Scene& scene) const = 0;

  // A mesh of the surface stage and the file of what sees its vertices.
  virtual std::vector<std::filesystem::path> VisibleMeshFiles(
      const std::filesystem::path& mesh) const = 0;
  // `view_idxs[begin[v] .. begin[v + 1])` see vertex v.
  virtual void WriteVisibility(const std::vector<uint64_t>& begin,
                               const std::vector<uint32_t>& view_idxs,
                               const std::filesystem::path& output) const = 0;

  // The workspace's meshes.
  virtual std::filesystem::path VisibilityMeshFile() const = 0;
  virtual std::filesystem::path RefinedMeshFile() const = 0;
  // In a folder of its own, beside its pages.
  virtual std::filesystem::path TexturedMeshFile() const = 0;
};

}  // namespace lsmvs
