// Speed of the refinement's kernels beside their floors, and of the two optimisers.
//
// Correlation: per pixel 10 box filters of 2 x (2 radius + 1) additions and about 60 further
// operations; 16 bytes come in and 16 go out. Warp: per pixel about 70 operations and 8 gathered
// floats. Rasteriser: per face about 100 operations, per covered pixel 4 and 8 bytes. "ops" is that
// count a second; the floor is what BM_FloorOfAdditions and BM_FloorOfBytes reach on this machine.
// README.md has the counts of a whole step.

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "lsmvs/image/rasterizer.h"
#include "lsmvs/refinement/mesh_refiner.h"
#include "lsmvs/refinement/photo/surface_warp.h"
#include "lsmvs/refinement/photo/window_correlation.h"
#include "lsmvs/synthetic/surface_error.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

constexpr int kTile = 140;  // a tile of 128 with the margins of its windows

benchmark::Counter Rate(double count) {
  return benchmark::Counter(count, benchmark::Counter::kIsRate);
}

void BM_FloorOfAdditions(benchmark::State& state) {
  std::vector<float> a(4096, 1.0f), b(4096, 1e-6f);
  for (auto _ : state) {
    for (int pass = 0; pass < 16; ++pass) {
      for (size_t k = 0; k < a.size(); ++k) a[k] += b[k];
      benchmark::DoNotOptimize(a.data());
    }
  }
  state.counters["ops"] = Rate(16.0 * 4096 * static_cast<double>(state.iterations()));
}
BENCHMARK(BM_FloorOfAdditions);

void BM_FloorOfBytes(benchmark::State& state) {
  std::vector<float> from(1 << 23, 1.0f), to(1 << 23);
  for (auto _ : state) {
    std::copy(from.begin(), from.end(), to.begin());
    benchmark::DoNotOptimize(to.data());
  }
  state.SetBytesProcessed(state.iterations() * 8 * (1 << 23));
}
BENCHMARK(BM_FloorOfBytes);

void BM_CorrelateWindows(benchmark::State& state) {
  const int radius = static_cast<int>(state.range(0));
  CorrelationTile tile;
  tile.Resize(kTile, kTile);
  for (size_t k = 0; k < tile.reference.size(); ++k) {
    tile.reference[k] = static_cast<float>(128 + 60 * std::sin(0.37 * static_cast<double>(k)));
    tile.warped[k] = static_cast<float>(128 + 60 * std::sin(0.37 * static_cast<double>(k) + 0.3));
    tile.valid[k] = tile.weight[k] = 1;
  }
  CorrelationScratch scratch;
  CorrelationOptions options;
  options.radius = radius;
  tile.FindSpans(radius);
  for (auto _ : state) {
    CorrelateWindows(options, &scratch, &tile);
    benchmark::DoNotOptimize(tile.derivative.data());
  }
  const double pixels = kTile * kTile * static_cast<double>(state.iterations());
  state.counters["pixels"] = Rate(pixels);
  state.counters["ops"] = Rate(pixels * (10 * 2 * (2 * radius + 1) + 60));
}
BENCHMARK(BM_CorrelateWindows)->Arg(2)->Arg(3)->Arg(5);

// Photos of a sphere, its mesh with noise, and what the kernels need of them.
struct BenchScene {
  BenchScene() : s(MakeScene(ShapeName::kSphere, 8, 640, 480)) {
    WritePhotos(*s.shape, s.photo, folder.path().string(), &s.scene, RunContext());
    images = MakeImageStore(s.scene, ImageStoreOptions());
    mesh = s.shape->Mesh(4 * s.gsd);
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0, s.gsd);
    const auto normals = ComputeVertexNormals(mesh);
    for (size_t v = 0; v < mesh.vertices.size(); ++v) {
      mesh.vertices[v] += noise(random) * normals[v].cast<double>();
    }
  }
  TemporaryFolder folder;
  SyntheticScene s;
  std::unique_ptr<ImageStore> images;
  TriangleMesh mesh;
};

const BenchScene& Scene8() {
  static const BenchScene scene;
  return scene;
}

void BM_RasterizeMesh(benchmark::State& state) {
  const BenchScene& scene = Scene8();
  const View& view = scene.s.scene.views[0];
  SurfaceMaps maps;
  for (auto _ : state) {
    RasterizeMesh(view.camera, view.cam_from_world, scene.mesh.vertices, scene.mesh.faces, {},
                  &maps);
    benchmark::DoNotOptimize(maps.depth.pixels.data());
  }
  const double count = static_cast<double>(state.iterations());
  const double faces = static_cast<double>(scene.mesh.faces.size()), pixels = 640.0 * 480.0;
  state.counters["faces"] = Rate(faces * count);
  state.counters["ops"] = Rate((100 * faces + 4 * pixels) * count);
  state.SetBytesProcessed(static_cast<int64_t>(8 * pixels * count));
}
BENCHMARK(BM_RasterizeMesh);

void BM_WarpRow(benchmark::State& state) {
  const BenchScene& scene = Scene8();
  const std::vector<View>& views = scene.s.scene.views;
  SurfaceMaps maps[2];
  for (size_t v = 0; v < 2; ++v) {
    RasterizeMesh(views[v].camera, views[v].cam_from_world, scene.mesh.vertices, scene.mesh.faces,
                  {}, &maps[v]);
  }
  const InverseDepthTransfer pair = MakeInverseDepthTransfer(
      {views[1].camera, views[1].cam_from_world}, {views[0].camera, views[0].cam_from_world});
  const auto gray = scene.images->Gray(1, 0);
  std::vector<float> warped(640), derivative(640), valid(640);
  for (auto _ : state) {
    for (int row = 120; row < 360; ++row) {
      WarpRow(pair, *gray, maps[1].depth, 0.01f, row, 0, 640, maps[0].depth.Row(row),
              {warped.data(), derivative.data(), valid.data()});
    }
    benchmark::DoNotOptimize(warped.data());
  }
  const double pixels = 240 * 640 * static_cast<double>(state.iterations());
  state.counters["pixels"] = Rate(pixels);
  state.counters["ops"] = Rate(70 * pixels);
}
BENCHMARK(BM_WarpRow);

// The whole stage: time, and how far the surface is from the truth afterwards (pixels).
void BM_RefineMesh(benchmark::State& state) {
  const BenchScene& scene = Scene8();
  MeshRefinerOptions options;
  options.optimizer = static_cast<RefinementOptimizer>(state.range(0));
  options.max_num_iterations = static_cast<int>(state.range(1));
  options.color_vertices = false;
  options.simplify_tolerance = 0;
  RefinementResult result;
  for (auto _ : state) {
    result = RefineMesh(scene.s.scene, *scene.images, scene.mesh, options, RunContext(1));
  }
  double sum = 0;
  int count = 0;
  for (const Eigen::Vector3d& x : result.mesh.vertices) {
    if (x.z() < -0.3) continue;  // not seen
    sum += std::abs(scene.s.shape->SignedDistance(x)) / scene.s.gsd;
    ++count;
  }
  state.counters["error_px"] = sum / count;
  state.counters["energy"] = result.levels.back().energies.back();
  state.SetLabel(state.range(0) == 0 ? "gauss_newton" : "lbfgs");
}
BENCHMARK(BM_RefineMesh)
    ->Args({0, 8})
    ->Args({1, 8})
    ->Args({1, 30})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lsmvs

BENCHMARK_MAIN();
