#include "lsmvs/texturing/levelling/seam_levelling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lsmvs/test_support/grid_mesh.h"
#include "lsmvs/texturing/baking/seam_fades.h"
#include "lsmvs/texturing/labels/islands.h"
#include "lsmvs/texturing/unseen/fill_colors.h"

namespace lsmvs {
namespace {

// A plane whose left half is taken from photo 0 and whose right half from photo 1, which is
// brighter by 20; both show all of it.
class TwoPhotos : public testing::Test {
 protected:
  static constexpr int kSide = 31;

  TwoPhotos() : mesh_(GridMesh(kSide)), candidates_(mesh_.faces.size(), 2) {
    neighbors_ = FindFaceNeighbors(mesh_.faces, mesh_.vertices.size());
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      const bool is_left = FaceMiddle(mesh_, f).x() < (kSide - 1) / 2.0;
      for (int v = 0; v < 2; ++v) {
        Candidate candidate;
        candidate.view_idx = v;
        candidate.quality = (v == 0) == is_left ? 2.0f : 1.5f;
        candidate.color = Color::Constant(v == 0 ? 100 : 120);
        candidates_.Add(f, candidate, 2.0f);  // pixels per edge
      }
    }
    candidates_.Compact();
    slots_ = BestSlots(candidates_);
    for (size_t f = 0; f < slots_.size(); ++f) views_.push_back(Energy().ViewOf(slots_, f));
    nodes_ = FindLabelNodes(mesh_.faces, mesh_.vertices.size(), views_);
  }

  LabelEnergy Energy() const { return {mesh_, neighbors_, candidates_, 5.0}; }
  double ColorAt(size_t node, const std::vector<Eigen::Vector3f>& offsets) const {
    return (nodes_.label[node] == 0 ? 100 : 120) + offsets[node][1];
  }

