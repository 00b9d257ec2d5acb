#include "lsmvs/surface/points/point_sorting.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <set>

namespace lsmvs {
namespace {

// Random points of a flat scene, of which some lie far out, with up to four views.
VisibilityCloud RandomCloud(size_t num_points, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  VisibilityCloud cloud;
  for (uint32_t p = 0; p < num_points; ++p) {
    Eigen::Vector3f x(10 * unit(random), 10 * unit(random), unit(random));
    if (p % 100 == 0) x *= 1000;
    std::vector<uint32_t> views;
    for (uint32_t view = 0; view < p % 5; ++view) views.push_back(p + view);
    cloud.Add(x, Eigen::Vector3f(0, 0, static_cast<float>(p)), Color(1, 2, static_cast<uint8_t>(p)),
              views);
  }
  return cloud;
}

TEST(PointSorting, MovesPointsWithAllTheyHave) {
  for (const size_t num_points : {0, 1, 2, 1000, 50000}) {
    const VisibilityCloud before = RandomCloud(num_points, num_points);
    VisibilityCloud cloud = before;
    const std::vector<uint32_t> places = SortByPlace(&cloud, RunContext(1));
    ASSERT_EQ(cloud.size(), num_points);
    ASSERT_EQ(std::set<uint32_t>(places.begin(), places.end()).size(), num_points);
    ASSERT_EQ(cloud.view_begin.size(), before.view_begin.size());
    for (size_t p = 0; p < num_points; ++p) {
      ASSERT_EQ(cloud.positions[places[p]], before.positions[p]);
      ASSERT_EQ(cloud.normals[places[p]], before.normals[p]);
      ASSERT_EQ(cloud.colors[places[p]], before.colors[p]);
      const auto views = cloud.ViewsOf(places[p]), views_before = before.ViewsOf(p);
      ASSERT_TRUE(std::equal(views.begin(), views.end(), views_before.begin(), views_before.end()));
    }
  }
}

TEST(PointSorting, PutsNeighborsTogether) {
  VisibilityCloud cloud = RandomCloud(100000, 1);
  SortByPlace(&cloud, RunContext(1));
  size_t num_far = 0;
  for (size_t p = 1; p < cloud.size(); ++p) {
    if (cloud.positions[p].norm() > 20 || cloud.positions[p - 1].norm() > 20) continue;
    num_far += (cloud.positions[p] - cloud.positions[p - 1]).norm() > 1;
  }
  EXPECT_LT(num_far, cloud.size() / 1000);
}

TEST(PointSorting, TakesPointsThatAreNotFiniteOrAllInOnePlace) {
  VisibilityCloud cloud;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float x : {1.0f, kNan, 1.0f, kInfinity, -kInfinity, 1.0f}) {
    cloud.Add(Eigen::Vector3f(x, 1, 1), Eigen::Vector3f::Zero(), Color::Zero(),
              std::vector<uint32_t>{3});
  }
  const std::vector<uint32_t> places = SortByPlace(&cloud, RunContext(1));
  EXPECT_EQ(std::set<uint32_t>(places.begin(), places.end()).size(), 6u);
}

}  // namespace
}  // namespace lsmvs
