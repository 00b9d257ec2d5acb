// Speed of the surface stage's phases on a sphere of state.range(0) points with 16 views. Items are
// vertices inserted, facets crossed and cells cut: the floor of a phase is their number times the
// time of one, with everything in the cache (2.3 GHz, AVX2):
//   insertion  about 20 sphere and 8 orientation tests of 25 ns, 27 cells of 64 bytes: 0.8 us a
//              vertex; 5.6 us at 50,000 and 9 us at a million are measured, as cells lie anywhere
//   rays       40 to 50 crossings a vertex of 25 ns: 1.1 us; 7.6 us are measured, of which 3 step;
//              the rest sets off, forwards and backwards, and sorts the rays by view
//   cut        6.7 cells a vertex, read and written once, 64 bytes: 0.1 us; 5.3 us are measured

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "lsmvs/graph/minimum_cut.h"
#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/tetrahedralization.h"
#include "lsmvs/surface/visibility_mesher.h"
#include "lsmvs/surface/visibility_weights.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/synthetic_scene.h"

namespace lsmvs {
namespace {

const RunContext kContext(1);
const VisibilityWeightOptions kWeights{
    .distance_sigma_factor = 0.8, .sink_distance_factor = 0.5, .quality_regularization = 0.7};

struct BenchCloud {
  // `noise` in units of the mean distance between points.
  explicit BenchCloud(int64_t num_points, double noise = 0)
      : scene(MakeScene(ShapeName::kSphere, 16, 1280, 960)) {
    SampledCloudOptions sampling;
    sampling.num_points = static_cast<size_t>(num_points);
    sampling.noise = noise * std::sqrt(4 * std::numbers::pi / static_cast<double>(num_points));
    cloud = SampleCloud(*scene.shape, scene.scene, sampling, kContext);
  }
  MergedCloud Merge() const {
    const PointMergingOptions options{
        .max_proj_dist = 0.1, .max_depth_dist = 0.01, .visibility_sigma = 3};
    return MergePoints(scene.scene, cloud, options, kContext);
  }
  SyntheticScene scene;
  VisibilityCloud cloud;
};

void BM_Merging(benchmark::State& state) {
  const BenchCloud bench(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(bench.Merge());
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_Merging)->Arg(50000)->Arg(200000)->Unit(benchmark::kMillisecond);

void BM_Insertion(benchmark::State& state) {
  const MergedCloud merged = BenchCloud(state.range(0)).Merge();
  for (auto _ : state) benchmark::DoNotOptimize(BuildDelaunay(merged.positions));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(merged.positions.size()));
}
BENCHMARK(BM_Insertion)->Arg(50000)->Arg(200000)->Unit(benchmark::kMillisecond);

void BM_RayWalk(benchmark::State& state) {
  const BenchCloud bench(state.range(0), 0.25);
  const MergedCloud merged = bench.Merge();
  const Tetrahedralization complex = BuildDelaunay(merged.positions);
  size_t num_crossings = 0;
  for (auto _ : state) {
    state.PauseTiming();
    Tetrahedralization weighed = complex;
    state.ResumeTiming();
    num_crossings +=
        WeighCells(bench.scene.scene, merged, kWeights, kContext, &weighed).num_crossings;
  }
  state.SetItemsProcessed(static_cast<int64_t>(num_crossings));
}
BENCHMARK(BM_RayWalk)->Arg(50000)->Arg(200000)->Unit(benchmark::kMillisecond);

// Noise of a quarter of the points' distance, and as large as it.
void BM_Cut(benchmark::State& state) {
  const BenchCloud bench(state.range(0), 0.25 * static_cast<double>(state.range(1)));
  const MergedCloud merged = bench.Merge();
  Tetrahedralization complex = BuildDelaunay(merged.positions);
  WeighCells(bench.scene.scene, merged, kWeights, kContext, &complex);
  for (auto _ : state) {
    state.PauseTiming();
    std::vector<Cell> cells = complex.cells;
    state.ResumeTiming();
    benchmark::DoNotOptimize(MaximizeFlow(&cells, kContext));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(complex.cells.size()));
}
BENCHMARK(BM_Cut)
    ->Args({50000, 1})
    ->Args({200000, 1})
    ->Args({200000, 4})
    ->Unit(benchmark::kMillisecond);

// The whole stage on noise of a quarter of the points' distance, which is what merging at 2.35
// pixels leaves of stereo's: how time and memory grow with the number of vertices.
void BM_Mesh(benchmark::State& state) {
  const BenchCloud bench(state.range(0), 0.25);
  VisibilityMesherOptions options;
  options.merging.max_proj_dist = 0.1;
  VisibilityMesherResult result;
  for (auto _ : state) {
    state.PauseTiming();
    VisibilityCloud cloud = bench.cloud;
    state.ResumeTiming();
    result = MeshVisibilityCloud(bench.scene.scene, std::move(cloud), options, kContext);
  }
  const auto num_vertices = static_cast<double>(result.counters.num_vertices);
  for (const auto& [phase, seconds] : result.seconds) {
    state.counters[phase + "_us"] = 1e6 * seconds / num_vertices;
  }
  state.counters["bytes"] = static_cast<double>(result.measured_peak_bytes) / num_vertices;
  state.counters["predicted"] = static_cast<double>(result.predicted_peak_bytes) / num_vertices;
  state.counters["crossings"] =
      static_cast<double>(result.counters.rays.num_crossings) / num_vertices;
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(num_vertices));
}
BENCHMARK(BM_Mesh)->Arg(250000)->Arg(1000000)->Arg(4000000)->Iterations(1)->Unit(
    benchmark::kSecond);

}  // namespace
}  // namespace lsmvs

BENCHMARK_MAIN();
