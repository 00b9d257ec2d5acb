#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/depth_map_io.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  static const bool has_folders =
      std::filesystem::create_directories(fuzz::Folder() / "stereo/depth_maps") &&
      std::filesystem::create_directories(fuzz::Folder() / "stereo/normal_maps");
  if (!has_folders) return 0;
  fuzz::FuzzInput input(data, size);
  fuzz::PutFile("stereo/depth_maps/a.geometric.bin", input.NextPiece());
  fuzz::PutFile("stereo/normal_maps/a.geometric.bin", input.Rest());
  const DenseWorkspace workspace{fuzz::Folder()};
  const View view{ImageId{1}, "a", {64, 48, 50, 50, 32, 24}, Rigid3()};
  HasDepthMap(workspace, view, DepthMapKind::kGeometric);
  fuzz::ExpectInputErrorAtMost([&] { ReadDepthMap(workspace, view, DepthMapKind::kGeometric); });
  return 0;
}
