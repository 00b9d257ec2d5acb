#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace lsmvs::internal {

// Reads a text file line by line and takes lines apart at blanks. A byte order mark is skipped;
// numbers may be written as numpy writes them (whole ones as 1.000000e+00, or np.float64(0.5)).
// Every failure throws InputError with path and line.
class TextReader {
 public:
  // `remedy` ends the messages.
  TextReader(const std::filesystem::path& path, std::string remedy);

  // Next line, without its end; false at the end of the file.
  bool NextLine();
  // Next line that is neither blank nor a comment (#); false at the end of the file.
  bool NextContentLine();
  // What is left of the line, without blanks on both sides.
  std::string_view RestOfLine() const;
  bool AtEndOfLine() const { return RestOfLine().empty(); }

  // Takes the next word of the line; fails if there is none.
  std::string_view Word();
  double Double();
  uint64_t Unsigned(uint64_t max);
  // All ones (2^64 - 1) is -1.
  int64_t Signed();
  // Takes a count of records that the rest of the line must have room for: one character and a
  // blank for each word.
  uint64_t Count(size_t words_per_record);
  void ExpectEndOfLine();

  // From 1; of the line that was read last.
  uint64_t line_number() const { return line_number_; }

  [[noreturn]] void Fail(const std::string& what) const;
  // What ends the messages from now on.
  void SetRemedy(std::string remedy) { remedy_ = std::move(remedy); }

 private:
  std::string path_, remedy_;
  std::ifstream file_;
  std::string line_;
  size_t next_ = 0;
  uint64_t line_number_ = 0;

  void SkipByteOrderMark();
  [[noreturn]] void FailNumber(std::string_view word) const;
};

}  // namespace lsmvs::internal
