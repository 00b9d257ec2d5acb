#include <fmt/format.h>

#include <charconv>

#include "lsmvs/colmap_adapter/text_reader_internal.h"
#include "lsmvs/util/error.h"

namespace lsmvs::internal {

namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

// Value of the whole word; false if it is not one.
template <class T>
bool Parse(std::string_view word, T* value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const auto [last, error] = std::from_chars(word.data(), end, *value);
  return error == std::errc() && last == end;
}

std::string Quote(std::string_view text) {
  constexpr size_t kMaxLength = 60;
  return fmt::format("'{}{}'", text.substr(0, kMaxLength), text.size() > kMaxLength ? "..." : "");
}

}  // namespace

TextReader::TextReader(const std::filesystem::path& path, std::string remedy)
    : path_(path.string()), remedy_(std::move(remedy)), file_(path, std::ios::binary) {
  if (!file_ || !std::filesystem::is_regular_file(path)) {
    throw InputError(path_, "cannot be opened as a file", remedy_);
  }
}

void TextReader::Fail(const std::string& what) const {
  throw InputError(path_, fmt::format("line {}: {}", line_number_, what), remedy_);
}

bool TextReader::NextLine() {
  next_ = 0;
  ++line_number_;
  return static_cast<bool>(std::getline(file_, line_));
}

bool TextReader::NextContentLine() {
  while (NextLine()) {
    const std::string_view content = RestOfLine();
    if (!content.empty() && content.front() != '#') return true;
  }
  return false;
}

std::string_view TextReader::RestOfLine() const {
  const std::string_view line = line_;
  const size_t first = line.find_first_not_of(kBlanks, next_);
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(kBlanks) + 1 - first);
}

std::string_view TextReader::Word() {
  const std::string_view line = line_;
  const size_t first = line.find_first_not_of(kBlanks, next_);
  if (first == std::string_view::npos) Fail("ends too early");
  next_ = std::min(line.find_first_of(kBlanks, first), line.size());
  return line.substr(first, next_ - first);
}

double TextReader::Double() {
  const std::string_view word = Word();
  double value = 0;
  if (!Parse(word, &value)) Fail("has " + Quote(word) + " where a number should be");
  return value;
}

uint64_t TextReader::Unsigned(uint64_t max) {
  const std::string_view word = Word();
  uint64_t value = 0;
  if (!Parse(word, &value) || value > max) {
    Fail(fmt::format("has {} where a whole number of at most {} should be", Quote(word), max));
  }
  return value;
}

int64_t TextReader::Signed() {
  const std::string_view word = Word();
  int64_t value = 0;
  if (!Parse(word, &value)) Fail("has " + Quote(word) + " where a whole number should be");
  return value;
}

uint64_t TextReader::Count(size_t words_per_record) {
  const uint64_t count = Unsigned(~uint64_t{0});
  const uint64_t room = (line_.size() - next_) / (2 * words_per_record);
  if (count > room) Fail(fmt::format("claims {} records, more than it has room for", count));
  return count;
}

void TextReader::ExpectEndOfLine() {
  if (!AtEndOfLine()) Fail("has " + Quote(RestOfLine()) + " where it should end");
}

}  // namespace lsmvs::internal
