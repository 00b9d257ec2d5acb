// Speed of the stereo kernels. "samples" are bilinear samples of a source image: the floor of
// PatchMatch is their number (hypotheses x views x samples a window) times the time of one.

#include <benchmark/benchmark.h>

#include <cmath>

#include "lsmvs/stereo/patch_match/matching_cost.h"
#include "lsmvs/stereo/quasi_dense/window.h"

namespace lsmvs {
namespace {

// A 1536 x 1024 reference and a source shifted along rows, walked tile by tile as a sweep does.
struct BenchScene {
  BenchScene() : gray(1536, 1024) {
    for (int row = 0; row < gray.height; ++row) {
      for (int column = 0; column < gray.width; ++column) {
        gray(column, row) =
            static_cast<float>(128 + 60 * std::sin(0.3 * column) * std::cos(0.2 * row));
      }
    }
    cells = PackedImage(gray);
    source.image = &cells;
    const float m[9] = {1, 0.01f, -0.5f, -0.01f, 1, -0.5f, 0, 0, 1};
    std::copy(m, m + 9, source.m);
    source.e[0] = 100;
    problem.gray = &gray;
    problem.weights = PatchWeights({}, 5.0, 51.0);
    for (int lane = 0; lane < kPacketSize; ++lane) {
      planes.q[lane] = 0.2f + 0.01f * static_cast<float>(lane % 3);
      planes.qx[lane] = planes.qy[lane] = 0.0005f;
    }
  }
  PacketPixels Pixels(int step) const {
    PacketPixels pixels;
    const int column = 64 + step * 8 % 1344, row = 64 + step * 8 / 1344 * 4 % 896;
    for (int lane = 0; lane < kPacketSize; ++lane) {
      pixels[static_cast<size_t>(lane)] = {column + 2 * (lane % 4) + (lane / 4 & 1),
                                           row + lane / 4};
    }
    return pixels;
  }
  GrayImage gray;
  PackedImage cells;
  SourceView source;
  MatchingProblem problem;
  PlanePacket planes;
};

void BM_ScorePacket(benchmark::State& state) {
  const BenchScene scene;
  PatchPacket patch;
  alignas(64) float zncc[kPacketSize];
  constexpr int kHypotheses = 40;
  int step = 0;
  for (auto _ : state) {
    state.PauseTiming();
    BuildPatch(scene.gray, scene.problem.weights, scene.Pixels(step++), &patch);
    state.ResumeTiming();
    for (int i = 0; i < kHypotheses; ++i) {
      ScorePacket(patch, scene.problem.weights.window, scene.planes, scene.source, 4.0f, zncc);
      benchmark::DoNotOptimize(zncc);
    }
  }
  const double samples = static_cast<double>(state.iterations()) * kHypotheses * kPacketSize *
                         scene.problem.weights.window.NumSamples();
  state.counters["samples"] = benchmark::Counter(samples, benchmark::Counter::kIsRate);
  state.SetLabel(ScorePacketTarget());
}
BENCHMARK(BM_ScorePacket);

void BM_BuildPatch(benchmark::State& state) {
  const BenchScene scene;
  PatchPacket patch;
  int step = 0;
  for (auto _ : state) {
    BuildPatch(scene.gray, scene.problem.weights, scene.Pixels(step++), &patch);
    benchmark::DoNotOptimize(patch);
  }
  state.SetItemsProcessed(state.iterations() * kPacketSize);
}
BENCHMARK(BM_BuildPatch);

void BM_ForwardBackwardError(benchmark::State& state) {
  const BenchScene scene;
  const PlaneMap map(768, 512, Plane{0.2f, 0, 0});
  SourcePlanes source;
  source.planes = &map;
  const float forward[9] = {0.5f, 0, 0, 0, 0.5f, 0, 0, 0, 1},
              backward[9] = {2, 0, 0, 0, 2, 0, 0, 0, 1};
  std::copy(forward, forward + 9, source.forward_m);
  std::copy(backward, backward + 9, source.backward_m);
  source.forward_e[0] = 50;
  source.backward_e[0] = -100;
  PatchPacket patch;
  BuildPatch(scene.gray, scene.problem.weights, scene.Pixels(1000), &patch);
  alignas(64) float error[kPacketSize];
  for (auto _ : state) {
    ForwardBackwardError(patch, scene.planes, source, 3.0f, error);
    benchmark::DoNotOptimize(error);
  }
  state.SetItemsProcessed(state.iterations() * kPacketSize);
}
BENCHMARK(BM_ForwardBackwardError);

// One window against candidates along an epipolar line, as quasi-dense matching scores them.
void BM_CompareWindow(benchmark::State& state) {
  const BenchScene scene;
  const PackedImage cells = PackedImage(scene.gray);
  const auto pattern = quasi_dense::MakeWindowPattern(static_cast<int>(state.range(0)));
  quasi_dense::WindowWarp warp{
      .x = 700, .y = 500, .xx = 1.05f, .xy = 0.1f, .yx = -0.1f, .yy = 0.9f};
  quasi_dense::ReferenceWindow reference;
  quasi_dense::ReadReferenceWindow(cells, pattern, warp, &reference);
  for (auto _ : state) {
    warp.x = warp.x < 900 ? warp.x + 0.5f : 500;
    benchmark::DoNotOptimize(quasi_dense::CompareWindow(cells, pattern, warp, reference));
  }
  const double samples = static_cast<double>(state.iterations()) * pattern.num_samples;
  state.counters["samples"] = benchmark::Counter(samples, benchmark::Counter::kIsRate);
  state.SetLabel(ScorePacketTarget());
}
BENCHMARK(BM_CompareWindow)->Arg(3)->Arg(5)->Arg(7);

}  // namespace
}  // namespace lsmvs

BENCHMARK_MAIN();
