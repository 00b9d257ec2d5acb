#include "lsmvs/util/option_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <system_error>
#include <type_traits>

#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

template <class T>
std::string ToText(const T& value) {
  return fmt::format("{}", value);
}

template <class T>
std::string BoundsText(const Range<T>& range) {
  const bool has_min = range.min != std::numeric_limits<T>::lowest();
  const bool has_max = range.max != std::numeric_limits<T>::max();
  if (!has_min && !has_max) return "";
  if (!has_max) return fmt::format(">= {}", range.min);
  if (!has_min) return fmt::format("<= {}", range.max);
  return fmt::format("[{}, {}]", range.min, range.max);
}

template <class T>
std::string Violation(const std::string& name, const T& value, const Range<T>& range) {
  // The negation is true for NaN as well.
  if (value >= range.min && value <= range.max) return "";
  const std::string bounds = BoundsText(range);
  return fmt::format("--{} is {}, but must be {}", name, value,
                     bounds.empty() ? "a finite number" : bounds);
}

template <class T>
T ParseNumber(const std::string& name, const std::string& text, const char* expected) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || last != end || text.empty()) {
    throw UsageError(fmt::format("--{} is '{}', but must be {}", name, text, expected));
  }
  return value;
}

template <class T>
constexpr const char* kTypeName = std::is_same_v<T, int> ? "INT" : "FLOAT";
template <class T>
constexpr const char* kExpected = std::is_same_v<T, int> ? "a whole number" : "a number";

bool ParseBool(const std::string& name, const std::string& text) {
  if (text == "1" || text == "true" || text == "yes" || text == "on") return true;
  if (text == "0" || text == "false" || text == "no" || text == "off") return false;
  throw UsageError(fmt::format("--{} is '{}', but must be 0 or 1", name, text));
}

template <class T>
T ParseInRange(const std::string& name, const std::string& text, const Range<T>& range) {
  const T parsed = ParseNumber<T>(name, text, kExpected<T>);
  const std::string violation = Violation(name, parsed, range);
  if (!violation.empty()) throw UsageError(violation);
  return parsed;
}

template <class T>
OptionSet::Entry NumberEntry(const std::string& name, T* value, const std::string& help,
                             const Range<T>& range) {
  OptionSet::Entry entry{name, help, kTypeName<T>, BoundsText(range), {}, {}, {}, {}};
  entry.get = [value] { return ToText(*value); };
  entry.set = [=](const std::string& text) { *value = ParseInRange<T>(name, text, range); };
  entry.violation = [=] { return Violation(name, *value, range); };
  return entry;
}

template <class T>
OptionSet::Entry OptionalEntry(const std::string& name, std::optional<T>* value,
                               const std::string& help, const Range<T>& range) {
  OptionSet::Entry entry{name, help, kTypeName<T>, BoundsText(range), {}, {}, {}, {}};
  entry.get = [value] { return value->has_value() ? ToText(**value) : std::string(); };
  entry.set = [=](const std::string& text) {
    if (text.empty()) {
      value->reset();
    } else {
      *value = ParseInRange<T>(name, text, range);
    }
  };
  entry.violation = [=] {
    return value->has_value() ? Violation(name, **value, range) : std::string();
  };
  return entry;
}

}  // namespace

void OptionSet::Push(Entry entry) {
  LSMVS_CHECK(Find(entry.name) == nullptr);
  entry.default_value = entry.get();
  if (!entry.violation) entry.violation = [] { return std::string(); };
  entries_.push_back(std::move(entry));
}

void OptionSet::Add(const std::string& name, bool* value, const std::string& help) {
  Entry entry{name, help, "BOOL", "", {}, {}, {}, {}};
  entry.get = [value] { return std::string(*value ? "1" : "0"); };
  entry.set = [=](const std::string& text) { *value = ParseBool(name, text); };
  Push(std::move(entry));
}

void OptionSet::Add(const std::string& name, int* value, const std::string& help,
                    Range<int> range) {
  Push(NumberEntry(name, value, help, range));
}

void OptionSet::Add(const std::string& name, double* value, const std::string& help,
                    Range<double> range) {
  Push(NumberEntry(name, value, help, range));
}

void OptionSet::Add(const std::string& name, std::string* value, const std::string& help) {
  Entry entry{name, help, "TEXT", "", {}, {}, {}, {}};
  entry.get = [value] { return *value; };
  entry.set = [=](const std::string& text) { *value = text; };
  Push(std::move(entry));
}

