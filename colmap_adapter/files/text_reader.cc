#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <type_traits>

#include "lsmvs/colmap_adapter/files/text_reader.h"
#include "lsmvs/util/error.h"

namespace lsmvs::internal {

namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

// The number in what numpy 2 prints of its own types: np.float64(0.5).
std::string_view WithoutNumpyType(std::string_view word) {
  if (!word.starts_with("np.") || !word.ends_with(')')) return word;
  const size_t open = word.find('(');
  if (open == std::string_view::npos) return word;
  return word.substr(open + 1, word.size() - open - 2);
}

// Value of the whole word; false if it is not one.
template <class T>
bool Parse(std::string_view word, T* value) {
  word = WithoutNumpyType(word);
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const auto [last, error] = std::from_chars(word.data(), end, *value);
  return error == std::errc() && last == end;
}

// A whole number that is written as a decimal one: 1.000000e+00.
template <class T>
bool ParseWhole(std::string_view word, T* value) {
  if (Parse(word, value)) return true;
  constexpr double kMaxExact = 0x1p53;
  double real = 0;
  if (!Parse(word, &real) || real != std::floor(real) || std::abs(real) > kMaxExact) return false;
  if (std::is_unsigned_v<T> && real < 0) return false;
  *value = static_cast<T>(real);
  return true;
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
  if (!std::getline(file_, line_)) return false;
  if (line_number_ == 1) SkipByteOrderMark();
  return true;
}

void TextReader::SkipByteOrderMark() {
  constexpr std::string_view kUtf8 = "\xef\xbb\xbf", kUtf16 = "\xff\xfe", kUtf16Big = "\xfe\xff";
  if (line_.starts_with(kUtf8)) next_ = kUtf8.size();
  if (line_.starts_with(kUtf16) || line_.starts_with(kUtf16Big)) {
    throw InputError(path_, "is UTF-16 text", "save it as UTF-8 or ASCII");
  }
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
  if (!Parse(word, &value)) FailNumber(word);
  return value;
}

void TextReader::FailNumber(std::string_view word) const {
  const std::string what = "has " + Quote(word) + " where a number should be";
  if (word.find(',') == std::string_view::npos) Fail(what);
  throw InputError(path_, fmt::format("line {}: {}", line_number_, what),
                   "write a point instead of a comma before decimals (export with LC_ALL=C)");
}

uint64_t TextReader::Unsigned(uint64_t max) {
  const std::string_view word = Word();
  uint64_t value = 0;
  if (!ParseWhole(word, &value) || value > max) {
    Fail(fmt::format("has {} where a whole number of at most {} should be", Quote(word), max));
  }
  return value;
}

int64_t TextReader::Signed() {
  const std::string_view word = Word();
  int64_t value = 0;
  if (word == "18446744073709551615") return -1;
  if (!ParseWhole(word, &value)) Fail("has " + Quote(word) + " where a whole number should be");
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
