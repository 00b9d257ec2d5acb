#include "lsmvs/texturing/vertex_colors.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>

#include "lsmvs/image/rasterizer.h"
#include "lsmvs/image/sampling.h"
#include "lsmvs/mesh/vertex_rings.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/ordered_merge.h"

namespace lsmvs {

namespace {

constexpr size_t kVerticesPerBlock = 16384;
constexpr double kMinCosine = 0.1;
// Samples further from the median (grey levels a component) are of something else: a shadow, a
// highlight, a passer-by.
constexpr int kMaxDeviation = 24;

struct Sample {
  float weight = 0;
  Color color = Color::Zero();
};

// The best samples of each vertex.
class SampleTable {
 public:
  SampleTable(size_t num_vertices, int per_vertex)
      : per_vertex_(static_cast<size_t>(per_vertex)), samples_(num_vertices * per_vertex_) {}

  // Keeps the heaviest, the earlier of equally heavy ones.
  void Add(size_t vertex, Sample sample) {
    Sample* begin = &samples_[vertex * per_vertex_];
    for (size_t k = 0; k < per_vertex_ && sample.weight > 0; ++k) {
      if (sample.weight > begin[k].weight) std::swap(sample, begin[k]);
    }
  }

  bool Empty(size_t vertex) const { return samples_[vertex * per_vertex_].weight == 0; }

  Color RobustMean(size_t vertex) const {
    const Sample* begin = &samples_[vertex * per_vertex_];
    size_t count = 0;
    while (count < per_vertex_ && begin[count].weight > 0) ++count;
    Color median;
    for (int c = 0; c < 3; ++c) median[c] = Median(begin, count, c);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float total = 0;
    for (size_t k = 0; k < count; ++k) {
      const auto difference = begin[k].color.cast<int>() - median.cast<int>();
      if (difference.cwiseAbs().maxCoeff() > kMaxDeviation) continue;
      sum += begin[k].weight * begin[k].color.cast<float>();
      total += begin[k].weight;
    }
    if (total == 0) return median;
    return (sum / total).array().round().cast<uint8_t>().matrix();
  }

 private:
  // Lower median.
  static uint8_t Median(const Sample* begin, size_t count, int component) {
    std::vector<uint8_t> values;
    for (size_t k = 0; k < count; ++k) values.push_back(begin[k].color[component]);
    std::sort(values.begin(), values.end());
    return values[(count - 1) / 2];
  }

