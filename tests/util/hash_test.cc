#include "lsmvs/util/hash.h"

#include <gtest/gtest.h>

#include <string>

#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

std::string HashOf(const std::string& bytes, size_t piece) {
  Hasher hasher;
  for (size_t i = 0; i < bytes.size(); i += piece) {
    hasher.Update(bytes.data() + i, std::min(piece, bytes.size() - i));
  }
  return hasher.HexDigest();
}

TEST(Hash, DependsOnBytesOnly) {
  std::string bytes;
  for (int i = 0; i < 5000; ++i) bytes.push_back(static_cast<char>(i * 31 % 251));
  const std::string whole = HashOf(bytes, bytes.size());
  EXPECT_EQ(whole.size(), 32u);
  for (const size_t piece : {1u, 3u, 64u, 4999u}) EXPECT_EQ(HashOf(bytes, piece), whole);
  for (const size_t changed : {0u, 2500u, 4999u}) {
    std::string other = bytes;
    other[changed] ^= 1;
    EXPECT_NE(HashOf(other, 64), whole);
  }
}

TEST(Hash, TextsKeepTheirBorders) {
  const std::string a = Hasher().Update("ab").Update("c").HexDigest();
  const std::string b = Hasher().Update("a").Update("bc").HexDigest();
  EXPECT_NE(a, b);
  EXPECT_EQ(Hasher().HexDigest(), "99aa06d3014798d86001c324468d497f");  // XXH3-128 of nothing
}

TEST(Hash, FilesHashAsTheirBytes) {
  const TemporaryFolder folder;
  const std::string content(3000000, 'q');
  WriteFileAtomically(folder.path() / "f", content);
  EXPECT_EQ(HashFile(folder.path() / "f"), HashOf(content, content.size()));
  EXPECT_THROW(HashFile(folder.path() / "missing"), InputError);
  EXPECT_THROW(HashFile(folder.path()), InputError);
}

}  // namespace
}  // namespace lsmvs
