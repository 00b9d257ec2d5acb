#include "lsmvs/report/report_builder.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lsmvs/evaluation/error_colors.h"
#include "lsmvs/evaluation/measure_mesh.h"
#include "lsmvs/evaluation/viewpoints.h"
#include "lsmvs/exporting/texture_transfer.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/texturing/vertex_colors.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

constexpr int kPhotoQuality = 82;
constexpr double kMaxTexels = 6e6;  // of a texture on the page

// Sets what meshes and clouds have in common.
template <class Entry>
void SetSource(const ReportSource& source, Entry* entry) {
  entry->title = source.title;
  entry->origin = source.origin;
  entry->file = source.path.filename().string();
  entry->file_bytes = source.file_bytes;
  entry->figures.name = entry->file;
}

const ReportOptions& Valid(const ReportOptions& options) {
  RequireValid(options);
  return options;
}

}  // namespace

void ReportOptions::Describe(OptionSet* options) {
  options->Add("max_num_faces", &max_num_faces,
               "Faces of each mesh on the page; larger meshes are simplified for it.",
               {100, 5000000});
  options->Add("max_num_photos", &max_num_photos, "Photos on the page.", {0, 100000});
  options->Add("max_photo_size", &max_photo_size, "Longer side of the photos on the page, pixels.",
               {16, 16384});
  options->Add("picture_width", &picture_width, "Width of the pictures beside the page, pixels.",
               {16, 16384});
  surface.Describe(options);
  depth.Describe(options);
  photo.Describe(options);
}

bool ReportOptions::Check(std::string* error) const {
  return surface.Check(error) && photo.Check(error) && CheckOptions(*this, error);
}

ReportBuilder::ReportBuilder(const Scene& scene, const ReportOptions& options,
                             const fs::path& folder, const RunContext& context)
    : scene_(scene),
      options_(Valid(options)),
      folder_(folder),
      context_(context),
      images_(MakeImageStore(scene, {})),
      key_photo_(MostRevealingView(scene)) {
  report_.error_caption = "1 - correlation of the photos|0|1";
}

void ReportBuilder::SetTruth(const TriangleMesh& truth) {
  evaluator_ = std::make_unique<SurfaceEvaluator>(truth, scene_.views, options_.surface, context_);
}

void ReportBuilder::AddCloud(const TriangleMesh& points, const std::vector<int>& num_views,
                             const std::vector<float>& scores, const ReportSource& source) {
  ReportCloud entry;
  SetSource(source, &entry);
  entry.figures.cloud = MeasureCloud(points.vertices, num_views, scores, scene_.views, context_);
  if (evaluator_) entry.figures.surface = evaluator_->Evaluate(points, context_);
  report_.clouds.push_back(std::move(entry));
}

void ReportBuilder::AddMesh(const TexturedMesh& textured, const ReportSource& source) {
  ReportMesh entry;
  SetSource(source, &entry);
  const MeshTracer tracer(textured.mesh, context_);
  std::optional<TexturePages> texture;
  if (textured.has_texture()) texture.emplace(textured, context_.memory_budget_bytes / 4);
  const TexturePages* pages = texture ? &*texture : nullptr;
  Measure(textured, pages, tracer, &entry);
  Simplify(textured, pages, tracer, &entry);
  entry.picture = source.path.stem().string() + ".png";
  WritePictures(textured.mesh, tracer, pages, entry);
  report_.meshes.push_back(std::move(entry));
}

void ReportBuilder::Measure(const TexturedMesh& textured, const TexturePages* pages,
                            const MeshTracer& tracer, ReportMesh* entry) {
  const TriangleMesh& mesh = textured.mesh;
  MeshFigures& figures = entry->figures;
  figures.inspection = Inspect(mesh);
  figures.silhouettes = MeasureSilhouettes(tracer, mesh, scene_.views, context_.Part(0, 0.05));
  if (evaluator_) {
    MeasureAgainstTruth(*evaluator_, mesh, &tracer, scene_.views, options_.depth,
                        context_.Part(0.05, 0.3), &figures);
  }
  figures.photometric =
      MeasurePhotometricScore(tracer, mesh, scene_, *images_, options_.view_idxs,
                              evaluator_ == nullptr, options_.photo, context_.Part(0.3, 0.5));
  if (pages == nullptr && mesh.vertex_colors.empty()) return;
  TextureScoreOptions coloring;
  coloring.level = options_.photo.level;
  MeasureColors(tracer, mesh, pages, scene_, *images_, options_.view_idxs, coloring,
                context_.Part(0.5, 0.6), &figures);
}

// What is drawn on the page.
void ReportBuilder::Simplify(const TexturedMesh& textured, const TexturePages* pages,
                             const MeshTracer& tracer, ReportMesh* entry) {
  const SimplifiedMesh simplified = SimplifyMesh(
      textured.mesh, static_cast<size_t>(options_.max_num_faces), context_.Part(0.6, 0.75));
  entry->errors = Errors(simplified, entry->figures);
  entry->figures.photometric->vertex_zncc = {};
  entry->shown = simplified.mesh;
  if (pages != nullptr) {
    ShowTexture(*pages, tracer, entry);
  } else if (entry->shown.vertex_colors.empty()) {
    ColorFromPhotos(entry);
  }
}

