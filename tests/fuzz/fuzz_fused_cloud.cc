#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  fuzz::FuzzInput input(data, size);
  fuzz::PutFile("fused.ply.vis", input.NextPiece());
  const auto path = fuzz::PutFile("fused.ply", input.Rest());
  Scene scene;
  scene.views = {{ImageId{1}, "a", {64, 48, 50, 50, 32, 24}, Rigid3()},
                 {ImageId{2}, "b", {64, 48, 50, 50, 32, 24}, Rigid3()}};
  fuzz::ExpectInputErrorAtMost(
      [&] { ReadFusedCloud(path, scene, DenseWorkspace{fuzz::Folder()}); });
  return 0;
}
