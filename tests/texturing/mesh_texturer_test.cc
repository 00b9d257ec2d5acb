#include "lsmvs/texturing/mesh_texturer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lsmvs/image/rasterizer.h"
#include "lsmvs/image/sampling.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/util/error.h"
#include "plane_scene.h"

namespace lsmvs {
namespace {

using test::ForTexelsInFaces;
using test::Pattern;
using test::PlaneMesh;
using test::PlaneScene;
using testing::HasSubstr;

TEST(MeshTexturer, CopiesThePixelsOfAFacingPhoto) {
  PlaneScene plane;
  plane.AddPhoto({1, 0.75, 2.9}, Pattern);
  const TexturingResult result = plane.Texture(PlaneMesh(2, 1.5, 0, 12));
  std::string error;
  ASSERT_TRUE(result.textured.Check(&error)) << error;
  EXPECT_EQ(result.textured.mesh.faces.size(), 288u);
  EXPECT_EQ(result.num_faces_unseen, 0u);
  EXPECT_EQ(result.num_charts, 1u);
  const View& view = plane.scene.views[0];
  size_t count = 0;
  ForTexelsInFaces(result.textured, [&](size_t, double x, double y, int page, int column, int row) {
    const Eigen::Vector2d x_px =
        view.camera.Project(view.cam_from_world * Eigen::Vector3d(x, y, 0));
    const Color& pixel = plane.photos[0](static_cast<int>(x_px.x()), static_cast<int>(x_px.y()));
    EXPECT_NEAR(x_px.x() - std::floor(x_px.x()), 0.5, 1e-3);
    EXPECT_NEAR(x_px.y() - std::floor(x_px.y()), 0.5, 1e-3);
    EXPECT_EQ(plane.pages[static_cast<size_t>(page)](column, row), pixel);
    ++count;
  });
  const double pixels_per_unit = 200 / 2.9;
  EXPECT_NEAR(static_cast<double>(count), 3 * pixels_per_unit * pixels_per_unit, 200);
}

TEST(MeshTexturer, LeavesNoTexelBlack) {
  PlaneScene plane;
  plane.AddPhoto({1, 0.75, 2.9}, Pattern);
  plane.Texture(PlaneMesh(2, 1.5, 0, 12));
  for (const ColorImage& page : plane.pages) {
    for (const Color& texel : page.pixels) EXPECT_GT(texel.maxCoeff(), 0);
  }
}

// Photos of different exposure side by side: after correction all show the same colours, up to one
// factor.
TEST(MeshTexturer, BalancesExposure) {
  PlaneScene plane;
  for (int v = 0; v < 8; ++v) {
    const double gain = v % 2 == 0 ? 0.85 : 1.15;
    const Eigen::Vector3d center(0.25 + 0.5 * (v % 4), 0.4 + 0.7 * (v / 4), 2.0);
    plane.AddPhoto(center,
                   [&](double x, double y) -> Eigen::Vector3d { return gain * Pattern(x, y); });
  }
  const auto error_of = [&](bool correct) {
    MeshTexturerOptions options;
    options.apply_color_correction = correct;
    const TexturingResult result = plane.Texture(PlaneMesh(2, 1.5, 0, 60), options);
    EXPECT_EQ(result.gains_used, correct);
    EXPECT_EQ(result.num_faces_unseen, 0u);
    double texture_sum = 0, truth_sum = 0, squared = 0;
    size_t count = 0;
    const auto visit_all = [&](const auto& visit) {
      ForTexelsInFaces(result.textured, [&](size_t, double x, double y, int page, int column,
                                            int row) {
        visit(plane.pages[static_cast<size_t>(page)](column, row).cast<double>(), Pattern(x, y));
      });
    };
    visit_all([&](const Eigen::Vector3d& texel, const Eigen::Vector3d& truth) {
      texture_sum += texel.sum();
      truth_sum += truth.sum();
    });
    visit_all([&](const Eigen::Vector3d& texel, const Eigen::Vector3d& truth) {
      squared += (texel - texture_sum / truth_sum * truth).squaredNorm();
      count += 3;
    });
    return std::sqrt(squared / static_cast<double>(count));
  };
  EXPECT_GT(error_of(false), 10);
  EXPECT_LT(error_of(true), 2.5);
}

// A green disc hangs before the plane in two of six photos, and the mesh does not have it.
TEST(MeshTexturer, LeavesOutWhatOnlySomePhotosShow) {
  PlaneScene plane;
  for (int v = 0; v < 6; ++v) {
    const Eigen::Vector3d center(0.6 + 0.4 * (v % 3), 0.5 + 0.5 * (v / 3), 2.5 + 0.01 * v);
    plane.AddPhoto(center, [&](double x, double y) -> Eigen::Vector3d {
      const double middle = v == 1 ? 0.9 : 1.2;
      const bool is_hidden = (v == 1 || v == 4) && std::hypot(x - middle, y - 0.7) < 0.2;
      return is_hidden ? Eigen::Vector3d(0, 255, 0) : Pattern(x, y);
    });
  }
  const auto green_share = [&](bool reject) {
    MeshTexturerOptions options;
    options.reject_ghosts = reject;
    const TexturingResult result = plane.Texture(PlaneMesh(2, 1.5, 0, 80), options);
    size_t green = 0, count = 0;
    ForTexelsInFaces(result.textured, [&](size_t, double, double, int page, int column, int row) {
      const Color& c = plane.pages[static_cast<size_t>(page)](column, row);
      green += c[1] > 190 && c[0] < 90;
      ++count;
    });
    return static_cast<double>(green) / static_cast<double>(count);
  };
  EXPECT_LE(green_share(true), 0.001);
}

// Each photo has a twin that is blurred by some pixels.
TEST(MeshTexturer, PrefersSharpPhotos) {
  const auto sharp = [](double x, double y) -> Eigen::Vector3d {
    double sum = 0;
    for (int octave = 0; octave < 5; ++octave) {
      const double frequency = 4 << octave;
      sum += GradientNoise({frequency * x, frequency * y, 0.5}, 7);
    }
    return Eigen::Vector3d::Constant(128 + 50 * sum);
  };
  const auto blurred = [&](double x, double y) -> Eigen::Vector3d {
    constexpr double kStep = 0.4 / 80;  // 0.4 pixels
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int i = -4; i <= 4; ++i) {
      for (int j = -4; j <= 4; ++j) sum += sharp(x + kStep * i, y + kStep * j);
    }
    return sum / 81;
  };
  PlaneScene plane;
  for (int v = 0; v < 3; ++v) {
    const Eigen::Vector3d center(0.7 + 0.3 * v, 0.75, 2.5);
    plane.AddPhoto(center, blurred);
    plane.AddPhoto(center, sharp);
  }
  MeshTexturerOptions options;
  options.apply_color_correction = false;
  options.fade_width = 0;
  const TexturingResult result = plane.Texture(PlaneMesh(2, 1.5, 0, 40), options);
  size_t blurry = 0, count = 0;
  ForTexelsInFaces(result.textured, [&](size_t, double x, double y, int page, int column, int row) {
    const Eigen::Vector3d c = plane.pages[static_cast<size_t>(page)](column, row).cast<double>();
    const Eigen::Vector3d if_sharp = sharp(x, y), if_blurred = blurred(x, y);
    if ((if_sharp - if_blurred).norm() < 12) return;
    blurry += (c - if_blurred).norm() < (c - if_sharp).norm();
    ++count;
  });
  ASSERT_GT(count, 3000u);
  EXPECT_LE(static_cast<double>(blurry), 0.02 * static_cast<double>(count));
}

// A red bar before a wall. The mesh has both, but the bar one pixel aside.
TEST(MeshTexturer, DoesNotPaintTheWallWithTheBarBeforeIt) {
  constexpr double kBarHeight = 0.5, kWidth = 0.08;
  const auto mesh_with_bar_at = [&](double x) {
    TriangleMesh mesh = PlaneMesh(2, 1.5, 0, 60);
    TriangleMesh bar = PlaneMesh(kWidth, 1.5, kBarHeight, 10);
    for (Eigen::Vector3d& vertex : bar.vertices) vertex.x() += x - 0.5 * kWidth;
    const int first = static_cast<int>(mesh.vertices.size());
    for (const auto& vertex : bar.vertices) mesh.vertices.push_back(vertex);
    for (const auto& face : bar.faces) {
      mesh.faces.push_back((face.array() + first).matrix());
    }
    return mesh;
  };
  PlaneScene plane;
  for (int v = 0; v < 5; ++v) {
    const Eigen::Vector3d center(0.2 + 0.4 * v, 0.75, 2.2);
    plane.AddPhoto(center, [&](double x, double y) -> Eigen::Vector3d {
      // Where the ray to (x, y, 0) passes the height of the bar.
      const double at_bar = center.x() + (x - center.x()) * (1 - kBarHeight / center.z());
      if (std::abs(at_bar - 1) < 0.5 * kWidth) return {255, 0, 0};
      return Eigen::Vector3d(60, 150, 60) + 0.3 * Pattern(x, y);
    });
  }
  const double pixel = (2.2 - kBarHeight) / 200;
  const TexturingResult result = plane.Texture(mesh_with_bar_at(1 + pixel));
  const size_t num_wall_faces = 2 * 60 * 60;
  size_t red = 0, count = 0;
  ForTexelsInFaces(result.textured, [&](size_t f, double, double, int page, int column, int row) {
    if (f >= num_wall_faces) return;
    const Color& c = plane.pages[static_cast<size_t>(page)](column, row);
    red += c[0] > 180 && c[1] < 120;
    ++count;
  });
  EXPECT_LE(static_cast<double>(red), 0.001 * static_cast<double>(count));
}

// Whether nothing but the surface at this depth is within five pixels.
bool ShowsOpenly(const SurfaceMaps& maps, const Eigen::Vector2d& x_px, double depth) {
  const int column = static_cast<int>(x_px.x()), row = static_cast<int>(x_px.y());
  for (int y = row - 5; y <= row + 5; ++y) {
    for (int x = column - 5; x <= column + 5; ++x) {
      if (std::abs(maps.depth(x, y) - depth) > 0.03 * depth) return false;
    }
  }
  return true;
}

// Points of the surface: the texture is as near to the truth as the photo that shows them largest.
TEST(MeshTexturer, IsAsGoodAsTheBestPhoto) {
  const RunContext context(2);
  SyntheticScene s = MakeScene(ShapeName::kRelief, 8, 320, 240);
  s.photo.ambient = 1.0;
  TemporaryFolder folder;
  WritePhotos(*s.shape, s.photo, folder.path().string(), &s.scene, context);
  const auto images = MakeImageStore(s.scene, ImageStoreOptions());
  const TriangleMesh mesh = s.shape->Mesh(3 * s.gsd);
  std::vector<ColorImage> pages;
  const TexturingResult result = TextureMesh(
      s.scene, *images, mesh, "mesh.ply", {},
      [&](int, ColorImage&& page) {
        pages.push_back(std::move(page));
        return std::filesystem::path("page.png");
      },
      context);
  const SolidTexture texture(s.photo.texture);
  std::vector<SurfaceMaps> maps(s.scene.views.size());
  for (size_t v = 0; v < maps.size(); ++v) {
    const View& view = s.scene.views[v];
    RasterizeMesh(view.camera, view.cam_from_world, mesh.vertices, mesh.faces, {}, &maps[v]);
  }
  double of_texture = 0, of_photo = 0;
  size_t count = 0;
  for (size_t f = 0; f < mesh.faces.size(); f += 3) {
    const auto& uv = result.textured.texcoords[f];
    const Eigen::Vector3i& face = mesh.faces[f];
    const Eigen::Vector3d x =
        (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3;
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh, f).normalized();
    double best = 0;
    Eigen::Vector3f sample = Eigen::Vector3f::Zero();
    for (size_t v = 0; v < maps.size(); ++v) {
      const View& view = s.scene.views[v];
      const Eigen::Vector2d x_px = view.camera.Project(view.cam_from_world * x);
      // Faces at the border of a photo are not taken from it.
      constexpr double kMargin = 10;
      if (x_px.minCoeff() < kMargin || x_px.x() > view.camera.width - kMargin ||
          x_px.y() > view.camera.height - kMargin) {
        continue;
      }
      if (!ShowsOpenly(maps[v], x_px, view.Depth(x))) continue;
      const Eigen::Vector3d sight = view.CenterInWorld() - x;
      const double density = normal.dot(sight) / sight.squaredNorm();
      // What all photos see at a grazing angle has no texture to compare with.
      constexpr double kMinCosine = 0.4;
      if (density <= best || density * sight.norm() < kMinCosine) continue;
      best = density;
      sample = SampleColors(*images->Colors(static_cast<int>(v), 0), x_px.x(), x_px.y());
    }
    if (best == 0) continue;
    const Eigen::Vector3f truth = 255 * texture.Albedo(x, s.gsd);
    const Eigen::Vector2f middle = (uv[0] + uv[1] + uv[2]) / 3;
    const Eigen::Vector3f texel =
        SampleColors(pages[result.textured.page_idx[f]], middle.x(), middle.y());
    of_texture += (texel - truth).squaredNorm();
    of_photo += (sample - truth).squaredNorm();
    ++count;
  }
  ASSERT_GT(count, 1000u);
  EXPECT_LT(10 * std::log10(of_texture / of_photo), 0.3);
}

TEST(MeshTexturer, GivesTheSameBytesForThreadsAndBudgets) {
  PlaneScene plane;
  for (int v = 0; v < 6; ++v) {
    const Eigen::Vector3d center(0.6 + 0.4 * (v % 3), 0.5 + 0.5 * (v / 3), 2.0 + 0.1 * v);
    plane.AddPhoto(center, [&](double x, double y) -> Eigen::Vector3d {
      return (0.9 + 0.05 * v) * Pattern(x, y);
    });
  }
  MeshTexturerOptions options;
  options.max_page_size = 256;
  const TriangleMesh mesh = PlaneMesh(2.4, 1.5, 0, 50);
  const TexturingResult first = plane.Texture(mesh, options, 1);
  const std::vector<ColorImage> pages = plane.pages;
  const auto expect_same = [&](int num_threads, size_t budget) {
    const TexturingResult other = plane.Texture(mesh, options, num_threads, budget);
    EXPECT_EQ(other.textured.texcoords, first.textured.texcoords);
    EXPECT_EQ(other.textured.page_idx, first.textured.page_idx);
    ASSERT_EQ(plane.pages.size(), pages.size());
    for (size_t p = 0; p < pages.size(); ++p) EXPECT_EQ(plane.pages[p].pixels, pages[p].pixels);
  };
  expect_same(3, size_t{1} << 30);
  expect_same(2, 1);
}

TEST(MeshTexturer, TreatsUnseenFacesAsAsked) {
  PlaneScene plane;
  plane.AddPhoto({0.4, 0.75, 1.0}, [](double, double) { return Eigen::Vector3d(40, 80, 200); });
  const TriangleMesh mesh = PlaneMesh(2, 1.5, 0, 20);
  MeshTexturerOptions options;
  options.max_face_width = 0;
  const auto colors_of_right_end = [&](const TexturingResult& result) {
    std::vector<Color> colors;
    ForTexelsInFaces(result.textured, [&](size_t, double x, double, int page, int column, int row) {
      if (x < 1.5) return;
      colors.push_back(plane.pages[static_cast<size_t>(page)](column, row));
    });
    return colors;
  };
  const TexturingResult filled = plane.Texture(mesh, options);
  EXPECT_GT(filled.num_faces_unseen, 300u);
  EXPECT_NEAR(filled.unseen_area_share, static_cast<double>(filled.num_faces_unseen) / 800, 0.05);
  EXPECT_EQ(filled.textured.mesh.faces.size(), mesh.faces.size());
  ASSERT_FALSE(colors_of_right_end(filled).empty());
  for (const Color& c : colors_of_right_end(filled)) {
    EXPECT_LE((c.cast<int>() - Eigen::Vector3i(40, 80, 200)).cwiseAbs().maxCoeff(), 1);
  }
  options.unseen = UnseenFaces::kColor;
  options.unseen_color = "255,0,9";
  const TexturingResult colored = plane.Texture(mesh, options);
  for (const Color& c : colors_of_right_end(colored)) EXPECT_EQ(c, Color(255, 0, 9));
  options.unseen = UnseenFaces::kDrop;
  const TexturingResult dropped = plane.Texture(mesh, options);
  EXPECT_EQ(dropped.textured.mesh.faces.size(), mesh.faces.size() - dropped.num_faces_unseen);
  EXPECT_LT(dropped.textured.mesh.vertices.size(), mesh.vertices.size());
  std::string error;
  EXPECT_TRUE(dropped.textured.Check(&error)) << error;
}

TEST(MeshTexturer, MakesMorePagesWhereOneIsTooSmall) {
  PlaneScene plane;
  plane.AddPhoto({1, 0.75, 2.6}, Pattern);
  MeshTexturerOptions options;
  options.texture_scale_factor = 4;
  options.max_page_size = 256;
  const TexturingResult result = plane.Texture(PlaneMesh(2, 1.5, 0, 20), options);
  EXPECT_GT(result.textured.pages.size(), 3u);
  EXPECT_LE(result.textured.page_width, 256);
  std::string error;
  EXPECT_TRUE(result.textured.Check(&error)) << error;
  // Also where a single face is larger than a page.
  const TexturingResult coarse = plane.Texture(PlaneMesh(2, 1.5, 0, 1), options);
  EXPECT_TRUE(coarse.textured.Check(&error)) << error;
}

TEST(MeshTexturer, CapsTheDensityAtTheTexelSize) {
  PlaneScene plane;
  plane.AddPhoto({1, 0.75, 2.9}, Pattern);
  MeshTexturerOptions options;
  options.texel_size = 0.04;
  const TexturingResult result = plane.Texture(PlaneMesh(2, 1.5, 0, 12), options);
  size_t count = 0;
  ForTexelsInFaces(result.textured, [&](size_t, double, double, int, int, int) { ++count; });
  EXPECT_NEAR(static_cast<double>(count), 3 / (0.04 * 0.04), 120);
}

TEST(MeshTexturer, RefusesAMeshThatNoPhotoSees) {
  PlaneScene plane;
  plane.AddPhoto({1, 0.75, 2.9}, Pattern);
  TriangleMesh away = PlaneMesh(2, 1.5, 0, 4);
  for (Eigen::Vector3d& x : away.vertices) x.x() += 100;
  try {
    plane.Texture(away);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("mesh.ply"));
    EXPECT_THAT(error.what(), HasSubstr("no photo shows"));
  }
  EXPECT_THROW(plane.Texture(TriangleMesh()), InputError);
}

TEST(MeshTexturerOptions, HaveBounds) {
  std::string error;
  EXPECT_TRUE(MeshTexturerOptions().Check(&error));
  const auto refused = [&](const auto& change, const char* name) {
    MeshTexturerOptions options;
    change(&options);
    EXPECT_FALSE(options.Check(&error));
    EXPECT_THAT(error, HasSubstr(name));
  };
  refused([](auto* o) { o->texture_scale_factor = 0; }, "texture_scale_factor");
  refused([](auto* o) { o->max_page_size = 10000; }, "max_page_size");
  refused([](auto* o) { o->atlas_patch_padding = 0; }, "atlas_patch_padding");
  refused([](auto* o) { o->max_num_views = 0; }, "max_num_views");
  refused([](auto* o) { o->seam_cost = -1; }, "seam_cost");
  refused([](auto* o) { o->unseen_color = "1,2"; }, "unseen_color");
  refused([](auto* o) { o->unseen_color = "1,2,256"; }, "unseen_color");
}

}  // namespace
}  // namespace lsmvs
