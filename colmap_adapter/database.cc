#include "lsmvs/colmap_adapter/database.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

constexpr const char* kRemedy = "name the database.db that `colmap feature_extractor` made";
// COLMAP's pair_id = kMaxNumImages * smaller id + larger id.
constexpr uint64_t kMaxNumImages = 2147483647;

bool IsNotEmpty(const fs::path& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  return !error && size > 0;
}

fs::path WithSuffix(fs::path path, const char* suffix) {
  path += suffix;
  return path;
}

// A URI for SQLite. Without a journal beside it the file cannot be changing: "immutable" then
// spares the locks and the helper files that a database in WAL mode needs even for reading, so that
// a read-only folder will do.
std::string ReadOnlyUri(const fs::path& path) {
  const bool has_journal =
      IsNotEmpty(WithSuffix(path, "-wal")) || IsNotEmpty(WithSuffix(path, "-journal"));
  std::string uri = "file:";
  for (const char c : fs::absolute(path).string()) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) || std::strchr("/._-", c);
    uri += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri + (has_journal ? "?mode=ro" : "?mode=ro&immutable=1");
}

}  // namespace

struct ColmapDatabase::Connection {
  explicit Connection(const fs::path& database_path) : path(database_path.string()) {
    if (!fs::is_regular_file(database_path)) Fail("is missing or not a file");
    const int code = sqlite3_open_v2(ReadOnlyUri(database_path).c_str(), &handle,
                                     SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    if (code != SQLITE_OK) {
      const std::string reason = sqlite3_errmsg(handle);
      sqlite3_close(handle);
      Fail("cannot be opened as a database: " + reason);
    }
  }
  ~Connection() { sqlite3_close(handle); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[noreturn]] void Fail(const std::string& what) const { throw InputError(path, what, kRemedy); }

  std::string path;
  sqlite3* handle = nullptr;
};

namespace {

// A prepared SELECT; columns count from 0.
class Query {
 public:
  Query(sqlite3* handle, const std::string& path, const char* sql) : handle_(handle), path_(path) {
    if (sqlite3_prepare_v2(handle, sql, -1, &statement_, nullptr) != SQLITE_OK) FailSql();
  }
  ~Query() { sqlite3_finalize(statement_); }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  void Bind(int64_t value) { sqlite3_bind_int64(statement_, 1, value); }
  bool Next() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) FailSql();
    return code == SQLITE_ROW;
  }
  int64_t Int(int column) { return sqlite3_column_int64(statement_, column); }
  uint32_t Id(int column) {
    const int64_t id = Int(column);
    if (id < 0 || id > 0xffffffffll) Fail(fmt::format("has the impossible identifier {}", id));
    return static_cast<uint32_t>(id);
  }
  std::string Text(int column) {
    const unsigned char* text = sqlite3_column_text(statement_, column);
    return text == nullptr ? "" : reinterpret_cast<const char*>(text);
  }

  // A blob of rows x cols values of type T; the sizes come from the columns `rows_column` and the
  // one after it.
  template <class T>
  std::vector<T> Matrix(int rows_column, int blob_column, int64_t* rows, int64_t* cols) {
    *rows = Int(rows_column);
    *cols = Int(rows_column + 1);
    const auto num_bytes = static_cast<uint64_t>(sqlite3_column_bytes(statement_, blob_column));
    const uint64_t num_values = num_bytes / sizeof(T);
    const bool fits = *rows >= 0 && *cols >= 0 && num_bytes % sizeof(T) == 0 &&
                      (*cols == 0 || static_cast<uint64_t>(*rows) <= num_values) &&
                      (*rows == 0 || static_cast<uint64_t>(*cols) <= num_values) &&
                      static_cast<uint64_t>(*rows) * static_cast<uint64_t>(*cols) == num_values;
    if (!fits)
      Fail(fmt::format("has {} bytes where {} x {} values should be", num_bytes, *rows, *cols));
    std::vector<T> values(static_cast<size_t>(num_values));
    const void* blob = sqlite3_column_blob(statement_, blob_column);
    if (!values.empty()) std::memcpy(values.data(), blob, num_bytes);
    return values;
  }

  [[noreturn]] void Fail(const std::string& what) const { throw InputError(path_, what, kRemedy); }