  size_t per_vertex_;
  std::vector<Sample> samples_;
};

// What one view says about the vertices that it sees.
struct ViewSamples {
  std::vector<int32_t> vertices;
  std::vector<Sample> samples;
};

// Whether the surface in front of a vertex is nearer than tolerated, in all pixels around: a vertex
// on an edge is seen.
bool Hidden(const Raster<float>& depth, const Eigen::Vector2d& x_px, double z, double tolerance) {
  const int column = static_cast<int>(std::floor(x_px.x() - 0.5));
  const int row = static_cast<int>(std::floor(x_px.y() - 0.5));
  for (int k = 0; k < 4; ++k) {
    const int c = std::clamp(column + k % 2, 0, depth.width - 1);
    const int r = std::clamp(row + k / 2, 0, depth.height - 1);
    if (depth(c, r) >= z * (1 - tolerance)) return false;
  }
  return true;
}

ViewSamples SampleView(const View& view, const ImageStore& images, int view_idx,
                       const TriangleMesh& mesh, const FaceBlocks& blocks,
                       const std::vector<Eigen::Vector3f>& normals,
                       const VertexColorOptions& options) {
  const PinholeCamera camera = images.Camera(view_idx, options.level);
  SurfaceMaps maps;
  RasterizeMesh(camera, view.cam_from_world, mesh.vertices, mesh.faces, {.blocks = &blocks}, &maps);
  const auto colors = images.Colors(view_idx, options.level);
  const auto mask = images.Mask(view_idx, options.level);
  ViewSamples result;
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3d x = view.cam_from_world * mesh.vertices[v];
    if (x.z() <= 0) continue;
    const Eigen::Vector2d x_px = camera.Project(x);
    if (!camera.Contains(x_px)) continue;
    const Eigen::Vector3d normal = view.cam_from_world.rotation * normals[v].cast<double>();
    const double cosine = -normal.dot(x) / x.norm();
    if (cosine < kMinCosine || Hidden(maps.depth, x_px, x.z(), options.depth_tolerance)) continue;
    if (mask && (*mask)(static_cast<int>(x_px.x()), static_cast<int>(x_px.y())) == 0) continue;
    const double pixels_per_length = camera.MeanFocalLength() / x.z();
    result.vertices.push_back(static_cast<int32_t>(v));
    // Relative to the photo's resolution, so that the weight is a number of ordinary size in any
    // unit.
    result.samples.push_back({static_cast<float>(cosine * pixels_per_length * pixels_per_length),
                              RoundColor(SampleColors(*colors, x_px.x(), x_px.y()))});
  }
  return result;
}

// Colours the rest from its coloured neighbours, ring by ring.
void Spread(const TriangleMesh& mesh, std::vector<uint8_t>* colored, std::vector<Color>* colors) {
  const VertexRings rings = BuildVertexRings(mesh);
  std::vector<size_t> ring, next;
  for (size_t v = 0; v < colored->size(); ++v) {
    if (!(*colored)[v]) ring.push_back(v);
  }
  for (bool any = true; any && !ring.empty();) {
    any = false;
    next.clear();
    std::vector<std::pair<size_t, Color>> found;
    for (const size_t v : ring) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      int count = 0;
      for (auto k = rings.begin[v]; k < rings.begin[v + 1]; ++k) {
        const size_t j = static_cast<size_t>(rings.neighbors[static_cast<size_t>(k)]);
        if (!(*colored)[j]) continue;
        sum += (*colors)[j].cast<float>();
        ++count;
      }
      if (count == 0) {
        next.push_back(v);
      } else {
        found.emplace_back(
            v, (sum / static_cast<float>(count)).array().round().cast<uint8_t>().matrix());
      }
    }
    for (const auto& [v, color] : found) {
      (*colors)[v] = color;
      (*colored)[v] = 1;
      any = true;
    }
    ring.swap(next);
  }
}

}  // namespace

void VertexColorOptions::Describe(OptionSet* options) {
  options->Add("VertexColors.level", &level,
               "Pyramid level of the photos; 1 is half the resolution.", {0, 8});
  options->Add("VertexColors.depth_tolerance", &depth_tolerance,
               "A vertex is hidden if the surface is nearer by more than this part of its depth.",
               {1e-6, 1.0});
  options->Add("VertexColors.max_views", &max_views_per_vertex,
               "Best views that vote for the colour of a vertex.", {1, 64});
}

std::vector<Color> ColorVertices(const Scene& scene, const ImageStore& images,
                                 const TriangleMesh& mesh, const VertexColorOptions& options,
                                 const RunContext& context) {
  std::string error;
  LSMVS_CHECK(options.Check(&error));
  const std::vector<Eigen::Vector3f> normals = ComputeVertexNormals(mesh);
  const FaceBlocks blocks(mesh.vertices, mesh.faces, context);
  SampleTable table(mesh.vertices.size(), options.max_views_per_vertex);
  OrderedMerge<ViewSamples> merge([&](size_t, ViewSamples&& view) {
    for (size_t k = 0; k < view.vertices.size(); ++k) {
      table.Add(static_cast<size_t>(view.vertices[k]), view.samples[k]);
    }
  });
  // Handed out in order, whatever block a thread takes: no result waits long for those before it.
  std::atomic<size_t> next = 0;
  ParallelFor(context, scene.views.size(), 1, [&](size_t) {
    const size_t v = next++;
    merge.Add(
        v, SampleView(scene.views[v], images, static_cast<int>(v), mesh, blocks, normals, options));
  });
  std::vector<Color> colors(mesh.vertices.size(), Color::Constant(128));
  std::vector<uint8_t> colored(mesh.vertices.size(), 0);
  ParallelFor(context, colors.size(), kVerticesPerBlock, [&](size_t v) {
    if (table.Empty(v)) return;
    colors[v] = table.RobustMean(v);
    colored[v] = 1;
  });
  Spread(mesh, &colored, &colors);
  return colors;
}

}  // namespace lsmvs