void OptionSet::Add(const std::string& name, std::vector<std::string>* values,
                    const std::string& help) {
  Entry entry{name, help, "TEXT", "", {}, {}, {}, {}};
  entry.get = [values] { return fmt::format("{}", fmt::join(*values, ", ")); };
  entry.set = [values](const std::string& text) { values->push_back(text); };
  entry.clear = [values] { values->clear(); };
  Push(std::move(entry));
}

void OptionSet::AddCommaList(const std::string& name, std::vector<std::string>* values,
                             const std::string& help) {
  Entry entry{name, help, "TEXT", "", {}, {}, {}, {}};
  entry.get = [values] { return fmt::format("{}", fmt::join(*values, ",")); };
  entry.set = [values](const std::string& text) {
    values->clear();
    std::istringstream stream(text);
    for (std::string value; std::getline(stream, value, ',');) values->push_back(value);
  };
  Push(std::move(entry));
}

void OptionSet::Add(const std::string& name, Eigen::AlignedBox3d* box, const std::string& help) {
  Entry entry{name, help, "TEXT", "", {}, {}, {}, {}};
  entry.get = [box] {
    if (box->isEmpty()) return std::string();
    const Eigen::Vector3d &min = box->min(), &max = box->max();
    return fmt::format("{},{},{},{},{},{}", min.x(), min.y(), min.z(), max.x(), max.y(), max.z());
  };
  entry.set = [=](const std::string& text) { *box = ParseBox(name, text); };
  Push(std::move(entry));
}

void OptionSet::Add(const std::string& name, std::optional<int>* value, const std::string& help,
                    Range<int> range) {
  Push(OptionalEntry(name, value, help, range));
}

void OptionSet::Add(const std::string& name, std::optional<double>* value, const std::string& help,
                    Range<double> range) {
  Push(OptionalEntry(name, value, help, range));
}

void OptionSet::AddChoice(const std::string& name, const std::string& help,
                          const std::vector<std::string>& choices, std::function<size_t()> get,
                          std::function<void(size_t)> set) {
  Entry entry{name, help, fmt::format("{}", fmt::join(choices, "|")), "", {}, {}, {}, {}};
  entry.get = [=] {
    const size_t i = get();
    return i < choices.size() ? choices[i] : std::string("?");
  };
  entry.set = [name, choices, set = std::move(set)](const std::string& text) {
    for (size_t i = 0; i < choices.size(); ++i) {
      if (choices[i] == text) return set(i);
    }
    throw UsageError(
        fmt::format("--{} is '{}', but must be one of {}", name, text, fmt::join(choices, ", ")));
  };
  entry.violation = [name, num_choices = choices.size(), get = std::move(get)] {
    return get() < num_choices ? std::string()
                               : fmt::format("--{} has a value outside its choices", name);
  };
  Push(std::move(entry));
}

void OptionSet::MarkRare(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto entry = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& e) { return e.name == name; });
    LSMVS_CHECK(entry != entries_.end());
    entry->is_rare = true;
  }
}

const OptionSet::Entry* OptionSet::Find(const std::string& name) const {
  for (const Entry& entry : entries_) {
    if (entry.name == name) return &entry;
  }
  return nullptr;
}

bool OptionSet::Check(std::string* error) const {
  for (const Entry& entry : entries_) {
    const std::string violation = entry.violation();
    if (!violation.empty()) {
      if (error != nullptr) *error = violation;
      return false;
    }
  }
  return true;
}

std::string OptionSet::ToText() const {
  std::string text;
  for (const Entry& entry : entries_) text += entry.name + "=" + entry.get() + "\n";
  return text;
}

Eigen::AlignedBox3d ParseBox(const std::string& option, const std::string& text) {
  Eigen::AlignedBox3d box;
  if (text.empty()) return box;
  std::string blanks = text;
  std::replace(blanks.begin(), blanks.end(), ',', ' ');
  std::istringstream numbers(blanks);
  std::array<double, 6> value{};
  for (double& number : value) numbers >> number;
  const bool complete = !numbers.fail() && (numbers >> std::ws).eof();
  box.min() = {value[0], value[1], value[2]};
  box.max() = {value[3], value[4], value[5]};
  if (!complete || !box.min().allFinite() || !box.max().allFinite() || box.isEmpty()) {
    throw UsageError(fmt::format(
        "--{} is '{}', but must be six numbers xmin,ymin,zmin,xmax,ymax,zmax with min <= max",
        option, text));
  }
  return box;
}

}  // namespace lsmvs
