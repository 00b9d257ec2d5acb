#include "lsmvs/synthetic/workspace.h"

#include <fmt/format.h>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/model/camera_model.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/colmap_adapter/stereo_config.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

// Edges of the truth mesh in multiples of the gsd: a sphere of radius 100 gsd is met to 0.05 gsd.
constexpr double kTruthEdge = 6.0;

SparseModel::Camera ToModelCamera(const PinholeCamera& camera) {
  SparseModel::Camera result;
  result.camera_id = CameraId{1};
  result.model_id = kPinholeModel;
  result.width = static_cast<uint64_t>(camera.width);
  result.height = static_cast<uint64_t>(camera.height);
  result.params = {camera.fx, camera.fy, camera.cx, camera.cy};
  return result;
}

SparseModel::Image ToModelImage(const View& view) {
  SparseModel::Image image;
  image.image_id = view.image_id;
  image.cam_from_world = SparseModel::Pose::FromRigid3(view.cam_from_world);
  image.camera_id = CameraId{1};
  image.name = view.name;
  return image;
}

void WriteStereoConfig(const std::filesystem::path& folder, const Scene& scene) {
  const DenseWorkspace workspace{folder};
  std::vector<PatchMatchProblem> problems;
  std::vector<std::string> names;
  for (const View& view : scene.views) {
    PatchMatchProblem problem;
    problem.reference_name = view.name;
    problems.push_back(problem);
    names.push_back(view.name);
  }
  WritePatchMatchConfig(workspace.PatchMatchConfigPath(), problems);
  WriteFusionConfig(workspace.FusionConfigPath(), names);
  std::filesystem::create_directories(workspace.StereoFolder() / "depth_maps");
  std::filesystem::create_directories(workspace.StereoFolder() / "normal_maps");
}

}  // namespace

SparseModel MakeSparseModel(const Scene& scene) {
  LSMVS_CHECK(!scene.views.empty());
  SparseModel model;
  model.cameras.push_back(ToModelCamera(scene.views.front().camera));
  for (const View& view : scene.views) model.images.push_back(ToModelImage(view));
  for (const SparsePoint& point : scene.points) {
    SparseModel::Point3d point3d;
    point3d.point3d_id = Point3dId{model.points3d.size() + 1};
    point3d.x_in_world = point.x_in_world + scene.world_offset;
    point3d.color = point.color;
    for (const int v : point.view_idxs) {
      const View& view = scene.views[static_cast<size_t>(v)];
      SparseModel::Image& image = model.images[static_cast<size_t>(v)];
      point3d.track.push_back({image.image_id, static_cast<uint32_t>(image.points2d.size())});
      image.points2d.push_back(
          {view.camera.Project(view.cam_from_world * point.x_in_world), point3d.point3d_id});
    }
    model.points3d.push_back(std::move(point3d));
  }
  for (SparseModel::Image& image : model.images) image.num_points2d = image.points2d.size();
  return model;
}

TriangleMesh TruthMesh(const SyntheticScene& scene) {
  TriangleMesh mesh = scene.shape->Mesh(kTruthEdge * scene.gsd);
  const double step_out = 1e-3 * scene.gsd;
  std::vector<Eigen::Vector3i> seen;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3i& face = mesh.faces[f];
    const Eigen::Vector3d middle =
        (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3.0;
    const SurfacePoint on_surface = scene.shape->Closest(middle);
    const Eigen::Vector3d outside = on_surface.position + step_out * on_surface.normal;
    if (scene.shape->SignedDistance(outside) > 0) seen.push_back(face);
  }
  mesh.faces = std::move(seen);
  RemoveUnusedVertices(&mesh);
  return mesh;
}

void WriteTruth(const std::filesystem::path& folder, const SyntheticScene& scene) {
  WriteMeshPly(folder / "gt_mesh.ply", TruthMesh(scene));
  std::string centers;
  for (const View& view : scene.scene.views) {
    const Eigen::Vector3d c = view.CenterInWorld();
    centers += fmt::format("{} {} {} {}\n", view.name, c.x(), c.y(), c.z());
  }
  WriteFileAtomically(folder / "camera_centers.txt", centers);
}

void WriteWorkspace(const std::filesystem::path& folder, WorkspaceFormat format,
                    SyntheticScene* scene, const RunContext& context) {
  WriteTruth(folder, *scene);
  if (format == WorkspaceFormat::kProject) {
    WriteSparseModel(folder / "sparse" / "0", MakeSparseModel(scene->scene));
  } else if (format == WorkspaceFormat::kDense) {
    WriteSparseModel(folder / "sparse", MakeSparseModel(scene->scene));
    WriteStereoConfig(folder, scene->scene);
  }
  WritePhotos(*scene->shape, scene->photo, (folder / "images").string(), &scene->scene, context);
}

}  // namespace lsmvs
