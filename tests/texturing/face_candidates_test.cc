#include "lsmvs/texturing/candidates/face_candidates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lsmvs {
namespace {

using testing::ElementsAre;

std::vector<int> Views(const FaceCandidates& candidates, size_t face) {
  std::vector<int> views;
  for (const Candidate& c : candidates.Of(face)) views.push_back(c.view_idx);
  return views;
}

TEST(FaceCandidates, KeepsTheBestInOrder) {
  FaceCandidates candidates(2, 3);
  const auto add = [&](int view, float quality) {
    Candidate candidate;
    candidate.view_idx = view;
    candidate.quality = quality;
    candidates.Add(1, candidate, 10 * quality);
  };
  add(0, 1);
  add(1, 3);
  add(2, 3);
  EXPECT_THAT(Views(candidates, 1), ElementsAre(1, 2, 0));
  add(3, 2);
  add(4, 0.5f);
  EXPECT_THAT(Views(candidates, 1), ElementsAre(1, 2, 3));
  EXPECT_TRUE(candidates.Of(0).empty());
  EXPECT_EQ(candidates.density(1), 30);
  candidates.Compact();
  EXPECT_EQ(candidates.num_candidates(), 3u);
  EXPECT_THAT(Views(candidates, 1), ElementsAre(1, 2, 3));
  candidates.Filter(1, [](size_t k) { return k != 1; });
  EXPECT_THAT(Views(candidates, 1), ElementsAre(1, 3));
  EXPECT_EQ(candidates.Find(1, 3)->quality, 2);
  EXPECT_EQ(candidates.Find(1, 2), nullptr);
}

}  // namespace
}  // namespace lsmvs