 private:
  [[noreturn]] void FailSql() const {
    Fail(fmt::format("cannot be read as COLMAP's database: {}", sqlite3_errmsg(handle_)));
  }

  sqlite3* handle_;
  const std::string& path_;
  sqlite3_stmt* statement_ = nullptr;
};

// COLMAP stores x, y; or with scale and orientation; or with the matrix of the affine shape (a11
// a12 a21 a22).
ColmapDatabase::Keypoint ToKeypoint(const float* values, int64_t num_values) {
  ColmapDatabase::Keypoint keypoint;
  keypoint.x = {values[0], values[1]};
  if (num_values == 4) {
    const float scale = values[2], angle = values[3];
    keypoint.shape << scale * std::cos(angle), -scale * std::sin(angle), scale * std::sin(angle),
        scale * std::cos(angle);
  } else if (num_values == 6) {
    keypoint.shape << values[2], values[3], values[4], values[5];
  }
  return keypoint;
}

}  // namespace

ColmapDatabase::ColmapDatabase(const fs::path& path)
    : connection_(std::make_unique<Connection>(path)) {
  // Fails here, rather than later, if it is not a database or has not the tables.
  for (const char* sql :
       {"SELECT image_id, name, camera_id FROM images LIMIT 1",
        "SELECT image_id, rows, cols, data FROM keypoints LIMIT 1",
        "SELECT pair_id, rows, cols, data, config FROM two_view_geometries LIMIT 1"}) {
    Query(connection_->handle, connection_->path, sql).Next();
  }
}

ColmapDatabase::~ColmapDatabase() = default;

std::vector<ColmapDatabase::Image> ColmapDatabase::ReadImages() const {
  Query query(connection_->handle, connection_->path,
              "SELECT image_id, name, camera_id FROM images ORDER BY image_id");
  std::vector<Image> images;
  while (query.Next()) {
    images.push_back({ImageId{query.Id(0)}, query.Text(1), CameraId{query.Id(2)}});
  }
  return images;
}

std::vector<ColmapDatabase::Keypoint> ColmapDatabase::ReadKeypoints(ImageId image_id) const {
  Query query(connection_->handle, connection_->path,
              "SELECT rows, cols, data FROM keypoints WHERE image_id = ?");
  query.Bind(static_cast<int64_t>(image_id));
  if (!query.Next()) return {};
  int64_t rows = 0, cols = 0;
  const std::vector<float> values = query.Matrix<float>(0, 2, &rows, &cols);
  if (rows > 0 && cols != 2 && cols != 4 && cols != 6) {
    query.Fail(fmt::format("has keypoints of {} numbers instead of 2, 4 or 6", cols));
  }
  std::vector<Keypoint> keypoints;
  for (int64_t row = 0; row < rows; ++row) {
    keypoints.push_back(ToKeypoint(values.data() + row * cols, cols));
  }
  return keypoints;
}

std::vector<ColmapDatabase::TwoViewGeometry> ColmapDatabase::ReadTwoViewGeometries() const {
  Query query(connection_->handle, connection_->path,
              "SELECT pair_id, rows, cols, data, config FROM two_view_geometries "
              "WHERE rows > 0 ORDER BY pair_id");
  std::vector<TwoViewGeometry> geometries;
  while (query.Next()) {
    const auto pair_id = static_cast<uint64_t>(query.Int(0));
    const uint64_t id1 = pair_id / kMaxNumImages, id2 = pair_id % kMaxNumImages;
    if (id1 >= id2 || id1 > kMaxNumImages) {
      query.Fail(fmt::format("has the impossible pair {}", pair_id));
    }
    TwoViewGeometry geometry{ImageId{static_cast<uint32_t>(id1)},
                             ImageId{static_cast<uint32_t>(id2)},
                             static_cast<int>(query.Int(4)),
                             {}};
    int64_t rows = 0, cols = 0;
    const std::vector<uint32_t> values = query.Matrix<uint32_t>(1, 3, &rows, &cols);
    if (cols != 2) query.Fail(fmt::format("has matches of {} numbers instead of 2", cols));
    for (int64_t row = 0; row < rows; ++row) {
      geometry.inlier_matches.emplace_back(values[2 * row], values[2 * row + 1]);
    }
    geometries.push_back(std::move(geometry));
  }
  return geometries;
}

}  // namespace lsmvs
