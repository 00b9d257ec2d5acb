#pragma once

#include <memory>
#include <vector>

#include "lsmvs/image/image_store.h"
#include "lsmvs/scene/view_selection.h"
#include "lsmvs/synthetic/photo.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/truth.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs::quasi_dense {

// A synthetic scene with its photos on disk and what matching takes.
struct PhotoScene {
  PhotoScene(const SyntheticSceneOptions& options, double noise_sigma)
      : synthetic(MakeScene(options, RunContext(2))) {
    synthetic.photo.noise_sigma = noise_sigma;
    synthetic.photo.gain_sigma = 0.05;
    WritePhotos(*synthetic.shape, synthetic.photo, folder.path().string(), &synthetic.scene,
                RunContext(2));
    images = MakeImageStore(synthetic.scene, {});
    neighbors = SelectNeighbors(synthetic.scene, {}, RunContext(2));
  }

  TemporaryFolder folder;
  SyntheticScene synthetic;
  std::unique_ptr<ImageStore> images;
  std::vector<std::vector<Neighbor>> neighbors;
};

// Rendered once a program: a textured sphere, and a wall in relief with a floor.
inline const PhotoScene& SphereScene() {
  static const PhotoScene scene(
      {.shape = ShapeName::kSphere, .num_views = 10, .width = 200, .height = 150}, 1.0);
  return scene;
}
inline const PhotoScene& ReliefScene() {
  static const PhotoScene scene(
      {.shape = ShapeName::kRelief, .num_views = 6, .width = 240, .height = 180}, 1.0);
  return scene;
}

}  // namespace lsmvs::quasi_dense