  TriangleMesh mesh_;
  FaceNeighbors neighbors_;
  FaceCandidates candidates_;
  ViewSlots slots_;
  std::vector<int32_t> views_;
  LabelNodes nodes_;
};

TEST_F(TwoPhotos, MeetAtTheSeamAndKeepTheMean) {
  const LabelEnergy energy = Energy();
  EXPECT_EQ(nodes_.size(), mesh_.vertices.size() + kSide);
  const auto pairs = FindSeamPairs(energy, nodes_);
  ASSERT_EQ(pairs.size(), static_cast<size_t>(kSide));
  for (const SeamPair& pair : pairs) {
    EXPECT_TRUE(pair.is_known);
    EXPECT_NEAR(std::abs(pair.difference[0]), 20, 1e-4);
  }
  const auto offsets = LevelSeams(energy, nodes_, pairs, {});
  for (const SeamPair& pair : pairs) {
    EXPECT_NEAR(ColorAt(static_cast<size_t>(pair.first), offsets),
                ColorAt(static_cast<size_t>(pair.second), offsets), 1.5);
  }
  double mean = 0;
  for (size_t n = 0; n < nodes_.size(); ++n) {
    mean += ColorAt(n, offsets) / static_cast<double>(nodes_.size());
  }
  EXPECT_NEAR(mean, 109, 1.5);  // of all candidates, by quality: 100 and 120 with 2 to 1.5 each way
}

TEST_F(TwoPhotos, FadeIntoEachOtherNearTheSeam) {
  const LabelEnergy energy = Energy();
  const auto pairs = FindSeamPairs(energy, nodes_);
  const auto offsets = LevelSeams(energy, nodes_, pairs, {});
  const auto expect_width = [&](const std::vector<Eigen::Vector3f>& levelling, double width_px) {
    const SeamFades fades = FindSeamFades(energy, nodes_, levelling, 8.0);
    for (size_t v = 0; v < mesh_.vertices.size(); ++v) {
      const double from_seam = mesh_.vertices[v].x() - (kSide - 1) / 2.0;
      const double nearness =
          std::max(0.0, 1 - 2 * std::abs(from_seam) / width_px);  // 2 px an edge
      const double beyond = nearness / (1 + nearness);
      if (beyond == 0) {
        EXPECT_TRUE(fades.Of(v).empty());
        continue;
      }
      ASSERT_EQ(fades.Of(v).size(), 2u);
      for (const PhotoShare& share : fades.Of(v)) {
        const bool is_own = (share.view_idx == 0) == (from_seam < 0);
        EXPECT_NEAR(share.weight, is_own ? 1 - beyond : beyond, 1e-5);
      }
    }
  };
  expect_width(offsets, 8);
  // Photos that differ much are mixed within a quarter of the width.
  expect_width(std::vector<Eigen::Vector3f>(nodes_.size(), Eigen::Vector3f::Zero()), 2);
}

// Where one photo does not show the other side, both sides show the other photo at the seam.
TEST_F(TwoPhotos, ThePhotoThatSeesBothSidesIsShownAtTheSeam) {
  for (size_t f = 0; f < mesh_.faces.size(); ++f) {
    if (views_[f] == 0) candidates_.Filter(f, [](size_t k) { return k == 0; });
  }
  const std::vector<Eigen::Vector3f> level(nodes_.size(), Eigen::Vector3f::Zero());
  const SeamFades fades = FindSeamFades(Energy(), nodes_, level, 8.0);
  size_t num_at_seam = 0;
  for (size_t v = 0; v < mesh_.vertices.size(); ++v) {
    const double from_seam = mesh_.vertices[v].x() - (kSide - 1) / 2.0;
    if (from_seam < 0) {
      EXPECT_TRUE(fades.Of(v).empty());
    }
    if (from_seam != 0) continue;
    ASSERT_EQ(fades.Of(v).size(), 1u);
    EXPECT_EQ(fades.Of(v)[0].view_idx, 0);
    EXPECT_EQ(fades.Of(v)[0].weight, 1);
    ++num_at_seam;
  }
  EXPECT_EQ(num_at_seam, static_cast<size_t>(kSide));
}

TEST_F(TwoPhotos, SmallIslandsJoinThePhotoAround) {
  ViewSlots slots = slots_;
  slots[2] = slots[3] = 1 - slots_[2];  // 4 square pixels
  EXPECT_EQ(AbsorbIslands(Energy(), 3.0, &slots), 0u);
  EXPECT_NE(slots, slots_);
  EXPECT_EQ(AbsorbIslands(Energy(), 5.0, &slots), 1u);
  EXPECT_EQ(slots, slots_);
}

// An island that the photo around does not show as a whole: what it shows joins it.
TEST_F(TwoPhotos, FacesOfIslandsJoinWhatShowsThem) {
  ViewSlots slots = slots_;
  slots[2] = slots[3] = 1 - slots_[2];
  const int island_view = Energy().ViewOf(slots, 2);
  candidates_.Filter(2, [&](size_t k) { return candidates_.Of(2)[k].view_idx == island_view; });
  slots[2] = 0;
  EXPECT_EQ(AbsorbIslands(Energy(), 5.0, &slots), 0u);
  EXPECT_EQ(slots[2], 0);
  EXPECT_EQ(slots[3], slots_[3]);
}

TEST_F(TwoPhotos, ColoursSpreadHarmonicallyOverWhatNobodySees) {
  std::vector<int32_t> views = views_;
  for (size_t f = 0; f < views.size(); ++f) {
    const double x = FaceMiddle(mesh_, f).x();
    if (x > 5 && x < 25) views[f] = -1;
  }
  const LabelNodes nodes = FindLabelNodes(mesh_.faces, mesh_.vertices.size(), views);
  const std::vector<Eigen::Vector3f> offsets(nodes.size(), Eigen::Vector3f::Zero());
  const auto colors = HarmonicFillColors(Energy(), views, nodes, offsets);
  for (size_t v = 0; v < colors.size(); ++v) {
    const double x = mesh_.vertices[v].x();
    // The grid's diagonals all run one way: at its ends that tilts the colours.
    const bool is_middle = std::abs(mesh_.vertices[v].y() - (kSide - 1) / 2.0) < 2;
    if (x < 5 || x > 25) continue;
    EXPECT_NEAR(colors[v][0], 100 + (x - 5), is_middle ? 0.5 : 5.0);
  }
}

}  // namespace
}  // namespace lsmvs
