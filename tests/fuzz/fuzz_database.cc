#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/database.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  const auto path = fuzz::PutFile("database.db", fuzz::FuzzInput(data, size).Rest());
  fuzz::ExpectInputErrorAtMost([&] {
    const ColmapDatabase database(path);
    for (const auto& image : database.ReadImages()) database.ReadKeypoints(image.image_id);
    database.ReadTwoViewGeometries();
  });
  return 0;
}
