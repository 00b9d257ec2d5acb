#include "fuzz_input.h"
#include "lsmvs/image/image_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace lsmvs;
  const auto path = fuzz::PutFile("photo", fuzz::FuzzInput(data, size).Rest());
  fuzz::ExpectInputErrorAtMost([&] { InspectImageFile(path.string()); });
  return 0;
}