// The texture on the simplified mesh, on one page.
void ReportBuilder::ShowTexture(const TexturePages& pages, const MeshTracer& tracer,
                                ReportMesh* entry) const {
  TransferredTexture texture =
      TransferTexture(pages, tracer, entry->shown, kMaxTexels, context_.Part(0.75, 0.8));
  entry->texcoords = std::move(texture.texcoords);
  entry->texture_size = {texture.page.width, texture.page.height};
  entry->texture_jpeg = EncodeJpeg(texture.page, kPhotoQuality);
  entry->shown.vertex_colors.clear();
}

// COLMAP's Delaunay mesher writes no colours; the page shows all meshes alike.
void ReportBuilder::ColorFromPhotos(ReportMesh* entry) {
  VertexColorOptions coloring;
  coloring.level = 1;
  entry->shown.vertex_colors =
      ColorVertices(scene_, *images_, entry->shown, coloring, context_.Part(0.75, 0.8));
  report_.notes.push_back(entry->file + " has no colours; the page takes them from the photos.");
}

// In [0, 1], a vertex of the simplified mesh each.
std::vector<float> ReportBuilder::Errors(const SimplifiedMesh& simplified,
                                         const MeshFigures& figures) {
  std::vector<float> errors(simplified.mesh.vertices.size());
  if (!evaluator_) {
    const std::vector<float>& zncc = figures.photometric->vertex_zncc;
    for (size_t v = 0; v < errors.size(); ++v) errors[v] = 1 - zncc[simplified.source_vertex[v]];
    return errors;
  }
  const SurfaceEvaluation& surface = *figures.surface;
  const double largest = surface.thresholds.back() * surface.unit_in_world;
  report_.error_caption =
      fmt::format("Distance to the ground truth|0|{:g}{}", surface.thresholds.back(),
                  surface.gsd == surface.unit_in_world ? " GSD" : "");
  const std::vector<double> distances =
      DistancesToTruth(*evaluator_, simplified.mesh.vertices, context_);
  std::transform(distances.begin(), distances.end(), errors.begin(),
                 [&](double distance) { return static_cast<float>(distance / largest); });
  return errors;
}

void ReportBuilder::WritePictures(const TriangleMesh& mesh, const MeshTracer& tracer,
                                  const TexturePages* pages, const ReportMesh& entry) const {
  const PosedCamera viewpoint = ViewpointOf(scene_.views[key_photo_], options_.picture_width);
  const std::string stem = fs::path(entry.picture).stem().string();
  RenderOptions render;
  render.antialiasing = 2;
  WritePng(folder_ / entry.picture,
           RenderMesh(mesh, tracer, viewpoint, render, context_.Part(0.8, 0.9)));
  if (pages != nullptr) {
    render.style = RenderStyle::kColor;
    WritePng(folder_ / (stem + "-texture.png"),
             RenderMesh(mesh, tracer, viewpoint, render, context_.Part(0.8, 0.9), pages));
  }
  TriangleMesh colored = entry.shown;
  colored.vertex_colors =
      ErrorColors(std::vector<double>(entry.errors.begin(), entry.errors.end()), 1);
  render.style = RenderStyle::kLit;
  WritePng(folder_ / (stem + "-errors.png"), RenderMesh(colored, MeshTracer(colored, context_),
                                                        viewpoint, render, context_.Part(0.9, 1)));
}

// Poses of all photos, by name; pictures of as many as are wanted, evenly spread.
void ReportBuilder::AddViews() {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : CentralVertices(report_.meshes.front().shown, scene_)) {
    box.extend(x);
  }
  report_.focus = box.center();
  report_.radius = std::max(0.5 * box.diagonal().norm(), 1e-9);
  report_.up = UpDirection(scene_.views);
  const std::vector<int> order = ViewsByName(scene_.views);
  const size_t wanted = std::min(order.size(), static_cast<size_t>(options_.max_num_photos));
  for (size_t i = 0; i < order.size(); ++i) {
    const View& view = scene_.views[order[i]];
    ReportPhoto photo{view.name, {view.camera, view.cam_from_world}, {}};
    const bool chosen = (i + 1) * wanted / order.size() > i * wanted / order.size();
    if (order[i] == key_photo_) report_.key_photo = static_cast<int>(i);
    if (chosen || order[i] == key_photo_) photo.jpeg = SmallPhoto(order[i]);
    report_.photos.push_back(std::move(photo));
  }
  if (wanted < order.size()) {
    report_.notes.push_back(fmt::format(
        "The page holds {} of {} photos; the others have poses only.", wanted, order.size()));
  }
}

std::vector<uint8_t> ReportBuilder::SmallPhoto(int view_idx) const {
  const auto image = images_->Colors(view_idx, 0);
  const double scale = std::min(
      1.0, static_cast<double>(options_.max_photo_size) / std::max(image->width, image->height));
  const auto reduced = [&](int size) {
    return std::max(1, static_cast<int>(std::lround(scale * size)));
  };
  return EncodeJpeg(ResizeColors(*image, reduced(image->width), reduced(image->height)),
                    kPhotoQuality);
}

}  // namespace lsmvs
