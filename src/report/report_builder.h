#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lsmvs/evaluation/depth_errors.h"
#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/evaluation/photometric_score.h"
#include "lsmvs/evaluation/surface_evaluator.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/simplify.h"
#include "lsmvs/mesh/texture_pages.h"
#include "lsmvs/mesh/textured_mesh.h"
#include "lsmvs/report/report.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/option_set.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

struct ReportOptions {
  // Photos that the photometric score is measured on; empty: all.
  std::vector<int> view_idxs;
  // Faces of each mesh on the page; larger meshes are simplified for it, not for the figures.
  int max_num_faces = 200000;
  // Photos on the page; the poses of the others are there without picture.
  int max_num_photos = 40;
  // Longer side of the photos on the page, in pixels.
  int max_photo_size = 960;
  // Width of the pictures beside the page, in pixels.
  int picture_width = 1280;
  SurfaceEvaluationOptions surface;
  DepthErrorOptions depth;
  PhotometricOptions photo;

  // All but view_idxs.
  void Describe(OptionSet* options);
  bool Check(std::string* error) const;
};

// Where a mesh or cloud of the comparison comes from.
struct ReportSource {
  std::filesystem::path path;
  std::string title, origin;  // as of ReportMesh
  uint64_t file_bytes = 0;
};

// Measures meshes and clouds of a scene one after the other, draws them, and puts them into a
// report. Each mesh is held only while it is added.
class ReportBuilder {
 public:
  // `scene` outlives the builder. Pictures are written to `folder`. Throws UsageError for options
  // out of range.
  ReportBuilder(const Scene& scene, const ReportOptions& options,
                const std::filesystem::path& folder, const RunContext& context);

  // A true mesh or cloud, for what is added afterwards; without it the photos alone judge.
  void SetTruth(const TriangleMesh& truth);
  void AddMesh(const TexturedMesh& textured, const ReportSource& source);
  // Points without faces. `num_views` and `scores` per point, or empty, as of PmvsCloud.
  void AddCloud(const TriangleMesh& points, const std::vector<int>& num_views,
                const std::vector<float>& scores, const ReportSource& source);
  // After the meshes, of which there is one at least: where the page looks, and the photos.
  void AddViews();

  Report& report() { return report_; }

 private:
  void Measure(const TexturedMesh& textured, const TexturePages* pages, const MeshTracer& tracer,
               ReportMesh* entry);
  void Simplify(const TexturedMesh& textured, const TexturePages* pages, const MeshTracer& tracer,
                ReportMesh* entry);
  void ShowTexture(const TexturePages& pages, const MeshTracer& tracer, ReportMesh* entry) const;
  void ColorFromPhotos(ReportMesh* entry);
  std::vector<float> Errors(const SimplifiedMesh& simplified, const MeshFigures& figures);
  void WritePictures(const TriangleMesh& mesh, const MeshTracer& tracer, const TexturePages* pages,
                     const ReportMesh& entry) const;
  std::vector<uint8_t> SmallPhoto(int view_idx) const;

  const Scene& scene_;
  const ReportOptions options_;
  const std::filesystem::path folder_;
  const RunContext context_;
  const std::unique_ptr<ImageStore> images_;
  const int key_photo_;  // -1 without photos
  std::unique_ptr<SurfaceEvaluator> evaluator_;
  Report report_;
};

}  // namespace lsmvs
