#include "lsmvs/texturing/labels/alpha_expansion.h"

#include <gtest/gtest.h>

#include "lsmvs/synthetic/random.h"
#include "lsmvs/test_support/grid_mesh.h"

namespace lsmvs {
namespace {

FaceCandidates RandomCandidates(size_t num_faces, int num_views, Random* random) {
  FaceCandidates candidates(num_faces, num_views);
  for (size_t f = 0; f < num_faces; ++f) {
    for (int v = 0; v < num_views; ++v) {
      if (v > 0 && random->Uniform() < 0.2) continue;
      Candidate candidate;
      candidate.view_idx = v;
      candidate.quality = static_cast<float>(random->Uniform(1, 3));
      const auto level = [&] { return static_cast<uint8_t>(100 + random->Below(24)); };
      candidate.color = Color(level(), level(), level());
      candidates.Add(f, candidate, 4.0f);
    }
  }
  candidates.Compact();
  return candidates;
}

int64_t Optimum(const LabelEnergy& energy, size_t num_faces) {
  ViewSlots slots = BestSlots(energy.candidates());
  int64_t best = energy.Total(slots);
  while (true) {
    size_t f = 0;
    while (f < num_faces && ++slots[f] == energy.candidates().Of(f).size()) slots[f++] = 0;
    if (f == num_faces) return best;
    best = std::min(best, energy.Total(slots));
  }
}

TEST(AlphaExpansion, ComesNearTheOptimumOfAllLabellings) {
  int num_optimal = 0;
  double sum = 0, optimum_sum = 0;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    TriangleMesh mesh = GridMesh(4);
    mesh.faces.resize(10);
    const FaceNeighbors neighbors = FindFaceNeighbors(mesh.faces, mesh.vertices.size());
    const FaceCandidates candidates = RandomCandidates(10, 3, &random);
    const LabelEnergy energy(mesh, neighbors, candidates, 3.0);
    ViewSlots slots = BestSlots(candidates);
    const int64_t before = energy.Total(slots);
    ExpandLabels(energy, {}, &slots, RunContext(1));
    const int64_t after = energy.Total(slots), optimum = Optimum(energy, 10);
    EXPECT_LE(after, before);
    EXPECT_LE(static_cast<double>(after), 1.2 * static_cast<double>(optimum));
    num_optimal += after == optimum;
    sum += static_cast<double>(after);
    optimum_sum += static_cast<double>(optimum);
  }
  EXPECT_LE(sum, 1.02 * optimum_sum);
  EXPECT_GE(num_optimal, 17);
}

// An expansion of a single label is the best of all moves of that kind: with two labels, the
// optimum.
TEST(AlphaExpansion, IsExactForTwoPhotos) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    TriangleMesh mesh = GridMesh(4);
    mesh.faces.resize(12);
    const FaceNeighbors neighbors = FindFaceNeighbors(mesh.faces, mesh.vertices.size());
    const FaceCandidates candidates = RandomCandidates(12, 2, &random);
    const LabelEnergy energy(mesh, neighbors, candidates, 3.0);
    ViewSlots slots = BestSlots(candidates);
    // From a labelling of one photo, the other's expansion reaches every labelling.
    for (size_t f = 0; f < slots.size(); ++f) {
      for (size_t k = 0; k < candidates.Of(f).size(); ++k) {
        if (candidates.Of(f)[k].view_idx == 0) slots[f] = static_cast<uint8_t>(k);
      }
    }
    ExpandLabels(energy, {}, &slots, RunContext(1));
    EXPECT_EQ(energy.Total(slots), Optimum(energy, 12));
  }
}

TEST(AlphaExpansion, BlocksNeitherRaiseTheEnergyNorDependOnThreads) {
  Random random(7);
  const TriangleMesh mesh = GridMesh(40);
  const FaceNeighbors neighbors = FindFaceNeighbors(mesh.faces, mesh.vertices.size());
  const FaceCandidates candidates = RandomCandidates(mesh.faces.size(), 6, &random);
  const LabelEnergy energy(mesh, neighbors, candidates, 3.0);
  const auto expand = [&](size_t faces_per_block, int num_threads) {
    ViewSlots slots = BestSlots(candidates);
    ExpansionOptions options;
    options.faces_per_block = faces_per_block;
    ExpandLabels(energy, options, &slots, RunContext(num_threads));
    return slots;
  };
  const int64_t before = energy.Total(BestSlots(candidates));
  const int64_t whole = energy.Total(expand(1 << 16, 1));
  const int64_t in_blocks = energy.Total(expand(200, 1));
  EXPECT_LT(whole, before);
  EXPECT_LT(static_cast<double>(in_blocks), 1.05 * static_cast<double>(whole));
  EXPECT_EQ(expand(200, 1), expand(200, 4));
}

TEST(LabelEnergy, PriceOfASeamIsAMetric) {
  Random random(3);
  const TriangleMesh mesh = GridMesh(8);
  const FaceNeighbors neighbors = FindFaceNeighbors(mesh.faces, mesh.vertices.size());
  const FaceCandidates candidates = RandomCandidates(mesh.faces.size(), 4, &random);
  const LabelEnergy energy(mesh, neighbors, candidates, 5.0);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int side = 0; side < 3; ++side) {
      const int32_t g = neighbors[f][static_cast<size_t>(side)];
      if (g < 0) continue;
      const auto is_shown = [&](int v) {
        return candidates.Find(f, v) != nullptr ||
               candidates.Find(static_cast<size_t>(g), v) != nullptr;
      };
      for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
          for (int c = 0; c < 4; ++c) {
            if (!is_shown(a) || !is_shown(b) || !is_shown(c)) continue;
            EXPECT_LE(energy.EdgeCost(f, side, a, b),
                      energy.EdgeCost(f, side, a, c) + energy.EdgeCost(f, side, c, b));
            EXPECT_EQ(energy.EdgeCost(f, side, a, b), energy.EdgeCost(f, side, b, a));
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace lsmvs
